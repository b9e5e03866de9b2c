//! What the cloth touched, for games to read.

use bevy::prelude::*;

use crate::physics::Contact;
use crate::plugin::state::ClothState;

/// Optional, on a cloth: where it touched colliders in its last step. Filled in
/// [`ClothSystems::Step`](crate::plugin::ClothSystems::Step).
#[derive(Component, Clone, Debug, Default, PartialEq, Deref, Reflect)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothContacts(pub Vec<ClothTouch>);

/// A touch of a cloth and a collider.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, PartialEq)]
pub struct ClothTouch {
    /// The entity of the collider.
    pub collider: Entity,
    /// The simulated vertices that touch: one, or those of a triangle that does so between them; the rest repeat the first.
    pub vertices: [u32; 3],
    /// Their shares, which sum to one.
    pub weights: [f32; 3],
    /// Where the surface of the collider is touched, in the world, m.
    pub point: Vec3,
    /// Outward unit normal there.
    pub normal: Vec3,
    /// Force on the cloth, normal and friction together, N. The collider feels the opposite.
    pub force: Vec3,
}

impl ClothTouch {
    fn new(contact: Contact, state: &ClothState) -> Self {
        Self {
            collider: state.collider(contact.collider).unwrap_or(Entity::PLACEHOLDER),
            vertices: contact.vertices,
            weights: contact.weights.map(|weight| weight as f32),
            point: contact.point.as_vec3(),
            normal: contact.normal.as_vec3(),
            force: contact.force.as_vec3(),
        }
    }
}

/// Fills [`ClothContacts`] of cloths that took a step in this tick.
pub(in crate::plugin) fn tell(mut cloths: Query<(&ClothState, &mut ClothContacts)>) {
    for (state, mut contacts) in &mut cloths {
        if state.report_of_this_tick().is_none() {
            continue;
        }
        let mut touches = state.cloth.contacts().map(|contact| ClothTouch::new(contact, state)).peekable();
        if contacts.0.is_empty() && touches.peek().is_none() {
            continue;
        }
        contacts.0.clear();
        contacts.0.extend(touches);
    }
}
