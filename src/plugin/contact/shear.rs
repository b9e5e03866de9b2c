//! Shapes under a transform that is more than a turn and a scale along their own axes: turned under a parent that is not scaled evenly.

use bevy::math::{DMat3, DQuat, Mat3, Vec3};
use parry3d::math::{Pose, Rotation};
use parry3d::shape::{HalfSpace, SharedShape, TypedShape};

use super::error::ClothColliderError;
use super::hull::hull;
use super::scale::{SEGMENTS, scaled, turned};
use super::surface::{ground, surface};
use crate::plugin::geometry::polar;

/// Cosine of the angle between axes, up to which they are at right angles: rounding of a long hierarchy.
const SQUARE: f64 = 1e-4;

/// A linear map as a turn after a stretch along three axes at right angles, which need not be those of the shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheared {
    pub rotation: DQuat,
    /// Symmetric; negative factors mirror.
    pub stretch: DMat3,
}

impl Sheared {
    /// `None` if the axes stay at right angles to each other, so that turn and scale say all.
    pub fn of(linear: DMat3) -> Option<Self> {
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis].map(|axis| axis.normalize_or_zero());
        let most = x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs());
        (most > SQUARE).then(|| Self::polar(linear))
    }

    /// By the polar decomposition: with it, what only turns keeps its stretch.
    fn polar(linear: DMat3) -> Self {
        let (turn, stretch) = polar(linear);
        let sign = turn.determinant().signum();
        Self { rotation: DQuat::from_mat3(&(sign * turn)).normalize(), stretch: sign * stretch }
    }
}

/// How large a transform makes a shape, before it turns it.
#[derive(Clone, Copy, Debug)]
pub(in crate::plugin) enum Size {
    /// Along the axes of the shape; a negative factor mirrors.
    Scaled(Vec3),
    /// Along others: [`Sheared::stretch`].
    Sheared(DMat3),
}

impl Size {
    /// Whether they are the same but for rounding.
    pub fn is_about(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Scaled(a), Self::Scaled(b)) => (a - b).abs().cmple(1e-4 * b.abs()).all(),
            (Self::Sheared(a), Self::Sheared(b)) => same_stretch(*a, *b),
            _ => false,
        }
    }

    /// A shape so large.
    pub fn of(&self, shape: &SharedShape) -> Result<SharedShape, ClothColliderError> {
        let kind = || format!("{:?}", shape.shape_type());
        match *self {
            Self::Scaled(scale) => {
                scaled(shape, scale).ok_or_else(|| ClothColliderError::Scale { shape: kind(), scale })
            }
            Self::Sheared(stretch) => {
                sheared(shape, stretch.as_mat3()).ok_or_else(|| ClothColliderError::Shear { shape: kind() })
            }
        }
    }
}

/// A shape under a linear map. `None` for a kind of shape that has no equal then: a rounded one.
fn sheared(shape: &SharedShape, map: Mat3) -> Option<SharedShape> {
    let hull_of = |points: &[Vec3]| hull(&points.iter().map(|&p| map * p).collect::<Vec<_>>()).ok();
    let mesh = |vertices: &[Vec3]| vertices.iter().map(|&p| map * p).collect::<Vec<_>>();
    let mirrored = map.determinant() < 0.0;
    Some(match shape.as_typed_shape() {
        TypedShape::Ball(ball) => hull_of(&ball.to_trimesh(SEGMENTS, SEGMENTS).0)?,
        TypedShape::Cuboid(cuboid) => hull_of(&cuboid.to_trimesh().0)?,
        TypedShape::Capsule(capsule) => hull_of(&capsule.to_trimesh(SEGMENTS, SEGMENTS).0)?,
        TypedShape::Cylinder(cylinder) => hull_of(&cylinder.to_trimesh(SEGMENTS).0)?,
        TypedShape::Cone(cone) => hull_of(&cone.to_trimesh(SEGMENTS).0)?,
        TypedShape::ConvexPolyhedron(body) => hull_of(body.points())?,
        // Normals go by the inverse.
        TypedShape::HalfSpace(half) => {
            SharedShape::new(HalfSpace::new((map.inverse().transpose() * half.normal).try_normalize()?))
        }
        TypedShape::Segment(segment) => SharedShape::segment(map * segment.a, map * segment.b),
        TypedShape::Triangle(triangle) => SharedShape::triangle(map * triangle.a, map * triangle.b, map * triangle.c),
        TypedShape::Polyline(line) => SharedShape::polyline(mesh(line.vertices()), Some(line.indices().to_vec())),
        TypedShape::TriMesh(its) => {
            let triangles = turned(its.indices(), mirrored);
            SharedShape::trimesh_with_flags(mesh(its.vertices()), triangles, its.flags()).ok()?
        }
        TypedShape::HeightField(field) => {
            let (vertices, triangles) = ground(field.to_trimesh());
            surface(&mesh(&vertices), &turned(&triangles, mirrored)).ok()?
        }
        TypedShape::Compound(compound) => {
            let part = |(pose, part): &(Pose, SharedShape)| {
                let linear = map * Mat3::from_quat(pose.rotation);
                let Sheared { rotation, stretch } = Sheared::polar(linear.as_dmat3());
                let pose =
                    Pose::from_parts(map * pose.translation, Rotation::from_mat3(&Mat3::from_quat(rotation.as_quat())));
                Some((pose, sheared(part, stretch.as_mat3())?))
            };
            SharedShape::compound(compound.shapes().iter().map(part).collect::<Option<_>>()?)
        }
        _ => return None,
    })
}

/// Whether two stretches are the same but for rounding.
fn same_stretch(a: DMat3, b: DMat3) -> bool {
    let largest = |m: DMat3| m.to_cols_array().into_iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    largest(a - b) <= 1e-4 * largest(a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plugin::contact::ClothCollider;
    use bevy::math::DVec3;
    use bevy::prelude::{Mesh, Meshable, Sphere};

    /// A turn under a scale that is not even.
    fn map(scale: DVec3) -> DMat3 {
        DMat3::from_diagonal(scale) * DMat3::from_quat(DQuat::from_rotation_z(0.6))
    }

    #[test]
    fn a_turn_afterwards_changes_no_stretch() {
        for scale in [DVec3::new(1.0, 3.0, 1.0), DVec3::new(-2.0, 1.0, 1.0)] {
            let first = Sheared::of(map(scale)).expect("sheared");
            let turn = DQuat::from_rotation_y(1.1);
            let second = Sheared::of(DMat3::from_quat(turn) * map(scale)).expect("sheared");
            assert!(same_stretch(first.stretch, second.stretch));
            assert!((turn * first.rotation).angle_between(second.rotation) < 1e-6);
            let again = DMat3::from_quat(first.rotation) * first.stretch;
            assert!((again - map(scale)).to_cols_array().iter().all(|x| x.abs() < 1e-9), "{again} {}", map(scale));
        }
        assert!(
            Sheared::of(
                DMat3::from_quat(DQuat::from_rotation_x(0.3)) * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0))
            )
            .is_none()
        );
    }

    #[test]
    fn shapes_are_what_is_drawn() {
        let linear = map(DVec3::new(1.0, 3.0, 1.0));
        let Sheared { rotation, stretch } = Sheared::of(linear).expect("sheared");
        let ball: Mesh = Sphere::new(0.5).mesh().uv(16, 8);
        let round = Vec3::new(0.3, 0.4, 0.0);
        let corner = Vec3::new(0.3, 0.3, 0.3);
        let cases = [
            (ClothCollider::cuboid(0.6, 0.6, 0.6), corner),
            (ClothCollider::sphere(0.5), round),
            (ClothCollider::from_mesh(&ball).unwrap(), round),
            (
                ClothCollider::compound([(
                    Vec3::ZERO,
                    bevy::math::Quat::from_rotation_z(0.3),
                    ClothCollider::sphere(0.5),
                )])
                .unwrap(),
                round,
            ),
        ];
        for (collider, on) in cases {
            let shape = sheared(collider.shape(), stretch.as_mat3()).expect("a shape");
            // In the frame of the shape, from a place of the surface in that of the mesh.
            let place = |share: f32| (rotation.inverse() * (linear * (share * on).as_dvec3())).as_vec3();
            assert!(shape.distance_to_local_point(place(1.05), true) > 0.0, "{:?}", shape.shape_type());
            assert!(shape.contains_local_point(place(0.94)), "{:?}", shape.shape_type());
        }
        assert!(sheared(&SharedShape::round_cuboid(0.1, 0.1, 0.1, 0.01), stretch.as_mat3()).is_none());
    }
}
