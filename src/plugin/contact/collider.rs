//! The component that makes an entity solid for cloth.

use core::fmt;

use std::sync::Arc;

use bevy::prelude::*;
use parry3d::shape::SharedShape;

use super::description::{ClothShape, ClothShapePart};
#[cfg(any(feature = "avian3d", feature = "rapier3d"))]
use super::engines::ClothPhysicsCollider;
use super::error::{ClothColliderError, ClothShapeError};
use super::mesh::ClothMeshCollider;
use super::track::Track;
use crate::plugin::id::give_later;

/// A solid that cloth touches, where its entity is and as it moves.
///
/// The shape is scaled by the entity's transform. A moving collider meets cloth with the velocity of its way since the last step.
/// It is kinematic: cloth does not push it (but see `ClothPushes`, for bodies of Avian).
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
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[cfg_attr(feature = "serialize", serde(from = "Written", into = "Written"))]
#[reflect(from_reflect = false)]
#[reflect(Component, Default, FromReflect, Clone, Debug, PartialEq)]
#[require(Transform, Track)]
#[component(on_add = give_later)]
pub struct ClothCollider {
    /// See [`description`](Self::description). Other shapes take effect in the next tick, when edited by reflection.
    shape: ClothShape,
    #[reflect(ignore)]
    built: Built,
    /// Coefficient of Coulomb friction of its surface. That of a pair is the geometric mean of both. 0.5 by default.
    pub friction: f32,
    /// A collider that moves faster than this has jumped: it meets the cloth where it is, without a velocity, m/s. 100 by default:
    /// an arrow, the fastest thing that is shot at cloth and seen, flies at 60 to 90, while a jump of 2 m within a tick of 1/64 s is
    /// one of 128. The limit is one of speed, so that it does not depend on the length of a tick. Infinity: never.
    ///
    /// Slower jumps are told by [`ClothTeleport`](crate::plugin::ClothTeleport).
    pub teleport_speed: f32,
}

/// What a description was made into.
#[derive(Clone)]
struct Built {
    shape: SharedShape,
    /// [`ClothShape::key`] of the description.
    of: u64,
    /// Why it could not be made: the shape is then of no account.
    error: Option<ClothShapeError>,
}

impl Built {
    fn new(description: &ClothShape) -> Self {
        let (shape, error) = match description.build() {
            Ok(shape) => (shape, None),
            Err(error) => (SharedShape::ball(0.0), Some(error)),
        };
        Self { shape, of: description.key(), error }
    }
}

impl Default for ClothCollider {
    /// A [ball](ClothShape::default) of 1 m across.
    fn default() -> Self {
        Self::described(ClothShape::default())
    }
}

impl PartialEq for ClothCollider {
    fn eq(&self, other: &Self) -> bool {
        self.shape == other.shape
            && self.friction == other.friction
            && self.teleport_speed == other.teleport_speed
            && (self.shape != ClothShape::Undescribed || Arc::ptr_eq(&self.built.shape.0, &other.built.shape.0))
    }
}

impl FromReflect for ClothCollider {
    fn from_reflect(reflect: &dyn PartialReflect) -> Option<Self> {
        if let Some(collider) = reflect.try_downcast_ref::<Self>() {
            return Some(collider.clone());
        }
        let fields = reflect.reflect_ref().as_struct().ok()?;
        let number = |name: &str| fields.field(name).and_then(f32::from_reflect);
        let shape = fields.field("shape").map_or_else(|| Some(ClothShape::default()), ClothShape::from_reflect)?;
        Some(Self {
            friction: number("friction").unwrap_or(Self::FRICTION),
            teleport_speed: number("teleport_speed").unwrap_or(Self::TELEPORT_SPEED),
            ..Self::described(shape)
        })
    }
}

/// A collider as serde writes it.
#[cfg(feature = "serialize")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "ClothCollider")]
struct Written {
    shape: ClothShape,
    #[serde(default = "friction")]
    friction: f32,
    #[serde(default = "teleport_speed")]
    teleport_speed: f32,
}

#[cfg(feature = "serialize")]
fn friction() -> f32 {
    ClothCollider::FRICTION
}

#[cfg(feature = "serialize")]
fn teleport_speed() -> f32 {
    ClothCollider::TELEPORT_SPEED
}

#[cfg(feature = "serialize")]
impl From<Written> for ClothCollider {
    fn from(Written { shape, friction, teleport_speed }: Written) -> Self {
        Self { friction, teleport_speed, ..Self::described(shape) }
    }
}

#[cfg(feature = "serialize")]
impl From<ClothCollider> for Written {
    fn from(ClothCollider { shape, friction, teleport_speed, .. }: ClothCollider) -> Self {
        Self { shape, friction, teleport_speed }
    }
}

impl ClothCollider {
    /// Friction where none is given.
    pub(super) const FRICTION: f32 = 0.5;
    /// A jump where nothing is said of it, m/s.
    pub(super) const TELEPORT_SPEED: f32 = 100.0;

    /// Any shape of [`parry3d`]. It is saved and reflected as the [`ClothShape`] that it is, or
    /// [not at all](ClothShape::Undescribed).
    pub fn new(shape: SharedShape) -> Self {
        let description = ClothShape::of(&shape);
        Self::of_both(description, shape)
    }

    /// As [`new`](Self::new), of a shape that something else describes.
    pub(super) fn undescribed(shape: SharedShape) -> Self {
        Self::of_both(ClothShape::Undescribed, shape)
    }

    /// A compound of parts, which is described if all of them are.
    pub(super) fn compound_of(parts: Vec<ClothShapePart>, shape: SharedShape) -> Self {
        let described = parts.iter().all(|part| part.shape != ClothShape::Undescribed);
        Self::of_both(if described { ClothShape::Compound { parts } } else { ClothShape::Undescribed }, shape)
    }

    fn of_both(description: ClothShape, shape: SharedShape) -> Self {
        let of = description.key();
        Self::with(description, Built { shape, of, error: None })
    }

    fn with(shape: ClothShape, built: Built) -> Self {
        Self { shape, built, friction: Self::FRICTION, teleport_speed: Self::TELEPORT_SPEED }
    }

    /// Of a shape that can be, or else says in time that it cannot.
    pub(super) fn described(shape: ClothShape) -> Self {
        let built = Built::new(&shape);
        Self::with(shape, built)
    }

    /// A collider of a shape that is described in numbers.
    ///
    /// # Errors
    /// If there is no such shape: see the constructors.
    pub fn from_shape(shape: ClothShape) -> Result<Self, ClothShapeError> {
        let collider = Self::described(shape);
        match collider.built.error {
            Some(error) => Err(error),
            None => Ok(collider),
        }
    }

    /// Its shape before the entity scales it, m. A ball without extent if a description was loaded that is of none.
    pub fn shape(&self) -> &SharedShape {
        &self.built.shape
    }

    /// Its shape in numbers.
    pub fn description(&self) -> &ClothShape {
        &self.shape
    }

    /// With another [`friction`](Self::friction).
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    /// With another [`teleport_speed`](Self::teleport_speed), m/s.
    pub fn with_teleport_speed(self, teleport_speed: f32) -> Self {
        Self { teleport_speed, ..self }
    }

    /// Refuses numbers that mean nothing.
    pub(super) fn validate(&self) -> Result<(), ClothColliderError> {
        if let Some(error) = &self.built.error {
            Err(error.clone().into())
        } else if !(self.friction.is_finite() && self.friction >= 0.0) {
            Err(ClothColliderError::Friction(self.friction.to_string()))
        } else if self.teleport_speed >= 0.0 {
            Ok(())
        } else {
            Err(ClothColliderError::TeleportSpeed(self.teleport_speed.to_string()))
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
            .field("shape", &self.built.shape.shape_type())
            .field("friction", &self.friction)
            .field("teleport_speed", &self.teleport_speed)
            .finish()
    }
}

#[cfg(any(feature = "avian3d", feature = "rapier3d"))]
type MadeAgain = Or<(With<ClothMeshCollider>, With<ClothPhysicsCollider>)>;
#[cfg(not(any(feature = "avian3d", feature = "rapier3d")))]
type MadeAgain = With<ClothMeshCollider>;

/// Builds shapes whose descriptions were edited by reflection, and takes away those that were not saved and will be made again.
pub(in crate::plugin) fn rebuild(
    mut commands: Commands,
    mut edited: Query<(Entity, &mut ClothCollider), Changed<ClothCollider>>,
    made_again: Query<(), MadeAgain>,
) {
    for (entity, mut collider) in &mut edited {
        let collider = collider.bypass_change_detection();
        if collider.built.of != collider.shape.key() {
            collider.built = Built::new(&collider.shape);
        }
        if collider.built.error == Some(ClothShapeError::Undescribed)
            && made_again.contains(entity)
            && let Ok(mut entity) = commands.get_entity(entity)
        {
            entity.try_remove::<ClothCollider>();
        }
    }
}
