//! The forms that a collider can have.

use bevy::prelude::*;
use parry3d::math::Pose;

use super::collider::ClothCollider;
use super::description::{ClothShape, ClothShapePart, assemble};
use super::error::ClothShapeError;
use crate::plugin::mesh_io::SourceMesh;

/// Constructors; all sizes in metres, centred at the origin of the entity unless they say otherwise.
impl ClothCollider {
    /// A ball.
    pub fn sphere(radius: f32) -> Self {
        Self::described(ClothShape::Sphere { radius })
    }

    /// A capsule along Y; `length` is that of the part between its two half balls.
    pub fn capsule(radius: f32, length: f32) -> Self {
        Self::capsule_between(Vec3::NEG_Y * 0.5 * length, Vec3::Y * 0.5 * length, radius)
    }

    /// A capsule whose half balls have their centres at `a` and `b`: a bone with some flesh.
    pub fn capsule_between(a: Vec3, b: Vec3, radius: f32) -> Self {
        Self::described(ClothShape::Capsule { a, b, radius })
    }

    /// A box of these sizes along X, Y and Z.
    pub fn cuboid(x: f32, y: f32, z: f32) -> Self {
        Self::described(ClothShape::Cuboid { size: Vec3::new(x, y, z) })
    }

    /// A cylinder along Y.
    pub fn cylinder(radius: f32, height: f32) -> Self {
        Self::described(ClothShape::Cylinder { radius, height })
    }

    /// A cone along Y, its tip up; the origin is half way up.
    pub fn cone(radius: f32, height: f32) -> Self {
        Self::described(ClothShape::Cone { radius, height })
    }

    /// All that is on the other side of the plane through the origin: cloth stays on the side that `normal` points to.
    pub fn half_space(normal: Dir3) -> Self {
        Self::described(ClothShape::HalfSpace { normal: *normal })
    }

    /// The smallest convex body around these points.
    ///
    /// # Errors
    /// If the points are in one plane, or one is not finite.
    pub fn convex_hull(points: &[Vec3]) -> Result<Self, ClothShapeError> {
        Self::from_shape(ClothShape::ConvexHull { points: points.to_vec() })
    }

    /// The surface of triangles, counter-clockwise seen from outside. [`kind`](Self::kind) tells what it became:
    ///
    /// - If it is closed (every edge has two triangles), it is solid. Where the triangles face inwards, it keeps cloth inside, as a
    ///   room does, and a warning says so.
    /// - If it is open, it is one-sided: ground, floors and domes keep cloth on the side that they are seen from, and cloth that is
    ///   behind them is free.
    /// - If most of its faces are there twice, once for each side, one of each counts: a closed one is solid, an open one keeps cloth on
    ///   both sides.
    /// - Triangles that are wound the other way round than their neighbors are taken as turned, with a warning. Where they cannot be,
    ///   as with three at an edge, cloth may be on both sides.
    ///
    /// Two-sided surfaces are the least steady: prefer a solid with some thickness.
    ///
    /// # Errors
    /// If there are no triangles, one names a vertex that does not exist, or a vertex is not finite.
    pub fn trimesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, ClothShapeError> {
        Self::from_shape(ClothShape::Trimesh { vertices, triangles })
    }

    /// [`trimesh`](Self::trimesh) of a Bevy mesh, as it is now.
    ///
    /// Use [`ClothMeshCollider`](super::ClothMeshCollider) for a mesh that is still loading.
    ///
    /// # Errors
    /// If the mesh is not made of triangles or is in the render world only, or as `trimesh`.
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, ClothShapeError> {
        let mesh = SourceMesh::read(mesh)?;
        Self::trimesh(mesh.positions, mesh.triangles)
    }

    /// [`convex_hull`](Self::convex_hull) of the vertices of a Bevy mesh.
    ///
    /// # Errors
    /// If the mesh is not made of triangles or is in the render world only, or as `convex_hull`.
    pub fn hull_of_mesh(mesh: &Mesh) -> Result<Self, ClothShapeError> {
        Self::convex_hull(&SourceMesh::read(mesh)?.positions)
    }

    /// Ground: rows of heights along +Z, each of columns along +X, over a rectangle of `scale.x` by `scale.z` around the origin;
    /// heights are multiplied by `scale.y`.
    ///
    /// # Errors
    /// If there are fewer than two rows or columns, rows of different lengths, or a height is not finite.
    pub fn heightfield(heights: &[Vec<f32>], scale: Vec3) -> Result<Self, ClothShapeError> {
        Self::from_shape(ClothShape::Heightfield { heights: heights.to_vec(), scale })
    }

    /// Several colliders as one, each moved and turned. They have the friction of the whole, not their own.
    ///
    /// # Errors
    /// If there are none, or one is a surface of triangles.
    pub fn compound(parts: impl IntoIterator<Item = (Vec3, Quat, ClothCollider)>) -> Result<Self, ClothShapeError> {
        let parts: Vec<_> = parts.into_iter().collect();
        let place = |(translation, rotation, part): &(Vec3, Quat, Self)| {
            Ok((Pose::from_parts(*translation, *rotation), part.shape().clone()))
        };
        let shape = assemble(parts.iter().map(place))?;
        let part = |(translation, rotation, part): (Vec3, Quat, Self)| {
            let shape = part.description().clone();
            ClothShapePart { translation, rotation, shape }
        };
        Ok(Self::compound_of(parts.into_iter().map(part).collect(), shape))
    }
}

impl From<Sphere> for ClothCollider {
    fn from(sphere: Sphere) -> Self {
        Self::sphere(sphere.radius)
    }
}

impl From<Capsule3d> for ClothCollider {
    fn from(capsule: Capsule3d) -> Self {
        Self::capsule(capsule.radius, 2.0 * capsule.half_length)
    }
}

impl From<Cuboid> for ClothCollider {
    fn from(cuboid: Cuboid) -> Self {
        let size = cuboid.size();
        Self::cuboid(size.x, size.y, size.z)
    }
}

impl From<Cylinder> for ClothCollider {
    fn from(cylinder: Cylinder) -> Self {
        Self::cylinder(cylinder.radius, 2.0 * cylinder.half_height)
    }
}

impl From<Cone> for ClothCollider {
    fn from(cone: Cone) -> Self {
        Self::cone(cone.radius, cone.height)
    }
}

impl From<InfinitePlane3d> for ClothCollider {
    fn from(plane: InfinitePlane3d) -> Self {
        Self::half_space(plane.normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_where_they_are_said_to_be() {
        let heights = [vec![0.0, 0.0, 0.0], vec![0.0, 0.0, 1.0]];
        let ground = ClothCollider::heightfield(&heights, Vec3::new(4.0, 3.0, 2.0)).unwrap();
        let aabb = ground.shape().compute_local_aabb();
        assert_eq!((aabb.mins, aabb.maxs), (Vec3::new(-2.0, 0.0, -1.0), Vec3::new(2.0, 3.0, 1.0)));
        let top = Vec3::new(2.0, 3.0, 1.0);
        assert!(ground.shape().distance_to_local_point(top, false) < 1e-5, "last row, last column");
    }

    #[test]
    fn what_cannot_be_a_shape_is_refused() {
        type E = ClothShapeError;
        let flat = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::ONE.with_y(0.0)];
        assert_eq!(ClothCollider::convex_hull(&flat).unwrap_err(), E::NoHull);
        assert_eq!(ClothCollider::convex_hull(&[Vec3::NAN]).unwrap_err(), E::NotFinite(0));
        assert_eq!(ClothCollider::convex_hull(&[]).unwrap_err(), E::NoHull);
        let out_of_range = ClothCollider::trimesh(flat.to_vec(), vec![[0, 1, 2], [0, 1, 4]]).unwrap_err();
        assert_eq!(out_of_range, E::IndexOutOfRange { triangle: 1, vertex: 4, count: 4 });
        assert!(matches!(ClothCollider::trimesh(flat.to_vec(), vec![]), Err(E::Empty(_))));
        assert!(matches!(ClothCollider::heightfield(&[vec![0.0, 1.0]], Vec3::ONE), Err(E::Empty(_))));
        let uneven = ClothCollider::heightfield(&[vec![0.0, 1.0], vec![0.0]], Vec3::ONE).unwrap_err();
        assert_eq!(uneven, E::Uneven { row: 1, found: 1, expected: 2 });
        assert!(matches!(ClothCollider::compound([]), Err(E::Empty(_))));
    }
}
