//! What a cloth touches, as the user of the physics describes it.

use bevy::math::{DQuat, DVec3};
use bevy::reflect::Reflect;
use parry3d::shape::SharedShape;
use thiserror::Error;

use super::find::{LIFT, REACH};

/// Where a collider is, and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// World position of the origin of the shape, m.
    pub translation: DVec3,
    /// Rotation from the shape's frame to the world.
    pub rotation: DQuat,
}

impl Pose {
    /// At the origin, not turned.
    pub const IDENTITY: Self = Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// Not turned.
    pub const fn at(translation: DVec3) -> Self {
        Self { translation, rotation: DQuat::IDENTITY }
    }

    /// From the frame of the shape to the world.
    pub fn place(&self, local: DVec3) -> DVec3 {
        self.translation + self.rotation * local
    }

    /// From the world to the frame of the shape.
    pub fn local(&self, world: DVec3) -> DVec3 {
        self.rotation.inverse() * (world - self.translation)
    }

    /// A share of the way to another pose.
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        Self {
            translation: self.translation.lerp(other.translation, share),
            rotation: self.rotation.slerp(other.rotation, share),
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.translation.is_finite() && self.rotation.is_finite()
    }
}

/// A rigid shape, and its way through a step.
#[derive(Clone)]
pub struct Collider {
    /// Tells colliders apart from step to step: what a vertex remembers of a touch, it remembers by this.
    pub id: u64,
    /// Its shape, m.
    pub shape: SharedShape,
    /// Where it is when the step begins.
    pub start: Pose,
    /// Where it is when the step ends. Its velocity is what leads there.
    pub end: Pose,
    /// Coefficient of Coulomb friction of its surface. That of a pair is the geometric mean of both.
    pub friction: f64,
}

impl Collider {
    /// A collider that stands still.
    pub fn fixed(id: u64, shape: SharedShape, pose: Pose, friction: f64) -> Self {
        Self { id, shape, start: pose, end: pose, friction }
    }

    /// Checks poses and friction.
    ///
    /// # Errors
    /// The first that cannot be used.
    pub fn validate(&self) -> Result<(), ColliderError> {
        if !(self.start.is_finite() && self.end.is_finite()) {
            Err(ColliderError::Pose(self.id))
        } else if !(self.friction.is_finite() && self.friction >= 0.0) {
            Err(ColliderError::Friction { id: self.id, friction: self.friction })
        } else {
            Ok(())
        }
    }
}

/// A collider that cannot be used.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ColliderError {
    /// A number of its poses is NaN or infinite.
    #[error("the pose of collider {0} is not finite")]
    Pose(u64),
    /// Its friction is NaN, infinite or negative.
    #[error("the friction of collider {id} is {friction}: it must be finite and not negative")]
    Friction {
        /// [`Collider::id`].
        id: u64,
        /// [`Collider::friction`].
        friction: f64,
    },
}

impl core::fmt::Debug for Collider {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Collider")
            .field("id", &self.id)
            .field("shape", &self.shape.shape_type())
            .field("start", &self.start)
            .field("end", &self.end)
            .field("friction", &self.friction)
            .finish()
    }
}

/// How a cloth meets colliders.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactSettings {
    /// Distance that the cloth keeps from a collider's surface, m: the half of its own thickness, and room for errors. The vertices of
    /// cells that are coarse beside a ball or capsule keep up to three times that, so that what is between them does not cut into it.
    pub thickness: f64,
    /// Coefficient of Coulomb friction of the fabric. That of a pair is the geometric mean of both.
    pub friction: f64,
}

impl Default for ContactSettings {
    fn default() -> Self {
        Self { thickness: 3e-3, friction: 0.5 }
    }
}

/// A setting of contact that cannot be used.
#[derive(Clone, Copy, Debug, Error, PartialEq, Reflect)]
pub enum ContactSettingsError {
    /// The thickness is NaN, infinite, or not positive.
    #[error("the contact thickness is {0} m: it must be positive and finite")]
    Thickness(f64),
    /// The friction is NaN, infinite or negative.
    #[error("the friction is {0}: it must be finite and not negative")]
    Friction(f64),
}

impl ContactSettings {
    /// A place that no collider comes nearer to than this in a step is left alone in it, m.
    pub fn reach(&self) -> f64 {
        (REACH + LIFT) * self.thickness
    }

    /// Checks both.
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn validate(&self) -> Result<(), ContactSettingsError> {
        if !(self.thickness.is_finite() && self.thickness > 0.0) {
            Err(ContactSettingsError::Thickness(self.thickness))
        } else if !(self.friction.is_finite() && self.friction >= 0.0) {
            Err(ContactSettingsError::Friction(self.friction))
        } else {
            Ok(())
        }
    }
}

/// A touch of cloth and collider in the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The simulated vertices that touch: one, or those of a triangle that does so between them; the rest repeat the first.
    pub vertices: [u32; 3],
    /// Their shares, which sum to one.
    pub weights: [f64; 3],
    /// [`Collider::id`].
    pub collider: u64,
    /// Where the surface of the collider is touched, m.
    pub point: DVec3,
    /// Outward unit normal there.
    pub normal: DVec3,
    /// Force on the cloth, normal and friction together, N. The collider feels the opposite.
    pub force: DVec3,
}

impl Contact {
    /// With a share of its force.
    pub(crate) fn scaled(self, share: f64) -> Self {
        Self { force: share * self.force, ..self }
    }
}

/// One of each kind, of the same vertices and collider, with the sum of their forces; the rest is that of the first.
pub(crate) fn merged(contacts: impl Iterator<Item = Contact>) -> Vec<Contact> {
    let mut all: Vec<_> = contacts.collect();
    all.sort_by_key(|contact| (contact.collider, contact.vertices));
    all.dedup_by(|next, kept| {
        let same = (next.collider, next.vertices) == (kept.collider, kept.vertices);
        if same {
            kept.force += next.force;
        }
        same
    });
    all
}
