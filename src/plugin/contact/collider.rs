//! The component that makes an entity solid for cloth.

use core::fmt;

use bevy::prelude::*;
use parry3d::shape::SharedShape;

use super::error::ClothColliderError;
use super::track::Track;

/// A solid that cloth touches, where its entity is and as it moves.
///
/// The shape is scaled by the entity's transform; that of a moving entity meets cloth with the velocity that led it to its
/// present place. Kinematic: cloth does not push it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_cloth::plugin::ClothCollider;
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((Transform::from_xyz(0.0, 1.0, 0.0), ClothCollider::sphere(0.5).with_friction(0.3)));
/// commands.spawn(ClothCollider::half_space(Dir3::Y)); // a floor
/// # }
/// ```
#[derive(Component, Clone, Reflect)]
#[reflect(Component, Clone, Debug, from_reflect = false)]
#[require(Transform, Track)]
pub struct ClothCollider {
    /// Not reflected: a shape is one of many types.
    #[reflect(ignore)]
    shape: SharedShape,
    /// Coefficient of Coulomb friction of its surface. That of a pair is the geometric mean of both. 0.5 by default.
    pub friction: f32,
    /// A collider that moves further than this in one tick has jumped: it meets the cloth where it is, without a velocity, m.
    /// Infinity: never.
    pub teleport_distance: f32,
}

impl ClothCollider {
    /// Friction where none is given.
    pub(super) const FRICTION: f32 = 0.5;
    /// A jump where nothing is said of it, m.
    pub(super) const TELEPORT_DISTANCE: f32 = 2.0;

    /// Any shape of [`parry3d`].
    pub fn new(shape: SharedShape) -> Self {
        Self { shape, friction: Self::FRICTION, teleport_distance: Self::TELEPORT_DISTANCE }
    }

    /// Its shape before the entity scales it, m.
    pub fn shape(&self) -> &SharedShape {
        &self.shape
    }

    /// With another [`friction`](Self::friction).
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// With another [`teleport_distance`](Self::teleport_distance), m.
    pub fn with_teleport_distance(self, teleport_distance: f32) -> Self {
        Self { teleport_distance, ..self }
    }

    /// Refuses numbers that mean nothing.
    pub(super) fn validate(&self) -> Result<(), ClothColliderError> {
        if !(self.friction.is_finite() && self.friction >= 0.0) {
            Err(ClothColliderError::Friction(self.friction.to_string()))
        } else if self.teleport_distance >= 0.0 {
            Ok(())
        } else {
            Err(ClothColliderError::TeleportDistance(self.teleport_distance.to_string()))
        }
    }
}

impl From<SharedShape> for ClothCollider {
    fn from(shape: SharedShape) -> Self {
        Self::new(shape)
    }
}

impl fmt::Debug for ClothCollider {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("ClothCollider")
            .field("shape", &self.shape.shape_type())
            .field("friction", &self.friction)
            .field("teleport_distance", &self.teleport_distance)
            .finish()
    }
}
