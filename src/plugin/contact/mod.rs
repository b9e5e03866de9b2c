//! What cloth touches: colliders as components, and who touches whom.
//!
//! A [`ClothCollider`] ([`collider`], its forms in [`shapes`]; from a mesh asset by [`mesh`]) is scaled as its entity is
//! ([`scale`]) and its way through the last ticks is kept ([`track`]). Before each step of a cloth, those near it ([`bounds`],
//! [`give`]) that it may touch ([`layers`]) go to the physics, with the pose at the cloth's last step and the present one.
//! After the step, the touches come back ([`touches`]). With the features `avian3d` and `rapier3d`, colliders of these engines
//! become colliders of cloth.

#[cfg(feature = "avian3d")]
pub(super) mod avian;
mod bounds;
mod collider;
mod description;
#[cfg(any(feature = "avian3d", feature = "rapier3d"))]
mod engines;
mod error;
mod give;
mod hull;
mod kind;
mod layers;
mod mesh;
#[cfg(feature = "avian3d")]
pub(super) mod pushes;
#[cfg(feature = "rapier3d")]
pub(super) mod rapier;
mod scale;
mod settings;
mod shapes;
mod shear;
mod surface;
mod touches;
mod track;
mod winding;

pub use collider::ClothCollider;
pub(super) use collider::rebuild;
pub use description::{ClothShape, ClothShapePart};
#[cfg(any(feature = "avian3d", feature = "rapier3d"))]
pub use engines::ClothPhysicsCollider;
#[cfg(any(feature = "avian3d", feature = "rapier3d"))]
pub(super) use engines::end_mark;
pub use error::{ClothColliderError, ClothShapeError};
pub(super) use give::{Met, Surroundings, give};
pub use kind::ClothColliderKind;
pub use layers::{ClothCollidesWith, ClothLayers};
pub use mesh::{ClothMeshCollider, ClothMeshShape};
pub(super) use mesh::{end as end_mesh, shape_meshes};
#[cfg(feature = "avian3d")]
pub use pushes::ClothPushes;
pub use settings::ClothContact;
pub(super) use touches::tell;
pub use touches::{ClothContacts, ClothTouch};
pub(super) use track::{Track, end, placed, track};

use bevy::prelude::*;

/// Whether there is a collider, or a cloth that still has one from before.
pub(super) fn is_wanted(colliders: Query<(), With<ClothCollider>>, surroundings: Res<Surroundings>) -> bool {
    !colliders.is_empty() || surroundings.held
}
