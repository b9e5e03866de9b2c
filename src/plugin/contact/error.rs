//! What can be wrong with a collider, and what to do about it.

use bevy::ecs::name::NameOrEntityItem;
use bevy::prelude::*;
use thiserror::Error;

use crate::plugin::error::ClothError;

/// Why there is no shape.
#[derive(Clone, Debug, Error, PartialEq, Reflect)]
pub enum ClothShapeError {
    /// There are no triangles, heights or parts.
    #[error("there is nothing in it: {0} are needed")]
    Empty(String),
    /// A coordinate is NaN or infinite.
    #[error("point {0} is not finite")]
    NotFinite(usize),
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are {count} vertices")]
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The vertex named.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A hull needs points that are not in one plane.
    #[error("the points have no hull: four or more are needed that are not in one plane")]
    NoHull,
    /// The rows of a field of heights differ in length.
    #[error("row {row} has {found} heights, but the first has {expected}")]
    Uneven {
        /// The row.
        row: usize,
        /// Its length.
        found: usize,
        /// That of the first.
        expected: usize,
    },
    /// A half-space needs a normal.
    #[error("the normal {0} of the half-space has no direction")]
    Normal(Vec3),
    /// A part of a compound is a surface of triangles.
    #[error(
        "part {part} is a surface of triangles, which cannot be part of a compound: spawn it as a collider of its own"
    )]
    Part {
        /// The part.
        part: usize,
    },
    /// [`ClothShape::Undescribed`](super::ClothShape::Undescribed) was loaded, or set.
    #[error(
        "the shape was not saved, as it is of a kind that `ClothShape` does not describe: insert the `ClothCollider` \
         again after loading, or build it of another shape"
    )]
    Undescribed,
    /// The mesh cannot be read.
    #[error("{0}")]
    Mesh(String),
}

impl From<ClothError> for ClothShapeError {
    fn from(error: ClothError) -> Self {
        Self::Mesh(match error {
            ClothError::Positions { found } => {
                format!("the positions of the mesh are {found}: `Mesh::ATTRIBUTE_POSITION` is needed as Float32x3")
            }
            ClothError::Topology { topology } => {
                format!("the mesh is a {topology}: a TriangleList or TriangleStrip is needed")
            }
            other => other.to_string(),
        })
    }
}

/// Why a [`ClothCollider`](super::ClothCollider) is not there for cloth.
///
/// Inserted on its entity and logged once; removed again when the cause is gone.
#[derive(Component, Clone, Debug, Error, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ClothColliderError {
    /// The transform is not finite, or squashes the shape.
    #[error("the transform of the collider is not finite or has a scale of zero")]
    Transform,
    /// The friction is NaN, infinite or negative.
    #[error("`ClothCollider::friction` is {0}: it must be finite and not negative")]
    Friction(String),
    /// The speed is NaN or negative.
    #[error("`ClothCollider::teleport_speed` is {0}: it must not be negative")]
    TeleportSpeed(String),
    /// The shape has no extent, a negative one, or one that is not finite.
    #[error("the shape of the collider is empty or not finite: look for sizes that are zero, negative or NaN")]
    Shape,
    /// The shape cannot be scaled.
    #[error(
        "a {shape} cannot be scaled by {scale}: give its entity a scale of one, or build the shape as large as it is"
    )]
    Scale {
        /// Name of the kind of shape.
        shape: String,
        /// The scale.
        scale: Vec3,
    },
    /// The shape cannot be sheared.
    #[error(
        "a {shape} cannot be sheared, and its entity is: it is turned under a parent that is not scaled evenly; give that parent an \
         even scale, or the collider another shape"
    )]
    Shear {
        /// Name of the kind of shape.
        shape: String,
    },
    /// The mesh beside [`ClothMeshCollider`](super::ClothMeshCollider) is skinned.
    #[error(
        "the mesh is skinned: bones move what is drawn, and a collider would stay as the mesh was bound; remove `ClothMeshCollider`, and \
         put `ClothCollider::capsule_between` on the entities of the bones instead"
    )]
    Skinned,
    /// A shape of a physics engine that has no equal here.
    #[error("a {shape} cannot be taken over from the physics engine: add a `ClothCollider` of another shape instead")]
    Unsupported {
        /// Name of the kind of shape.
        shape: String,
    },
    /// There is no [`Mesh3d`] beside [`ClothMeshCollider`](super::ClothMeshCollider).
    #[error("there is no mesh: add `Mesh3d` beside `ClothMeshCollider`")]
    NoMesh,
    /// The mesh asset failed to load.
    #[error("the mesh did not load: {0}")]
    MeshNotLoaded(String),
    /// The mesh cannot be a collider.
    #[error(transparent)]
    Mesh(#[from] ClothShapeError),
}

/// Brings the [`ClothColliderError`] of an entity up to date, and logs a new one.
pub(super) fn report(
    commands: &mut Commands,
    name: &NameOrEntityItem,
    shown: Option<&ClothColliderError>,
    error: Option<ClothColliderError>,
) {
    if shown == error.as_ref() {
        return;
    }
    let Ok(mut entity) = commands.get_entity(name.entity) else { return };
    if let Some(error) = error {
        tracing::error!("cloth collider {name}: {error}");
        entity.try_insert(error);
    } else {
        entity.try_remove::<ClothColliderError>();
    }
}
