//! How a cloth meets colliders, as a component.

use bevy::prelude::*;

use crate::physics::ContactSettings;

/// Optional: how a cloth meets colliders. May change at any time.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothContact {
    /// Distance that the cloth keeps from a collider's surface, m: the half of its own thickness, and room for errors. The vertices of
    /// cells that are coarse beside a ball or capsule keep up to three times that. 0.003 (3 mm) by default.
    pub thickness: f32,
    /// Coefficient of Coulomb friction of the fabric. That of a pair is the geometric mean of both. 0.5 by default.
    pub friction: f32,
}

impl Default for ClothContact {
    fn default() -> Self {
        let ContactSettings { thickness, friction } = ContactSettings::default();
        Self { thickness: thickness as f32, friction: friction as f32 }
    }
}

impl From<ClothContact> for ContactSettings {
    fn from(contact: ClothContact) -> Self {
        Self { thickness: contact.thickness.into(), friction: contact.friction.into() }
    }
}
