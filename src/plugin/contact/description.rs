//! What a collider's shape is, in numbers that can be reflected, saved and edited.

use core::hash::Hasher;
use std::hash::DefaultHasher;

use bevy::prelude::*;
use parry3d::math::Pose;
use parry3d::shape::{HeightField, HeightFieldCellStatus, SharedShape, TypedShape};
use parry3d::utils::Array2;

use super::error::ClothShapeError;
use super::hull::hull;
use super::surface::surface;

/// The shape of a [`ClothCollider`](super::ClothCollider), before the transform of its entity scales it. Sizes are in metres;
/// unless it says otherwise, a shape is centred at the origin of the entity.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(no_field_bounds)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum ClothShape {
    /// A ball.
    Sphere {
        /// m.
        radius: f32,
    },
    /// Two half balls around `a` and `b`, and what is between them.
    Capsule {
        /// Centre of one half ball.
        a: Vec3,
        /// Centre of the other.
        b: Vec3,
        /// m.
        radius: f32,
    },
    /// A box.
    Cuboid {
        /// Whole sizes along X, Y and Z.
        size: Vec3,
    },
    /// A cylinder along Y.
    Cylinder {
        /// m.
        radius: f32,
        /// m.
        height: f32,
    },
    /// A cone along Y, its tip up; the origin is half way up.
    Cone {
        /// m.
        radius: f32,
        /// m.
        height: f32,
    },
    /// All that is on the other side of the plane through the origin: cloth stays on the side that `normal` points to.
    HalfSpace {
        /// Of any length but zero.
        normal: Vec3,
    },
    /// The smallest convex body around points.
    ConvexHull {
        /// Not all in one plane.
        points: Vec<Vec3>,
    },
    /// A surface of triangles, see [`ClothCollider::trimesh`](super::ClothCollider::trimesh).
    Trimesh {
        /// Places.
        vertices: Vec<Vec3>,
        /// Three vertices each, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
    /// Ground, see [`ClothCollider::heightfield`](super::ClothCollider::heightfield).
    Heightfield {
        /// Rows along +Z, each of columns along +X, multiplied by `scale.y`.
        heights: Vec<Vec<f32>>,
        /// Sizes along X and Z, and what heights are multiplied by.
        scale: Vec3,
    },
    /// Several shapes as one.
    Compound {
        /// At least one. Surfaces of triangles cannot be parts.
        parts: Vec<ClothShapePart>,
    },
    /// A shape without description: of a mesh asset ([`ClothMeshCollider`](super::ClothMeshCollider)), of a collider of Avian or Rapier, or
    /// of a kind of [`parry3d`] that is not among these. It is not saved. Those of meshes and engines are made again after loading;
    /// any other collider is lost, and says so by a [`ClothColliderError`](super::ClothColliderError).
    Undescribed,
}

/// A part of [`ClothShape::Compound`].
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct ClothShapePart {
    /// Where its origin is, m.
    pub translation: Vec3,
    /// How it is turned.
    pub rotation: Quat,
    /// What it is. Parts of a compound in a compound are parts of the whole.
    pub shape: ClothShape,
}

impl Default for ClothShape {
    /// A ball of 1 m across.
    fn default() -> Self {
        Self::Sphere { radius: 0.5 }
    }
}

impl ClothShape {
    /// The shape itself.
    pub(super) fn build(&self) -> Result<SharedShape, ClothShapeError> {
        Ok(match self {
            &Self::Sphere { radius } => SharedShape::ball(radius),
            &Self::Capsule { a, b, radius } => SharedShape::capsule(a, b, radius),
            &Self::Cuboid { size } => SharedShape::cuboid(0.5 * size.x, 0.5 * size.y, 0.5 * size.z),
            &Self::Cylinder { radius, height } => SharedShape::cylinder(0.5 * height, radius),
            &Self::Cone { radius, height } => SharedShape::cone(0.5 * height, radius),
            &Self::HalfSpace { normal } => {
                SharedShape::halfspace(normal.try_normalize().ok_or(ClothShapeError::Normal(normal))?)
            }
            Self::ConvexHull { points } => hull(points)?,
            Self::Trimesh { vertices, triangles } => surface(vertices, triangles)?,
            &Self::Heightfield { ref heights, scale } => heightfield(heights, scale)?,
            Self::Compound { parts } => compound(parts)?,
            Self::Undescribed => return Err(ClothShapeError::Undescribed),
        })
    }

    /// What describes a shape.
    pub(super) fn of(shape: &SharedShape) -> Self {
        match shape.as_typed_shape() {
            TypedShape::Ball(ball) => Self::Sphere { radius: ball.radius },
            TypedShape::Capsule(capsule) => {
                Self::Capsule { a: capsule.segment.a, b: capsule.segment.b, radius: capsule.radius }
            }
            TypedShape::Cuboid(cuboid) => Self::Cuboid { size: 2.0 * cuboid.half_extents },
            TypedShape::Cylinder(cylinder) => {
                Self::Cylinder { radius: cylinder.radius, height: 2.0 * cylinder.half_height }
            }
            TypedShape::Cone(cone) => Self::Cone { radius: cone.radius, height: 2.0 * cone.half_height },
            TypedShape::HalfSpace(half) => Self::HalfSpace { normal: half.normal },
            TypedShape::ConvexPolyhedron(body) => Self::ConvexHull { points: body.points().to_vec() },
            TypedShape::TriMesh(mesh) => {
                Self::Trimesh { vertices: mesh.vertices().to_vec(), triangles: mesh.indices().to_vec() }
            }
            TypedShape::HeightField(field) if is_whole(field) => {
                let row = |i: usize| (0..field.heights().ncols()).map(|j| field.heights()[(i, j)]).collect();
                Self::Heightfield { heights: (0..field.heights().nrows()).map(row).collect(), scale: field.scale() }
            }
            TypedShape::Compound(compound) => {
                let part = |(pose, shape): &(Pose, SharedShape)| ClothShapePart {
                    translation: pose.translation,
                    rotation: pose.rotation,
                    shape: Self::of(shape),
                };
                let parts: Vec<_> = compound.shapes().iter().map(part).collect();
                if parts.iter().any(|part| part.shape == Self::Undescribed) {
                    Self::Undescribed
                } else {
                    Self::Compound { parts }
                }
            }
            _ => Self::Undescribed,
        }
    }

    /// Tells descriptions apart.
    pub(super) fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.hash_into(&mut hasher);
        hasher.finish()
    }

    fn hash_into(&self, hasher: &mut DefaultHasher) {
        let place = |hasher: &mut DefaultHasher, place: Vec3| {
            place.to_array().into_iter().for_each(|coordinate| hasher.write_u32(coordinate.to_bits()));
        };
        let (kind, sizes): (u8, &[f32]) = match self {
            Self::Sphere { radius } => (0, &[*radius]),
            Self::Capsule { radius, .. } => (1, &[*radius]),
            Self::Cuboid { .. } => (2, &[]),
            Self::Cylinder { radius, height } => (3, &[*radius, *height]),
            Self::Cone { radius, height } => (4, &[*radius, *height]),
            Self::HalfSpace { .. } => (5, &[]),
            Self::ConvexHull { .. } => (6, &[]),
            Self::Trimesh { .. } => (7, &[]),
            Self::Heightfield { .. } => (8, &[]),
            Self::Compound { .. } => (9, &[]),
            Self::Undescribed => (10, &[]),
        };
        hasher.write_u8(kind);
        sizes.iter().for_each(|size| hasher.write_u32(size.to_bits()));
        match self {
            &Self::Capsule { a, b, .. } => [a, b].into_iter().for_each(|end| place(hasher, end)),
            &Self::Cuboid { size } => place(hasher, size),
            &Self::HalfSpace { normal } => place(hasher, normal),
            Self::ConvexHull { points } => points.iter().for_each(|&point| place(hasher, point)),
            Self::Trimesh { vertices, triangles } => {
                hasher.write_usize(vertices.len());
                vertices.iter().for_each(|&vertex| place(hasher, vertex));
                triangles.iter().flatten().for_each(|&vertex| hasher.write_u32(vertex));
            }
            Self::Heightfield { heights, scale } => {
                place(hasher, *scale);
                for row in heights {
                    hasher.write_usize(row.len());
                    row.iter().for_each(|height| hasher.write_u32(height.to_bits()));
                }
            }
            Self::Compound { parts } => {
                for ClothShapePart { translation, rotation, shape } in parts {
                    place(hasher, *translation);
                    rotation.to_array().into_iter().for_each(|entry| hasher.write_u32(entry.to_bits()));
                    shape.hash_into(hasher);
                }
            }
            Self::Sphere { .. } | Self::Cylinder { .. } | Self::Cone { .. } | Self::Undescribed => {}
        }
    }
}

/// Whether a field has all of its triangles, cut the usual way.
fn is_whole(field: &HeightField) -> bool {
    field.cells_statuses().data().iter().all(|status| *status == HeightFieldCellStatus::default())
}

fn heightfield(heights: &[Vec<f32>], scale: Vec3) -> Result<SharedShape, ClothShapeError> {
    let (rows, columns) = (heights.len(), heights.first().map_or(0, Vec::len));
    if rows < 2 || columns < 2 {
        return Err(ClothShapeError::Empty("two rows of two heights".into()));
    }
    if let Some(row) = heights.iter().position(|row| row.len() != columns) {
        return Err(ClothShapeError::Uneven { row, found: heights[row].len(), expected: columns });
    }
    if let Some(index) = heights.iter().flatten().position(|height| !height.is_finite()) {
        return Err(ClothShapeError::NotFinite(index));
    }
    // Column by column.
    let data = (0..columns).flat_map(|column| heights.iter().map(move |row| row[column])).collect();
    Ok(SharedShape::heightfield(Array2::new(rows, columns, data), scale))
}

fn compound(parts: &[ClothShapePart]) -> Result<SharedShape, ClothShapeError> {
    assemble(parts.iter().map(|ClothShapePart { translation, rotation, shape }| {
        Ok((Pose::from_parts(*translation, *rotation), shape.build()?))
    }))
}

/// Several shapes as one.
pub(super) fn assemble(
    parts: impl Iterator<Item = Result<(Pose, SharedShape), ClothShapeError>>,
) -> Result<SharedShape, ClothShapeError> {
    let mut shapes = Vec::new();
    for (index, part) in parts.enumerate() {
        let (place, shape) = part?;
        match shape.as_compound() {
            // Compounds cannot be nested.
            Some(inner) => shapes.extend(inner.shapes().iter().map(|(own, s)| (place * *own, s.clone()))),
            None if shape.as_composite_shape().is_some() => return Err(ClothShapeError::Part { part: index }),
            None => shapes.push((place, shape)),
        }
    }
    if shapes.is_empty() {
        return Err(ClothShapeError::Empty("parts".into()));
    }
    Ok(SharedShape::compound(shapes))
}
