//! Where a point meets a collider in a step.

use bevy::math::{DMat3, DVec3};

use super::between::Between;
use super::collider::{Collider, Pose};
use super::surface::{Nearest, Surface};

/// Share of what a point is too close to a collider that it may go away from it in a step, and how fast at most, m/s. What is
/// pushed out at once would fly off.
const RECOVERY: f64 = 0.02;
const RECOVERY_SPEED: f64 = 0.5;
/// Cosine of the angle between the surface where it is entered and where it is nearest, above which the nearest counts.
const SAME_SIDE: f64 = 0.5;
/// What of the way and of the distances to a surface is rounding, as a share and m: a way straight across it is as long as both
/// distances, which are made of f32.
const ROUNDING: f64 = 1e-5;
const ROUNDING_LENGTH: f64 = 1e-6;
/// A point so far behind a surface that is solid from one side is there because nothing kept it from going there, m. Less than a
/// thickness: what hangs around its rim keeps that distance from it, below as well, and stays there.
const BEHIND: f64 = 1e-3;

/// A collider in one substep.
pub(super) struct Body<'a> {
    surface: Surface<'a>,
    start: Frame,
    end: Frame,
    /// Box around the shape in its own frame, m.
    own_box: (DVec3, DVec3),
    /// Box that the collider is in at the start and at the end, m; `None` if it has no end.
    bounds: Option<(DVec3, DVec3)>,
}

/// A pose whose rotation is a matrix: points are many, poses few.
struct Frame {
    translation: DVec3,
    rotation: DMat3,
}

impl Frame {
    fn new(pose: &Pose) -> Self {
        Self { translation: pose.translation, rotation: DMat3::from_quat(pose.rotation.normalize()) }
    }

    fn place(&self, local: DVec3) -> DVec3 {
        self.translation + self.rotation * local
    }

    fn local(&self, world: DVec3) -> DVec3 {
        self.rotation.transpose() * (world - self.translation)
    }
}

/// The plane that keeps a point out of a collider at the end of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// Outward unit normal.
    pub normal: DVec3,
    /// The point x stays where `normal·x ≥ offset`, m.
    pub offset: f64,
    /// Where normal·x is on the surface, m.
    pub surface: f64,
    /// Where the point would be if it stuck to the collider, m.
    pub carried: DVec3,
}

impl<'a> Body<'a> {
    /// For the part of the step between these shares of it.
    pub fn new(collider: &'a Collider, from: f64, to: f64) -> Self {
        let pose = |share| Frame::new(&collider.start.towards(&collider.end, share));
        let (start, end) = (pose(from), pose(to));
        let surface = Surface::new(&collider.shape);
        let own = collider.shape.compute_local_aabb();
        let own_box = (own.mins.as_dvec3(), own.maxs.as_dvec3());
        let bounds = (!matches!(surface, Surface::HalfSpace { .. })).then(|| {
            let sphere = own.bounding_sphere();
            let (centre, radius) = (sphere.center.as_dvec3(), DVec3::splat(sphere.radius.into()));
            let (a, b) = (start.place(centre), end.place(centre));
            (a.min(b) - radius, a.max(b) + radius)
        });
        Self { surface, start, end, own_box, bounds }
    }

    /// How far an arc of a round collider bulges over its chord, which is a side of this length, m; 0 if it is not round.
    pub fn bulge(&self, side: f64) -> f64 {
        self.roundness().map_or(0.0, |radius| side * side / (8.0 * radius))
    }

    /// Radius of a surface that is round all over, and has neither corners nor edges, m.
    pub fn roundness(&self) -> Option<f64> {
        self.surface.roundness()
    }

    /// How fast a point of the collider is that is at a place of the world at the end, m/s.
    pub fn velocity(&self, place: DVec3, dt: f64) -> DVec3 {
        (place - self.start.place(self.end.local(place))) / dt
    }

    /// How far a point of the collider goes at most, m; infinite if it turns and has no end.
    pub fn travel(&self) -> f64 {
        let Some((low, high)) = self.bounds else {
            let turns = self.start.rotation != self.end.rotation;
            return if turns { f64::INFINITY } else { self.start.translation.distance(self.end.translation) };
        };
        let corners = [low.x, high.x].into_iter().flat_map(|x| [low.y, high.y].map(|y| (x, y)));
        let corners = corners.flat_map(|(x, y)| [low.z, high.z].map(|z| DVec3::new(x, y, z)));
        corners.map(|corner| corner.distance(self.end.place(self.start.local(corner)))).fold(0.0, f64::max)
    }

    /// How far the collider stays from a box at least, m; 0 if that is not known.
    pub fn distance_to_box(&self, low: DVec3, high: DVec3) -> f64 {
        self.bounds.map_or(0.0, |(a, b)| (low - b).max(a - high).max_element().max(0.0))
    }

    /// Turns a vector from the frame of the collider at the start into the world at the end.
    pub fn turn(&self, vector: DVec3) -> DVec3 {
        self.end.rotation * vector
    }

    /// Turns a vector from the world at the end into the frame of the collider.
    pub fn turn_back(&self, vector: DVec3) -> DVec3 {
        self.end.rotation.transpose() * vector
    }

    /// The nearest point of the surface, all in the frame of the collider. Where nothing is within a distance, little is looked at,
    /// and only the distance says something: there is so much room at least.
    pub fn nearest(&self, point: DVec3, within: f64) -> Nearest {
        if self.surface.is_closed_form() {
            return self.surface.nearest(point, within);
        }
        let (low, high) = self.own_box;
        let to_box = (low - point).max(point - high).max(DVec3::ZERO).length();
        if to_box > within {
            return Nearest { distance: to_box, normal: DVec3::ZERO };
        }
        self.surface.nearest(point, within)
    }

    /// Points of the world at the start and at the end, in the frame of the collider.
    pub fn local(&self, start: DVec3, end: DVec3) -> [DVec3; 2] {
        [self.local_start(start), self.end.local(end)]
    }

    /// A point of the world at the start, in the frame of the collider.
    pub fn local_start(&self, start: DVec3) -> DVec3 {
        self.start.local(start)
    }

    /// The meeting with a point that goes `from` somewhere `to` about there, in the frame of the collider, to which the surface is
    /// `nearest`, if it comes closer than `reach`; it keeps `thickness` (all m). Otherwise the distance there is room for.
    pub fn meet(
        &self,
        [from, to]: [DVec3; 2],
        mut nearest: Nearest,
        [thickness, reach]: [f64; 2],
        dt: f64,
    ) -> Result<Meeting, f64> {
        let way = from.distance(to);
        // What is further from the surface than it goes has not met it.
        if nearest.distance > reach && nearest.distance >= way {
            return Err(nearest.distance - reach);
        }
        let before = self.nearest(from, way + reach);
        if self.is_behind(before.distance) {
            return Err(nearest.distance.abs());
        }
        let outside = before.distance > 0.0;
        if outside
            && (nearest.distance <= 0.0
                || way * (1.0 + ROUNDING) + ROUNDING_LENGTH >= nearest.distance + before.distance)
            && let Some((share, normal)) = self.surface.first_hit(from, to)
            && !(nearest.normal.dot(normal) > SAME_SIDE && nearest.distance <= 0.0)
        {
            let distance = normal.dot(to - from) * (1.0 - share);
            nearest = Nearest { distance: distance.min(0.0), normal };
        }
        if nearest.distance > reach {
            return Err(nearest.distance - reach);
        }
        let normal = self.end.rotation * nearest.normal;
        let surface = normal.dot(self.end.place(to)) - nearest.distance;
        let offset = surface + kept(before.distance, thickness, dt);
        Ok(Meeting { normal, offset, surface, carried: self.end.place(from) })
    }

    /// Whether the other side of a surface that is solid from one is so far away, m, when the substep begins.
    fn is_behind(&self, distance: f64) -> bool {
        distance < -BEHIND && matches!(self.surface, Surface::Sheet(_))
    }

    /// Whether a place of the cloth that is at `x` when the substep begins is on the free side of what it meets.
    pub fn is_passed_by(&self, meeting: &Meeting, x: DVec3) -> bool {
        self.is_behind(meeting.normal.dot(self.end.place(self.start.local(x))) - meeting.surface)
    }

    /// The meeting of a place of a triangle that is `from` in the frame of the collider when the step begins.
    pub fn meet_between(&self, from: DVec3, between: &Between, radius: f64, thickness: f64, dt: f64) -> Meeting {
        let normal = self.end.rotation * between.normal;
        let surface = normal.dot(self.end.place(between.place)) + radius;
        let before = between.normal.dot(from - between.place) - radius;
        Meeting { normal, offset: surface + kept(before, thickness, dt), surface, carried: self.end.place(from) }
    }
}

/// The distance that is kept by what was so far away before, m.
fn kept(before: f64, thickness: f64, dt: f64) -> f64 {
    let missing = thickness - before;
    if missing > 0.0 { before + missing * RECOVERY.min(RECOVERY_SPEED * dt / missing) } else { thickness }
}

#[cfg(test)]
mod tests {
    use bevy::math::DQuat;
    use parry3d::shape::SharedShape;

    use super::*;

    fn meet(body: &Body, x: DVec3, y: DVec3, dt: f64) -> Meeting {
        let way = body.local(x, y);
        body.meet(way, body.nearest(way[1], 9.0), [0.003, 0.006], dt).unwrap()
    }

    #[test]
    fn a_fast_point_meets_the_side_that_it_came_from() {
        let wall = Collider::fixed(0, SharedShape::cuboid(1.0, 1.0, 0.005), Pose::IDENTITY, 0.5);
        let body = Body::new(&wall, 0.0, 1.0);
        let meeting = meet(&body, DVec3::Z * 0.3, DVec3::Z * -0.5, 0.016);
        assert!(meeting.normal.distance(DVec3::Z) < 1e-12 && (meeting.offset - 0.008).abs() < 1e-8, "{meeting:?}");
    }

    #[test]
    fn a_fast_collider_meets_a_point_at_rest() {
        let (start, end) = (Pose::at(DVec3::new(0.0, 1.0, 0.0)), Pose::at(DVec3::new(0.0, -1.0, 0.0)));
        let ball = Collider { start, end, ..Collider::fixed(0, SharedShape::ball(0.1), start, 0.5) };
        let body = Body::new(&ball, 0.0, 1.0);
        let meeting = meet(&body, DVec3::ZERO, DVec3::ZERO, 0.016);
        // Carried before the ball: below where it ends.
        assert!(meeting.normal.distance(DVec3::NEG_Y) < 1e-9 && (meeting.offset - 1.103).abs() < 1e-8, "{meeting:?}");
        assert!(meeting.carried.distance(DVec3::new(0.0, -2.0, 0.0)) < 1e-12);
    }

    #[test]
    fn what_begins_inside_comes_out_slowly() {
        let ball = Collider::fixed(0, SharedShape::ball(0.5), Pose::IDENTITY, 0.5);
        let body = Body::new(&ball, 0.0, 1.0);
        let x = DVec3::new(0.2, 0.0, 0.0);
        let meeting = meet(&body, x, x, 0.01);
        assert!((meeting.offset - (0.2 + 0.005)).abs() < 1e-12, "{meeting:?}");
        assert!((body.nearest(x, 9.0).distance + 0.3).abs() < 1e-12);
    }

    #[test]
    fn a_turning_collider_carries_what_sticks_to_it() {
        let turned = Pose { rotation: DQuat::from_rotation_y(0.2), ..Pose::IDENTITY };
        let disc =
            Collider { end: turned, ..Collider::fixed(0, SharedShape::cylinder(0.01, 1.0), Pose::IDENTITY, 0.5) };
        let x = DVec3::new(0.5, 0.012, 0.0);
        let meeting = meet(&Body::new(&disc, 0.0, 1.0), x, x, 0.016);
        assert!(meeting.carried.distance(turned.rotation * x) < 1e-12 && meeting.normal.y > 0.999);
    }
}
