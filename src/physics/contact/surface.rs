//! Distances to shapes, in their own frame: closed forms in f64 for the simple ones, parry for the rest.

use bevy::math::{DQuat, DVec3};
use parry3d::bounding_volume::Aabb;
use parry3d::query::{PointQuery, Ray};
use parry3d::shape::{Compound, HeightField, Shape, SharedShape, TriMesh, TypedShape};

use super::sheet;

/// The point of a surface that is nearest to another point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    /// Distance to it, m; negative inside.
    pub distance: f64,
    /// Unit normal there: away from the inside; away from a shell on the side where the point is.
    pub normal: DVec3,
}

/// A shape, and how its distances are found.
pub(super) enum Surface<'a> {
    Ball {
        radius: f64,
    },
    Capsule {
        a: DVec3,
        b: DVec3,
        radius: f64,
    },
    HalfSpace {
        normal: DVec3,
    },
    Cuboid {
        half: DVec3,
    },
    Solid(&'a dyn Shape),
    /// Has no inside: both sides keep cloth out.
    Shell(&'a dyn Shape),
    /// Keeps cloth out from one side: behind it all is free.
    Sheet(&'a TriMesh),
    /// Inside is what is below, as deep as is looked.
    Ground(&'a HeightField),
    /// Inside is what is inside of any part.
    Union(&'a Compound),
}

impl<'a> Surface<'a> {
    pub fn new(shape: &'a SharedShape) -> Self {
        match shape.as_typed_shape() {
            TypedShape::Ball(ball) => Self::Ball { radius: ball.radius.into() },
            TypedShape::Capsule(capsule) => Self::Capsule {
                a: capsule.segment.a.as_dvec3(),
                b: capsule.segment.b.as_dvec3(),
                radius: capsule.radius.into(),
            },
            TypedShape::HalfSpace(half_space) => Self::HalfSpace { normal: half_space.normal.as_dvec3() },
            TypedShape::Cuboid(cuboid) => Self::Cuboid { half: cuboid.half_extents.as_dvec3() },
            TypedShape::TriMesh(mesh) if mesh.pseudo_normals_if_oriented().is_none() => Self::Shell(&**shape),
            TypedShape::TriMesh(mesh) if sheet::is_sheet(mesh) => Self::Sheet(mesh),
            TypedShape::HeightField(field) => Self::Ground(field),
            TypedShape::Compound(compound) => Self::Union(compound),
            TypedShape::Triangle(_) | TypedShape::Segment(_) | TypedShape::Polyline(_) => Self::Shell(&**shape),
            _ => Self::Solid(&**shape),
        }
    }

    /// Whether distances cost no more than those to a box.
    pub fn is_closed_form(&self) -> bool {
        matches!(self, Self::Ball { .. } | Self::Capsule { .. } | Self::HalfSpace { .. } | Self::Cuboid { .. })
    }

    /// Radius of a surface that is round all over, m.
    pub fn roundness(&self) -> Option<f64> {
        match *self {
            Self::Ball { radius } | Self::Capsule { radius, .. } => Some(radius),
            _ => None,
        }
    }

    /// The nearest point of the surface, for a point in the frame of the shape. Where none is within a distance, that distance may
    /// stand for it.
    pub fn nearest(&self, p: DVec3, within: f64) -> Nearest {
        match *self {
            Self::Ground(field) => nearest_of_ground(field, p, within),
            Self::Union(compound) => nearest_of_union(compound, p, within),
            Self::Sheet(mesh) => sheet::nearest(mesh, p, within),
            Self::Ball { radius } => around(p, radius),
            Self::Capsule { a, b, radius } => {
                let axis = b - a;
                let share = (p - a).dot(axis) / axis.length_squared().max(f64::MIN_POSITIVE);
                around(p - a - share.clamp(0.0, 1.0) * axis, radius)
            }
            Self::HalfSpace { normal } => Nearest { distance: normal.dot(p), normal },
            Self::Cuboid { half } => nearest_of_cuboid(p, half),
            Self::Solid(shape) | Self::Shell(shape) => {
                let point = p.as_vec3();
                let found = match shape.as_typed_shape() {
                    // Only so are the pseudo-normals asked which side is inside.
                    TypedShape::TriMesh(mesh) => mesh.project_local_point_and_get_feature(point).0,
                    _ => shape.project_local_point(point, false),
                };
                let away = p - found.point.as_dvec3();
                let distance = away.length();
                // On the surface itself rounding has the direction: outwards is away from the middle then.
                let outwards = || {
                    let middle = shape.compute_local_aabb().center().as_dvec3();
                    (p - middle).try_normalize().unwrap_or(DVec3::Y)
                };
                if distance < 1e-6 {
                    Nearest { distance: 0.0, normal: outwards() }
                } else if found.is_inside && matches!(self, Self::Solid(_)) {
                    Nearest { distance: -distance, normal: -away / distance }
                } else {
                    Nearest { distance, normal: away / distance }
                }
            }
        }
    }

    /// Where the way from one point to another first enters the surface: share of the way, and the normal against it.
    pub fn first_hit(&self, from: DVec3, to: DVec3) -> Option<(f64, DVec3)> {
        let way = to - from;
        match *self {
            Self::HalfSpace { normal } => {
                let (start, end) = (normal.dot(from), normal.dot(to));
                (start >= 0.0 && end < 0.0).then(|| (start / (start - end), normal))
            }
            Self::Ball { radius } => {
                let (a, b) = (way.length_squared(), from.dot(way));
                let root = b * b - a * (from.length_squared() - radius * radius);
                let share = (-b - root.max(0.0).sqrt()) / a;
                (root > 0.0 && (0.0..=1.0).contains(&share)).then(|| (share, (from + share * way) / radius))
            }
            Self::Cuboid { half } => slabs(from, way, half),
            Self::Capsule { a, b, radius } => {
                let middle = 0.5 * (a + b);
                let capsule =
                    parry3d::shape::Capsule::new((a - middle).as_vec3(), (b - middle).as_vec3(), radius as f32);
                cast(&capsule, from - middle, way)
            }
            Self::Solid(shape) | Self::Shell(shape) => cast(shape, from, way),
            Self::Sheet(mesh) => cast(mesh, from, way),
            Self::Ground(field) => cast(field, from, way),
            Self::Union(compound) => cast(compound, from, way),
        }
    }
}

/// Of a ball about the origin.
fn around(p: DVec3, radius: f64) -> Nearest {
    let length = p.length();
    let normal = if length > 0.0 { p / length } else { DVec3::Y };
    Nearest { distance: length - radius, normal }
}

fn nearest_of_cuboid(p: DVec3, half: DVec3) -> Nearest {
    let beyond = p.abs() - half;
    let sign = DVec3::select(p.cmplt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE);
    let outside = beyond.max(DVec3::ZERO);
    let distance = outside.length();
    if distance > 0.0 {
        return Nearest { distance, normal: sign * outside / distance };
    }
    // Inside: the nearest face.
    let nearest = beyond.max_element();
    let axis = if beyond.x == nearest {
        DVec3::X
    } else if beyond.y == nearest {
        DVec3::Y
    } else {
        DVec3::Z
    };
    Nearest { distance: nearest, normal: sign * axis }
}

/// Looks only at triangles that are near: a field may have millions.
fn nearest_of_ground(field: &HeightField, p: DVec3, within: f64) -> Nearest {
    let around = Aabb::from_half_extents(p.as_vec3(), DVec3::splat(within).as_vec3());
    let (mut square, mut steepest) = (within * within, 0.0);
    let mut nearest = Nearest { distance: within, normal: DVec3::Y };
    field.map_elements_in_local_aabb(&around, &mut |_, triangle| {
        let on = triangle.project_local_point(p.as_vec3(), false).point.as_dvec3();
        let away = p - on;
        let Some(up) = triangle.normal().map(|normal| normal.as_dvec3() * f64::from(normal.y.signum())) else { return };
        let above = up.dot(away);
        // At an edge, the triangle that faces the point more says on which side it is.
        let same = (away.length_squared() - square).abs() < 1e-7 * square && above.abs() > steepest;
        if away.length_squared() < square * (1.0 - 1e-7) || same {
            (square, steepest) = (away.length_squared(), above.abs());
            let distance = away.length();
            let normal = if distance < 1e-6 { up } else { away / distance * above.signum() };
            nearest = Nearest { distance: distance * above.signum(), normal };
        }
    });
    nearest
}

/// The least of the distances to its parts, which is negative inside of any. What parry projects on may be a face of one part that is
/// inside of another.
fn nearest_of_union(compound: &Compound, p: DVec3, within: f64) -> Nearest {
    let around = Aabb::from_half_extents(p.as_vec3(), DVec3::splat(within).as_vec3());
    let mut nearest = Nearest { distance: within, normal: DVec3::Y };
    for part in compound.bvh().intersect_aabb(&around) {
        let (pose, shape) = &compound.shapes()[part as usize];
        let rotation: DQuat = pose.rotation.as_dquat().normalize();
        let local = rotation.inverse() * (p - pose.translation.as_dvec3());
        // Behind an open part there may be another: it has no inside then.
        let surface = match Surface::new(shape) {
            Surface::Sheet(_) => Surface::Shell(&**shape),
            other => other,
        };
        let found = surface.nearest(local, within);
        if found.distance < nearest.distance {
            nearest = Nearest { normal: rotation * found.normal, ..found };
        }
    }
    nearest
}

/// Where a way enters a cuboid, if it does (Kay & Kajiya 1986).
fn slabs(from: DVec3, way: DVec3, half: DVec3) -> Option<(f64, DVec3)> {
    let (mut enter, mut leave, mut normal) = (f64::NEG_INFINITY, f64::INFINITY, DVec3::ZERO);
    for axis in 0..3 {
        if way[axis] == 0.0 {
            if from[axis].abs() > half[axis] {
                return None;
            }
            continue;
        }
        let towards = way[axis].signum();
        let near = (-towards * half[axis] - from[axis]) / way[axis];
        let far = (towards * half[axis] - from[axis]) / way[axis];
        if near > enter {
            (enter, normal) = (near, DVec3::ZERO);
            normal[axis] = -towards;
        }
        leave = leave.min(far);
    }
    (enter <= leave && (0.0..=1.0).contains(&enter)).then_some((enter, normal))
}

fn cast(shape: &dyn Shape, from: DVec3, way: DVec3) -> Option<(f64, DVec3)> {
    let hit = shape.cast_local_ray_and_get_normal(&Ray::new(from.as_vec3(), way.as_vec3()), 1.0, false)?;
    let normal = hit.normal.as_dvec3().try_normalize()?;
    Some((hit.time_of_impact.into(), if normal.dot(way) > 0.0 { -normal } else { normal }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry3d::math::Vector;

    /// The closed forms say what parry says, inside and outside, at distances where f32 has digits.
    #[test]
    fn closed_forms_agree_with_parry() {
        let shapes = [
            SharedShape::ball(0.3),
            SharedShape::capsule(Vector::new(-0.2, 0.1, 0.0), Vector::new(0.3, 0.4, 0.2), 0.15),
            SharedShape::cuboid(0.2, 0.3, 0.5),
        ];
        for shape in &shapes {
            let surface = Surface::new(shape);
            for i in 0..500 {
                let t = f64::from(i);
                let p = DVec3::new((1.1 * t).sin(), (2.3 * t).sin(), (3.7 * t).cos()) * 0.7;
                let (ours, theirs) = (surface.nearest(p, 9.0), Surface::Solid(&**shape).nearest(p, 9.0));
                assert!((ours.distance - theirs.distance).abs() < 2e-6, "{p}: {ours:?} {theirs:?}");
                if ours.distance.abs() > 0.02 {
                    assert!(ours.normal.distance(theirs.normal) < 1e-4, "{p}: {ours:?} {theirs:?}");
                }
                let q = DVec3::new((0.7 * t).cos(), (1.9 * t).sin(), (t * t).cos()) * 0.9;
                if ours.distance > 1e-3 {
                    let (ours, theirs) = (surface.first_hit(p, q), cast(&**shape, p, q - p));
                    assert_eq!(
                        ours.is_some(),
                        theirs.is_some(),
                        "{p} {q} {ours:?} {theirs:?} {:?}",
                        shape.shape_type()
                    );
                    if let (Some(ours), Some(theirs)) = (ours, theirs) {
                        // Where the way grazes the surface, or enters at an edge, f32 has few digits.
                        let off = (ours.0 - theirs.0).abs() + 0.1 * ours.1.distance(theirs.1);
                        assert!(off < 1e-2, "{p} {q} {ours:?} {theirs:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_closed_mesh_has_an_inside() {
        let (vertices, indices) = parry3d::shape::Cuboid::new(Vector::ONE).to_trimesh();
        let flags = parry3d::shape::TriMeshFlags::ORIENTED;
        let mesh = SharedShape::trimesh_with_flags(vertices, indices, flags).unwrap();
        let nearest = Surface::new(&mesh).nearest(DVec3::new(0.1, 0.9, 0.2), 9.0);
        assert!((nearest.distance + 0.1).abs() < 1e-6 && nearest.normal.distance(DVec3::Y) < 1e-6, "{nearest:?}");
    }

    #[test]
    fn a_mesh_without_inside_keeps_both_sides_out() {
        let corners = [Vector::ZERO, Vector::X, Vector::Y];
        let mesh = SharedShape::trimesh(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let surface = Surface::new(&mesh);
        for side in [-1.0, 1.0] {
            let nearest = surface.nearest(DVec3::new(0.2, 0.2, 0.1 * side), 9.0);
            assert!((nearest.distance - 0.1).abs() < 1e-6 && nearest.normal.z * side > 0.99);
        }
        assert!(surface.first_hit(DVec3::new(0.2, 0.2, 1.0), DVec3::new(0.2, 0.2, -1.0)).is_some());
    }

    #[test]
    fn what_is_inside_of_a_part_is_inside_of_the_whole() {
        use parry3d::math::Pose;
        let cube = SharedShape::cuboid(0.5, 0.5, 0.5);
        let at = |x, y| (Pose::from_translation(Vector::new(x, y, 0.0)), cube.clone());
        // The right one is lower: below its top, their common face is inside.
        let stairs = SharedShape::compound(vec![at(-0.5, 0.0), at(0.5, -0.2)]);
        let surface = Surface::new(&stairs);
        for (x, distance) in [(0.01, -0.01), (-0.01, -0.01), (0.3, -0.1)] {
            let nearest = surface.nearest(DVec3::new(x, 0.2, 0.0), 9.0);
            assert!((nearest.distance - distance).abs() < 1e-6, "{x}: {nearest:?}");
        }
        let riser = surface.nearest(DVec3::new(0.1, 0.45, 0.0), 0.12);
        assert!((riser.distance - 0.1).abs() < 1e-6 && riser.normal.distance(DVec3::X) < 1e-6, "{riser:?}");
        assert_eq!(surface.nearest(DVec3::new(0.0, 2.0, 0.0), 0.3).distance, 0.3);
    }

    #[test]
    fn ground_has_its_inside_below() {
        let heights = parry3d::utils::Array2::new(2, 2, vec![0.0, 0.0, 0.5, 0.5]);
        let slope = SharedShape::new(HeightField::new(heights, Vector::new(1.0, 1.0, 1.0)));
        let surface = Surface::new(&slope);
        let up = DVec3::new(-1.0, 2.0, 0.0).normalize();
        for off in [0.1, -0.1] {
            let nearest = surface.nearest(DVec3::new(0.0, 0.25, 0.1) + off * up, 0.3);
            assert!((nearest.distance - off).abs() < 1e-6 && nearest.normal.distance(up) < 1e-5, "{nearest:?}");
        }
        assert_eq!(surface.nearest(DVec3::new(0.0, -2.0, 0.1), 0.3).distance, 0.3);
    }
}
