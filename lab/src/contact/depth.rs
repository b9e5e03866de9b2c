//! How deep a cloth is in solids, by what the physics does not know.

use bevy::math::DVec3;
use bevy_cloth::physics::Cloth;

use super::body::Body;

/// Shares of the corners in points of a triangle: its middle, and those of its edges.
const MIDDLES: [DVec3; 4] =
    [DVec3::splat(1.0 / 3.0), DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.0, 0.5, 0.5), DVec3::new(0.5, 0.0, 0.5)];

/// Points of a path at most: for what is faster than that, others than this look.
const MOST_POINTS: f64 = 256.0;

/// The deepest vertex, m: below zero where all are outside, by so much.
pub fn vertices(cloth: &Cloth, bodies: &[Body], time: f64) -> f64 {
    deepest(bodies, time, cloth.positions().iter().copied())
}

/// The deepest of four points in every triangle, m.
pub fn faces(cloth: &Cloth, bodies: &[Body], time: f64) -> f64 {
    sampled(cloth, bodies, time, &MIDDLES)
}

/// The deepest of so many points along every edge of every triangle, and all of the lattice between, m; or what a corner of a
/// cuboid looks out of a triangle, whose points may all be beside that corner.
pub fn dense(cloth: &Cloth, bodies: &[Body], time: f64, along: u32) -> f64 {
    let shares = lattice(along);
    corners(cloth, bodies, time, along).max(sampled(cloth, bodies, time, &shares))
}

fn sampled(cloth: &Cloth, bodies: &[Body], time: f64, shares: &[DVec3]) -> f64 {
    let points = triangles(cloth).flat_map(|[a, b, c]| shares.iter().map(move |s| s.x * a + s.y * b + s.z * c));
    deepest(bodies, time, points)
}

fn triangles(cloth: &Cloth) -> impl Iterator<Item = [DVec3; 3]> + Clone {
    cloth.shape().triangles.iter().map(|triangle| triangle.vertices.map(|v| cloth.positions()[v as usize]))
}

fn deepest(bodies: &[Body], time: f64, points: impl Iterator<Item = DVec3> + Clone) -> f64 {
    let of = |body: &Body| {
        let pose = body.pose(time);
        points.clone().map(|point| -body.solid.distance(pose.local(point))).fold(f64::NEG_INFINITY, f64::max)
    };
    bodies.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

fn lattice(along: u32) -> Vec<DVec3> {
    let share = |i: u32| f64::from(i) / f64::from(along);
    let points = (0..=along).flat_map(|i| (0..=along - i).map(move |j| (i, j)));
    points.map(|(i, j)| DVec3::new(share(i), share(j), share(along - i - j))).collect()
}

/// How far the corners of cuboids look out of triangles, m. What is further out than the sides are long from sample to sample
/// would have a sample inside: if it has none, it belongs to another fold.
fn corners(cloth: &Cloth, bodies: &[Body], time: f64, along: u32) -> f64 {
    let mut deepest = f64::NEG_INFINITY;
    let longest =
        triangles(cloth).map(|[a, b, c]| a.distance(b).max(b.distance(c)).max(c.distance(a))).fold(0.0, f64::max);
    for body in bodies {
        let (pose, most) = (body.pose(time), (2.0 * body.solid.core()).min(longest / f64::from(along)));
        for corner in body.solid.corners().into_iter().map(|corner| pose.place(corner)) {
            let out_of = |triangle| out_of(triangle, corner, pose.translation);
            let out = triangles(cloth).filter_map(out_of).filter(|&out| out < most);
            deepest = out.fold(deepest, f64::max);
        }
    }
    deepest
}

/// How far a corner is beyond a triangle, seen from the middle of its solid, m, if it is over or under it at all. Which side of the
/// cloth it looks out of does not matter: it may be folded.
fn out_of([a, b, c]: [DVec3; 3], corner: DVec3, middle: DVec3) -> Option<f64> {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let inside = |from: DVec3, to: DVec3| (to - from).cross(corner - from).dot(normal) >= 0.0;
    let outwards = normal.dot(corner - middle).signum();
    (normal != DVec3::ZERO && inside(a, b) && inside(b, c) && inside(c, a)).then(|| outwards * (corner - a).dot(normal))
}

/// Vertices that went straight from `before` to `after` between two shares of a step, in which bodies go straight between two times, and
/// on the way were so deep in a body that they have passed through it.
pub fn passed([before, after]: [&[DVec3]; 2], bodies: &[Body], [start, end]: [f64; 2], [done, then]: [f64; 2]) -> u32 {
    let mut passed = 0;
    for body in bodies {
        let pose = |share| body.pose(start).towards(&body.pose(end), share);
        let (from, to, core) = (pose(done), pose(then), body.solid.core());
        for (&x, &y) in before.iter().zip(after) {
            let (distance, carried) = (body.solid.distance(from.local(x)), to.place(from.local(x)));
            // A turning body moves on an arc, which is longer than its chord.
            let way = 1.1 * (y - x).length() + 1.1 * (carried - x).length();
            if distance > way || !y.is_finite() {
                continue;
            }
            let points = (way / core).ceil().clamp(1.0, MOST_POINTS) as u32;
            let depth = |i: u32| {
                let share = f64::from(i) / f64::from(points);
                -body.solid.distance(from.towards(&to, share).local(x.lerp(y, share)))
            };
            passed += u32::from((1..=points).any(|i| depth(i) > core));
        }
    }
    passed
}

#[cfg(test)]
mod tests {
    use bevy::math::DQuat;
    use bevy_cloth::physics::{Pose, SolverSettings};

    use super::*;
    use crate::contact::solid::Solid;
    use crate::scenes::fabric;
    use crate::validate::strip::{Strip, place};

    /// One square of 0.2 m around the origin, at a height.
    fn square(height: f64) -> Cloth {
        let mut cloth = Strip::new(0.2, 0.2, 1, 1).cloth(fabric(), SolverSettings::default());
        place(&mut cloth, |x| x + DVec3::new(-0.1, height, -0.1));
        cloth
    }

    #[test]
    fn a_face_may_be_in_a_ball_whose_surface_no_vertex_reaches() {
        let ball = [Body::fixed(Solid::Ball { radius: 0.1 }, 0.5, Pose::IDENTITY)];
        let cloth = square(0.08);
        // The vertices are at √(0.1² + 0.1² + 0.08²), the middle of the diagonal at 0.08.
        assert!((vertices(&cloth, &ball, 0.0) - (0.1 - 0.0264_f64.sqrt())).abs() < 1e-12);
        assert!((faces(&cloth, &ball, 0.0) - 0.02).abs() < 1e-12);
        assert!((dense(&cloth, &ball, 0.0, 4) - 0.02).abs() < 1e-12);
        assert_eq!(lattice(4).len(), 15);
    }

    #[test]
    fn a_corner_between_all_samples_is_found() {
        let half = DVec3::splat(0.1);
        // A diagonal of the cuboid upright under a triangle, its corner 5 mm above it.
        let turn = DQuat::from_rotation_arc(half.normalize(), DVec3::Y);
        let cuboid = |top: f64| {
            let at = DVec3::new(0.031, top - half.length(), -0.047);
            [Body::fixed(Solid::Cuboid { half }, 0.5, Pose { translation: at, rotation: turn })]
        };
        let mut turned_over = square(0.0);
        place(&mut turned_over, |x| DVec3::new(0.1 - x.x, 0.0, x.z - 0.1));
        for cloth in [square(0.0), turned_over] {
            assert!(faces(&cloth, &cuboid(0.005), 0.0) < 0.0);
            assert!((dense(&cloth, &cuboid(0.005), 0.0, 2) - 0.005).abs() < 1e-9);
            assert!((dense(&cloth, &cuboid(-0.005), 0.0, 2) + 0.005).abs() < 1e-9);
        }
    }

    #[test]
    fn what_jumps_over_a_wall_has_passed_and_what_is_carried_has_not() {
        let wall = || Solid::Cuboid { half: DVec3::new(1.0, 0.005, 1.0) };
        let (below, above) = (square(-0.4), square(0.4));
        let standing = [Body::fixed(wall(), 0.5, Pose::IDENTITY)];
        assert_eq!(passed([below.positions(), above.positions()], &standing, [0.0, 1.0], [0.0, 1.0]), 4);
        assert_eq!(passed([square(0.1).positions(), above.positions()], &standing, [0.0, 1.0], [0.0, 1.0]), 0);
        // From −0.5 m to 0.3 m: it pushes what it finds at −0.4 m.
        let pushing = [Body::moving(wall(), 0.5, |t| Pose::at(DVec3::Y * (0.8 * t - 0.5)))];
        assert_eq!(passed([below.positions(), above.positions()], &pushing, [0.0, 1.0], [0.0, 1.0]), 0);
        assert_eq!(passed([below.positions(), below.positions()], &pushing, [0.0, 1.0], [0.0, 1.0]), 4);
    }

    #[test]
    fn a_paddle_pushes_a_vertex_around_without_passing_it() {
        let paddle = Solid::Cuboid { half: DVec3::new(0.3, 0.015, 0.3) };
        let pose = |t| Pose { translation: DVec3::ZERO, rotation: DQuat::from_rotation_z(t) };
        let paddle = [Body::moving(paddle, 0.5, pose)];
        // On its front, and a third of a right angle and more later.
        let on_front = |cloth: &mut Cloth, t: f64| {
            place(cloth, |x| DQuat::from_rotation_z(t) * DVec3::new(0.25 * x.x, 0.018, x.z - 0.1));
        };
        let (mut before, mut after) = (square(0.0), square(0.0));
        on_front(&mut before, 0.0);
        on_front(&mut after, 1.05);
        assert_eq!(passed([before.positions(), after.positions()], &paddle, [0.0, 1.05], [0.0, 1.0]), 0);
        let pushed = (before.positions()[1] - before.positions()[0]).length();
        assert!(pushed > 0.0 && passed([before.positions(), before.positions()], &paddle, [0.0, 1.05], [0.0, 1.0]) > 0);
    }
}
