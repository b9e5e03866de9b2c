//! Where a corner or an edge of a collider meets a triangle between its vertices, in the frame of the collider.

use bevy::math::DVec3;

use super::features::Feature;

/// Times in a step, at most, that what is fast is looked at.
const MOST_LOOKS: f64 = 16.0;
/// Share of a side that a place on it is away from a vertex at least: a vertex has a touch of its own.
const INSIDE: f64 = 1e-3;

/// Sine of the angle between two edges below which they go along each other: where they are nearest says little then.
const ALONG: f64 = 0.2;

/// A triangle on its way through a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passing {
    pub start: [DVec3; 3],
    pub end: [DVec3; 3],
}

/// A place of a triangle that is near a feature.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    /// Weights of the vertices.
    pub weights: [f64; 3],
    /// Outward unit normal of the collider.
    pub normal: DVec3,
    /// Nearest place of the feature, m.
    pub place: DVec3,
    /// Distance from there, less the radius, m.
    pub gap: f64,
}

/// How near is near, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub thickness: f64,
    pub reach: f64,
    /// What is deeper inside came from another side.
    pub deepest: f64,
}

impl Passing {
    /// Length of the longest way of a vertex, m.
    pub fn travel(&self) -> f64 {
        (0..3).map(|i| self.start[i].distance_squared(self.end[i])).fold(0.0, f64::max).sqrt()
    }

    /// Box of all of it, wider by a distance, m.
    pub fn bounds(&self, wider: f64) -> [DVec3; 2] {
        let points = self.start.into_iter().chain(self.end);
        let (low, high) =
            points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)));
        [low - wider, high + wider]
    }

    /// Where the triangle first meets a feature: its inside a corner, its sides an edge.
    pub fn meet(&self, feature: &Feature, limits: Limits, mut then: impl FnMut(Between)) {
        if feature.is_corner() {
            self.first(feature, limits, corner).map(&mut then);
            return;
        }
        for side in 0..3 {
            let edge = |points: [DVec3; 3], feature: &Feature, before: DVec3| {
                edge(points, side, feature, before, limits.reach)
            };
            self.first(feature, limits, edge).map(&mut then);
        }
    }

    fn first(
        &self,
        feature: &Feature,
        limits: Limits,
        near: impl Fn([DVec3; 3], &Feature, DVec3) -> Option<Between>,
    ) -> Option<Between> {
        let travel = self.travel();
        let looks = (travel / limits.thickness).ceil().clamp(1.0, MOST_LOOKS);
        let middle = |points: [DVec3; 3]| (points[0] + points[1] + points[2]) / 3.0;
        let before = middle(self.start) - 0.5 * (feature.ends[0] + feature.ends[1]);
        let mut step = 0.0;
        while step < looks {
            step += 1.0;
            let points = [0, 1, 2].map(|i| self.start[i].lerp(self.end[i], step / looks));
            let enough = if step < looks { limits.thickness } else { limits.reach };
            let deepest = limits.deepest.max(if looks > 1.0 { travel / looks } else { 0.0 });
            let found = near(points, feature, before).filter(|found| (-deepest..enough).contains(&found.gap));
            if found.is_some() {
                return found;
            }
        }
        None
    }
}

/// Of a corner, the place in a triangle.
fn corner([a, b, c]: [DVec3; 3], feature: &Feature, before: DVec3) -> Option<Between> {
    let corner = feature.ends[0];
    let double_area = (b - a).cross(c - a);
    let across = double_area.try_normalize()?;
    let part = |from: DVec3, to: DVec3| (from - corner).cross(to - corner).dot(across) / double_area.length();
    let weights = [part(b, c), part(c, a), part(a, b)];
    if weights.iter().any(|&weight| weight < 0.0) {
        return if feature.radius > 0.0 { beside([a, b, c], feature) } else { None };
    }
    if weights.iter().any(|&weight| weight > 1.0 - INSIDE) {
        return None;
    }
    let above = (a - corner).dot(across) * across;
    let normal = feature.normal(across, if feature.radius > 0.0 { above } else { before })?;
    Some(Between { weights, normal, place: corner, gap: normal.dot(above) - feature.radius })
}

/// Of a round corner, the nearest place on the sides of a triangle.
fn beside(points: [DVec3; 3], feature: &Feature) -> Option<Between> {
    let corner = feature.ends[0];
    let places = (0..3).filter_map(|i| {
        let j = (i + 1) % 3;
        let side = points[j] - points[i];
        let share = (corner - points[i]).dot(side) / side.length_squared();
        let away = points[i] + share * side - corner;
        let inside = (INSIDE..1.0 - INSIDE).contains(&share);
        let normal = away.try_normalize().filter(|&away| inside && feature.normal(away, away) == Some(away))?;
        let mut weights = [0.0; 3];
        (weights[i], weights[j]) = (1.0 - share, share);
        Some(Between { weights, normal, place: corner, gap: away.length() - feature.radius })
    });
    places.min_by(|a, b| a.gap.total_cmp(&b.gap))
}

/// Of an edge, the place on the side of a triangle that begins at a vertex. What is within `reach` of a corner is left to that:
/// both together would ask for more than the distance.
fn edge(points: [DVec3; 3], side: usize, feature: &Feature, before: DVec3, reach: f64) -> Option<Between> {
    let other = (side + 1) % 3;
    let (a, b) = (points[side], points[other] - points[side]);
    let (c, d) = (feature.ends[0], feature.ends[1] - feature.ends[0]);
    let cross = b.cross(d);
    let square = cross.length_squared();
    if square < ALONG * ALONG * b.length_squared() * d.length_squared() {
        return None;
    }
    let across = cross.try_normalize()?;
    let between = c - a;
    let (on_side, on_edge) = (between.cross(d).dot(cross) / square, between.cross(b).dot(cross) / square);
    if !(INSIDE..1.0 - INSIDE).contains(&on_side) || !(0.0..=1.0).contains(&on_edge) {
        return None;
    }
    let to_ends = [on_edge, 1.0 - on_edge].map(|share| share * d.length());
    if (0..2).any(|end| feature.at_corners[end] && to_ends[end] < reach) {
        return None;
    }
    let place = c + on_edge * d;
    let away = a + on_side * b - place;
    let normal = feature.normal(across, if feature.radius > 0.0 { away } else { before })?;
    let mut weights = [0.0; 3];
    (weights[side], weights[other]) = (1.0 - on_side, on_side);
    Some(Between { weights, normal, place, gap: normal.dot(away) - feature.radius })
}

#[cfg(test)]
mod tests {
    use parry3d::shape::SharedShape;

    use super::super::features::Features;
    use super::*;

    const LIMITS: Limits = Limits { thickness: 0.003, reach: 0.006, deepest: 0.012 };

    fn meetings(shape: &SharedShape, passing: Passing) -> Vec<(bool, Between)> {
        let mut found = Vec::new();
        for feature in Features::new(shape).all() {
            passing.meet(feature, LIMITS, |between| found.push((feature.is_corner(), between)));
        }
        found
    }

    fn flat(height: f64) -> [DVec3; 3] {
        [DVec3::new(-0.4, height, -0.3), DVec3::new(0.5, height, -0.3), DVec3::new(0.0, height, 0.6)]
    }

    fn at_rest(height: f64) -> Passing {
        Passing { start: flat(height), end: flat(height) }
    }

    #[test]
    fn a_ball_in_a_triangle_is_a_corner() {
        let found = meetings(&SharedShape::ball(0.05), at_rest(0.052));
        assert_eq!(found.len(), 1);
        let (corner, between) = found[0];
        assert!(corner && between.normal == DVec3::Y && (between.gap - 0.002).abs() < 1e-8);
        let place: DVec3 = (0..3).map(|i| between.weights[i] * flat(0.052)[i]).sum();
        assert!(place.distance(DVec3::Y * 0.052) < 1e-12, "{place}");
        assert!(meetings(&SharedShape::ball(0.05), at_rest(0.06)).is_empty());
    }

    #[test]
    fn a_rod_crosses_two_sides() {
        let rod = SharedShape::capsule_x(1.0, 0.01);
        for height in [0.012, -0.012] {
            let found = meetings(&rod, at_rest(height));
            assert_eq!(found.len(), 2, "{found:?}");
            for (corner, between) in found {
                assert!(!corner && between.normal.distance(DVec3::Y * height.signum()) < 1e-9);
                assert!((between.gap - 0.002).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn a_fast_triangle_meets_the_side_that_it_came_from() {
        let rod = SharedShape::capsule_x(1.0, 0.01);
        let passing = Passing { start: flat(0.1), end: flat(-0.1) };
        let found = meetings(&rod, passing);
        assert!(found.len() == 2 && found.iter().all(|(_, between)| between.normal.distance(DVec3::Y) < 1e-9));
    }

    #[test]
    fn an_upright_corner_is_met_from_above_only() {
        use parry3d::math::{Pose, Rotation, Vector};
        let upright = Rotation::from_rotation_arc(Vector::ONE.normalize(), Vector::Y);
        let half = 0.1_f32;
        let place = Pose::from_parts(Vector::NEG_Y * half * 3.0_f32.sqrt(), upright);
        let shape = SharedShape::compound(vec![(place, SharedShape::cuboid(half, half, half))]);
        for (height, touches) in [(0.002, true), (-0.004, true), (0.01, false), (-0.05, false)] {
            let found = meetings(&shape, at_rest(height));
            let above = found.iter().filter(|(corner, _)| *corner).count();
            assert_eq!(above == 1, touches, "{height}: {found:?}");
            assert!(found.iter().all(|(_, between)| between.normal.y > 0.5), "{height}: {found:?}");
        }
    }
}
