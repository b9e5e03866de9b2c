//! Shapes as large as their entity makes them.

use bevy::math::{Mat3, Vec3};
use parry3d::math::{Pose, Rotation};
use parry3d::shape::{Ball, Capsule, Cone, Cuboid, Cylinder, HalfSpace, SharedShape, TypedShape};

use super::hull::hull;
use super::surface::{ground, surface};

/// Segments around a ball, capsule, cylinder or cone that scale makes another shape: inscribed, it is 2 % smaller at most.
pub(super) const SEGMENTS: u32 = 16;

/// Factors that differ by less are the same.
const TOLERANCE: f32 = 1e-4;

/// A shape scaled along its own axes; a negative factor mirrors it. `None` for a kind of shape that cannot be scaled.
///
/// Round shapes under a scale that leaves them no longer round become the convex hull of their outline. The parts of a
/// compound are scaled along their own axes as much as these become longer: exact unless a part is turned by other than
/// quarter turns under a scale that is not the same along all axes. The rim of a rounded shape grows by the least factor.
pub(super) fn scaled(shape: &SharedShape, scale: Vec3) -> Option<SharedShape> {
    let scale = evened(scale);
    if scale == Vec3::ONE {
        return Some(shape.clone());
    }
    let size = scale.abs();
    let rim = size.min_element();
    let even = size.x == size.y && size.y == size.z;
    let hull_of = |points: Vec<Vec3>| hull(&points.into_iter().map(|p| p * scale).collect::<Vec<_>>()).ok();
    let mirrored = scale.x * scale.y * scale.z < 0.0;
    Some(match shape.as_typed_shape() {
        TypedShape::Ball(ball) if even => SharedShape::new(Ball::new(ball.radius * size.x)),
        TypedShape::Ball(ball) => hull_of(ball.to_trimesh(SEGMENTS, SEGMENTS).0)?,
        TypedShape::Cuboid(cuboid) => SharedShape::new(Cuboid::new(cuboid.half_extents * size)),
        TypedShape::Capsule(capsule) if even => {
            let ends = [capsule.segment.a * scale, capsule.segment.b * scale];
            SharedShape::new(Capsule::new(ends[0], ends[1], capsule.radius * size.x))
        }
        TypedShape::Capsule(capsule) => hull_of(capsule.to_trimesh(SEGMENTS, SEGMENTS).0)?,
        TypedShape::Cylinder(cylinder) if size.x == size.z => {
            SharedShape::new(Cylinder::new(cylinder.half_height * size.y, cylinder.radius * size.x))
        }
        TypedShape::Cylinder(cylinder) => hull_of(cylinder.to_trimesh(SEGMENTS).0)?,
        TypedShape::Cone(cone) if size.x == size.z && scale.y > 0.0 => {
            SharedShape::new(Cone::new(cone.half_height * size.y, cone.radius * size.x))
        }
        TypedShape::Cone(cone) => hull_of(cone.to_trimesh(SEGMENTS).0)?,
        // Normals go by the inverse.
        TypedShape::HalfSpace(half) => SharedShape::new(HalfSpace::new((half.normal / scale).try_normalize()?)),
        TypedShape::Segment(segment) => SharedShape::new(segment.scaled(scale)),
        TypedShape::Triangle(triangle) => SharedShape::new(triangle.scaled(scale)),
        TypedShape::Polyline(line) => SharedShape::new(line.clone().scaled(scale)),
        TypedShape::ConvexPolyhedron(body) => hull_of(body.points().to_vec())?,
        TypedShape::TriMesh(mesh) => {
            let vertices = mesh.vertices().iter().map(|p| p * scale).collect();
            let triangles = turned(mesh.indices(), mirrored);
            SharedShape::trimesh_with_flags(vertices, triangles, mesh.flags()).ok()?
        }
        TypedShape::HeightField(field) if scale.min_element() > 0.0 => SharedShape::new(field.clone().scaled(scale)),
        TypedShape::HeightField(field) => {
            let (vertices, triangles) = ground(field.to_trimesh());
            let vertices: Vec<_> = vertices.into_iter().map(|p| p * scale).collect();
            surface(&vertices, &turned(&triangles, mirrored)).ok()?
        }
        TypedShape::Compound(compound) => {
            let parts = compound.shapes().iter().map(|(pose, part)| scaled_part(pose, part, scale));
            SharedShape::compound(parts.collect::<Option<_>>()?)
        }
        TypedShape::RoundCuboid(round) => {
            let size = round.inner_shape.half_extents * size;
            SharedShape::round_cuboid(size.x, size.y, size.z, round.border_radius * rim)
        }
        TypedShape::RoundTriangle(round) => {
            let inner = round.inner_shape.scaled(scale);
            SharedShape::round_triangle(inner.a, inner.b, inner.c, round.border_radius * rim)
        }
        TypedShape::RoundCylinder(round) if size.x == size.z => SharedShape::round_cylinder(
            round.inner_shape.half_height * size.y,
            round.inner_shape.radius * size.x,
            round.border_radius * rim,
        ),
        TypedShape::RoundCone(round) if size.x == size.z && scale.y > 0.0 => SharedShape::round_cone(
            round.inner_shape.half_height * size.y,
            round.inner_shape.radius * size.x,
            round.border_radius * rim,
        ),
        TypedShape::RoundConvexPolyhedron(round) => {
            let points: Vec<_> = round.inner_shape.points().iter().map(|p| p * scale).collect();
            SharedShape::round_convex_hull(&points, round.border_radius * rim)?
        }
        _ => return None,
    })
}

/// A part of a compound: S R = (M R M) (M D), with the mirroring M of the scale S = M |S| and the lengths D that the axes of
/// the part have in |S| R.
fn scaled_part(pose: &Pose, part: &SharedShape, scale: Vec3) -> Option<(Pose, SharedShape)> {
    let signs = scale.signum();
    let mirror = Mat3::from_diagonal(signs);
    let turn = Mat3::from_quat(pose.rotation);
    let stretched = Mat3::from_diagonal(scale.abs()) * turn;
    let lengths = Vec3::new(stretched.x_axis.length(), stretched.y_axis.length(), stretched.z_axis.length());
    let rotation = Rotation::from_mat3(&(mirror * turn * mirror));
    Some((Pose::from_parts(pose.translation * scale, rotation), scaled(part, signs * lengths)?))
}

/// Triangles, the other way round in a mirror.
pub(super) fn turned(triangles: &[[u32; 3]], mirrored: bool) -> Vec<[u32; 3]> {
    triangles.iter().map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] }).collect()
}

/// Factors that are all but equal, or all but ±1, made so: a ball in a turned hierarchy stays a ball.
fn evened(scale: Vec3) -> Vec3 {
    let near = |a: f32, b: f32| (a - b).abs() <= TOLERANCE * b;
    let mut size = scale.abs();
    if near(size.y, size.x) {
        size.y = size.x;
    }
    if near(size.z, size.x) {
        size.z = size.x;
    } else if near(size.z, size.y) {
        size.z = size.y;
    }
    let size = size.map(|factor| if near(factor, 1.0) { 1.0 } else { factor });
    size * scale.signum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plugin::contact::ClothCollider;
    use bevy::math::Quat;
    use bevy::prelude::{Dir3, Mesh, Meshable, Sphere};
    use core::f32::consts::{FRAC_PI_2, FRAC_PI_4};
    use parry3d::shape::ShapeType;

    /// Corners of the box around a shape under a scale.
    #[track_caller]
    fn assert_box(collider: &ClothCollider, scale: Vec3, min: Vec3, max: Vec3) -> SharedShape {
        let shape = scaled(collider.shape(), scale).expect("a shape");
        let aabb = shape.compute_local_aabb();
        assert!(aabb.mins.abs_diff_eq(min, 1e-3) && aabb.maxs.abs_diff_eq(max, 1e-3), "{aabb:?}");
        shape
    }

    fn ball_mesh() -> Mesh {
        Sphere::new(1.0).mesh().uv(16, 8)
    }

    #[test]
    fn every_kind_is_as_large_as_it_is_made() {
        let uneven = Vec3::new(2.0, 3.0, 4.0);
        let both = |half: Vec3| (-half, half);
        let tetrahedron = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let cases = [
            (ClothCollider::sphere(0.5), both(0.5 * uneven)),
            (ClothCollider::cuboid(1.0, 2.0, 3.0), both(Vec3::new(1.0, 3.0, 6.0))),
            (ClothCollider::capsule(0.5, 1.0), both(Vec3::new(1.0, 3.0, 2.0))),
            (ClothCollider::cylinder(0.5, 1.0), both(Vec3::new(1.0, 1.5, 2.0))),
            (ClothCollider::cone(0.5, 1.0), both(Vec3::new(1.0, 1.5, 2.0))),
            (ClothCollider::convex_hull(&tetrahedron).unwrap(), (Vec3::ZERO, uneven)),
            (ClothCollider::from_mesh(&ball_mesh()).unwrap(), both(uneven)),
            (ClothCollider::heightfield(&[vec![0.0, 1.0], vec![0.0, 1.0]], Vec3::ONE).unwrap(), {
                (Vec3::new(-1.0, 0.0, -2.0), Vec3::new(1.0, 3.0, 2.0))
            }),
        ];
        for (collider, (min, max)) in cases {
            assert_box(&collider, uneven, min, max);
            let mirrored = Vec3::new(-2.0, 3.0, 4.0);
            assert_box(&collider, mirrored, min.with_x(-max.x), max.with_x(-min.x));
        }
    }

    #[test]
    fn round_shapes_stay_round_where_they_can() {
        let kind = |collider: ClothCollider, scale| scaled(collider.shape(), scale).unwrap().shape_type();
        assert_eq!(kind(ClothCollider::sphere(1.0), Vec3::new(2.0, 2.00001, -2.0)), ShapeType::Ball);
        assert_eq!(kind(ClothCollider::capsule(1.0, 1.0), Vec3::splat(0.1)), ShapeType::Capsule);
        assert_eq!(kind(ClothCollider::cylinder(1.0, 1.0), Vec3::new(3.0, 1.0, 3.0)), ShapeType::Cylinder);
        assert_eq!(kind(ClothCollider::cone(1.0, 1.0), Vec3::new(3.0, -1.0, 3.0)), ShapeType::ConvexPolyhedron);
    }

    #[test]
    fn a_mirrored_mesh_is_solid_inside_still() {
        let shape = scaled(ClothCollider::from_mesh(&ball_mesh()).unwrap().shape(), Vec3::new(-1.0, 1.0, 2.0)).unwrap();
        assert!(shape.contains_local_point(Vec3::new(0.2, 0.1, 1.0)));
        assert!(!shape.contains_local_point(Vec3::new(0.2, 0.1, 2.1)));
    }

    #[test]
    fn a_half_space_turns_with_its_plane() {
        let slope = ClothCollider::half_space(Dir3::from_xyz(1.0, 1.0, 0.0).unwrap());
        let shape = scaled(slope.shape(), Vec3::new(2.0, 1.0, 1.0)).unwrap();
        // The line y = −x becomes y = −x/2.
        assert!(shape.as_halfspace().unwrap().normal.abs_diff_eq(Vec3::new(1.0, 2.0, 0.0).normalize(), 1e-6));
    }

    #[test]
    fn parts_of_a_compound_are_moved_turned_and_scaled() {
        let quarter = Quat::from_rotation_z(FRAC_PI_2);
        let part = || ClothCollider::cuboid(2.0, 1.0, 1.0);
        let compound = ClothCollider::compound([(Vec3::X, quarter, part())]).unwrap();
        // Standing: 1 wide, 2 high.
        assert_box(&compound, Vec3::new(2.0, 3.0, 1.0), Vec3::new(1.0, -3.0, -0.5), Vec3::new(3.0, 3.0, 0.5));
        assert_box(&compound, Vec3::new(-2.0, 3.0, 1.0), Vec3::new(-3.0, -3.0, -0.5), Vec3::new(-1.0, 3.0, 0.5));
        let leaning = ClothCollider::compound([(Vec3::ZERO, Quat::from_rotation_z(FRAC_PI_4), part())]).unwrap();
        let mirrored = scaled(leaning.shape(), Vec3::new(-1.0, 1.0, 1.0)).unwrap();
        let end = Vec3::new(-0.7, 0.7, 0.0);
        assert!(mirrored.project_local_point(end, true).is_inside, "it leans the other way");
        assert!(!mirrored.project_local_point(-end.with_y(-0.7), true).is_inside);
    }
}
