//! What is drawn of a cloth: where it was simulated, at the time and in the place of what is drawn around it.
//!
//! The picture shows the cloth between its last two steps, but its entity and the colliders where the last frame left them, which is a
//! little later. To bring these times together:
//!
//! 1. A held cloth is drawn in the frame of its entity, so that pins are exact on the body that is drawn, and a cape goes with its wearer.
//!    A free cloth is carried along by the collider that it lies on.
//! 2. This shift from the simulated to the drawn place is reduced, vertex by vertex, as far as it leads into a collider, so that no vertex
//!    is drawn deeper inside than it was simulated.

use bevy::math::{DAffine3, DVec3};
use bevy::prelude::*;
use parry3d::shape::SharedShape;

use super::contact::{ClothCollider, Met, placed};
use super::geometry::extent;
use super::state::{ClothState, ShownFrom, usable};
use crate::physics::Pose;
use crate::physics::contact::distance;

/// What a motion of the picture leads into a collider, it loses, from so many of its lengths away on. At three, the picture of a point
/// that is `h` away comes no nearer than 5/8 h: the most that is left of an inward way w is w r(h/3w) ≤ 3/8 h.
const WITHIN: f64 = 3.0;
/// Motions of the picture that are none, m.
const STILL: f64 = 1e-5;
/// Determinant of an interpolated transform relative to the later one, below which it has no usable inverse.
const FOLDED: f64 = 1e-3;

/// A collider that is drawn elsewhere than the picture of the cloth would have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Obstacle {
    /// Index among [`ClothState::met`].
    index: usize,
    /// Where it was in the moment of the simulation that is shown, and where it is drawn.
    simulated: Pose,
    drawn: Pose,
}

impl ClothState {
    /// What the mesh should show; `None` if it does already, or nothing can be shown.
    pub(super) fn to_show(
        &self,
        transform: &GlobalTransform,
        fraction: f32,
        disabled: bool,
        colliders: &Query<&GlobalTransform, With<ClothCollider>>,
    ) -> Option<ShownFrom> {
        // A cloth that is not stepped moves rigidly with its entity; what it shows changes only if it is placed anew.
        let still = disabled || self.suspended;
        if still && self.shown.from.as_ref().is_some_and(|from| from.revision == self.revision) {
            return None;
        }
        let alpha = if self.stepped { self.pace.shown(fraction) } else { 1.0 };
        let drawn = usable(transform);
        let (alpha, frame) = if self.is_anchored() || still {
            // In the frame of its entity, so that held vertices keep their place to the last bit, however fast it moves.
            interpolated_frame(self.previous_anchor, self.anchor, alpha)
        } else {
            (alpha, drawn.as_ref().ok()?.inverse())
        };
        let mut from =
            ShownFrom { revision: self.revision, alpha, frame, obstacles: Vec::new(), drawn: DAffine3::IDENTITY };
        if let Ok(drawn) = drawn
            && !still
        {
            from.obstacles = self.obstacles(alpha, drawn * frame, colliders);
            if !from.obstacles.is_empty() {
                from.drawn = drawn;
            }
        }
        (self.shown.from.as_ref() != Some(&from)).then_some(from)
    }

    /// Colliders near the cloth that are not drawn where the picture, which is carried by `carried`, would have them.
    fn obstacles(
        &self,
        alpha: f32,
        carried: DAffine3,
        colliders: &Query<&GlobalTransform, With<ClothCollider>>,
    ) -> Vec<Obstacle> {
        if self.met.is_empty() {
            return Vec::new();
        }
        let [low, high] = extent(self.cloth.positions().iter().copied());
        // Affine maps that agree at four places which are not in a plane agree everywhere.
        let corners = [low, DVec3::new(high.x, low.y, low.z), DVec3::new(low.x, high.y, low.z), high];
        let obstacle = |(index, met): (usize, &Met)| {
            let (drawn, _) = placed(&usable(colliders.get(met.entity).ok()?).ok()?);
            let simulated = met.start.towards(&met.end, alpha.into());
            let off = |p: DVec3| carried.transform_point3(p).distance(drawn.place(simulated.local(p)));
            corners.into_iter().any(|p| off(p) > STILL).then_some(Obstacle { index, simulated, drawn })
        };
        self.met.iter().enumerate().filter_map(obstacle).collect()
    }

    /// Where the simulated vertices are shown, in the space of the mesh.
    pub(super) fn pictured(&self, from: &ShownFrom) -> Vec<DVec3> {
        let alpha = f64::from(from.alpha);
        let simulated = self.previous_positions.iter().zip(self.cloth.positions());
        let simulated = simulated.map(|(before, now)| before.lerp(*now, alpha));
        if from.obstacles.is_empty() {
            return simulated.map(|world| from.frame.transform_point3(world)).collect();
        }
        let anchored = self.is_anchored();
        let shape = |obstacle: &Obstacle| &self.met[obstacle.index].shape;
        let obstacles: Vec<_> = from.obstacles.iter().map(|obstacle| Around::new(shape(obstacle), obstacle)).collect();
        let (carried, back) = (from.drawn * from.frame, from.drawn.inverse());
        let picture = |(vertex, world): (usize, DVec3)| {
            if self.cloth.pin_target(vertex as u32).is_some() {
                return from.frame.transform_point3(world);
            }
            let mut place = carried.transform_point3(world);
            if !anchored {
                place += ridden(&obstacles, world);
            }
            for obstacle in &obstacles {
                place += obstacle.keeps_out(world, place);
            }
            back.transform_point3(place)
        };
        simulated.enumerate().map(picture).collect()
    }
}

/// An obstacle with its shape.
struct Around<'a> {
    shape: &'a SharedShape,
    /// Box around the shape in its own frame, m.
    low: DVec3,
    high: DVec3,
    simulated: Pose,
    drawn: Pose,
}

impl<'a> Around<'a> {
    fn new(shape: &'a SharedShape, obstacle: &Obstacle) -> Self {
        let aabb = shape.compute_local_aabb();
        let (low, high) = (aabb.mins.as_dvec3(), aabb.maxs.as_dvec3());
        Self { shape, low, high, simulated: obstacle.simulated, drawn: obstacle.drawn }
    }

    /// The distance to a point in the frame of the shape and the normal, if the point is nearer than `within`.
    fn distance(&self, point: DVec3, within: f64) -> Option<(f64, DVec3)> {
        let to_box = (self.low - point).max(point - self.high).max(DVec3::ZERO);
        if to_box.length_squared() >= within * within {
            return None;
        }
        Some(distance(self.shape, point, within)).filter(|&(distance, _)| distance < within)
    }

    /// How the picture of a point must be moved so that it is not led into the collider: simulated at `world`, it is drawn at `picture`.
    fn keeps_out(&self, world: DVec3, picture: DVec3) -> DVec3 {
        let local = self.simulated.local(world);
        let way = self.drawn.local(picture) - local;
        let within = WITHIN * way.length();
        if within < STILL {
            return DVec3::ZERO;
        }
        let Some((distance, normal)) = self.distance(local, within) else { return DVec3::ZERO };
        let inward = (-way.dot(normal)).max(0.0);
        self.drawn.rotation * (normal * (inward * (1.0 - rise(distance / within))))
    }
}

/// How a point that nothing holds goes along with what it is near.
fn ridden(obstacles: &[Around], world: DVec3) -> DVec3 {
    let (mut way, mut weight) = (DVec3::ZERO, 0.0);
    for obstacle in obstacles {
        let local = obstacle.simulated.local(world);
        let along = obstacle.drawn.place(local) - world;
        let within = WITHIN * along.length();
        if let Some((distance, _)) = obstacle.distance(local, within) {
            let share = 1.0 - rise(distance / within);
            way += share * along;
            weight += share;
        }
    }
    way / f64::max(weight, 1.0)
}

/// 0 below 0, 1 from 1 on, smooth.
fn rise(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// World to mesh between two transforms. The matrices are interpolated as the positions are, entry by entry; where that has
/// no inverse (half a turn in one step), the later transform and positions are shown.
fn interpolated_frame(before: DAffine3, now: DAffine3, alpha: f32) -> (f32, DAffine3) {
    let t = f64::from(alpha);
    let mixed = DAffine3 {
        matrix3: before.matrix3 * (1.0 - t) + now.matrix3 * t,
        translation: before.translation.lerp(now.translation, t),
    };
    // Relative to the later one, so that mirrored transforms are no exception.
    if mixed.matrix3.determinant() / now.matrix3.determinant() > FOLDED {
        (alpha, mixed.inverse())
    } else {
        (1.0, now.inverse())
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::DQuat;

    use super::*;

    #[test]
    fn a_picture_comes_no_nearer_than_it_was_led_past() {
        let ball = SharedShape::ball(1.0);
        let simulated = Pose::at(DVec3::ZERO);
        for way in [0.01, 0.1, 0.3] {
            let drawn = Pose::at(DVec3::X * -way);
            let around = Around::new(&ball, &Obstacle { index: 0, simulated, drawn });
            for height in [0.0, 1e-3, 0.02, 0.1, 0.5, 2.0] {
                let world = DVec3::X * -(1.0 + height);
                let picture = world + around.keeps_out(world, world);
                let left = drawn.local(picture).length() - 1.0;
                assert!(left >= 0.6 * height - 1e-9, "{way} {height}: {left}");
                let away = DVec3::X * (1.0 + height);
                assert_eq!(around.keeps_out(away, away), DVec3::ZERO, "it goes away from there");
            }
        }
    }

    #[test]
    fn what_lies_on_a_lift_is_drawn_on_it() {
        let floor = SharedShape::cuboid(1.0, 0.1, 1.0);
        let obstacle = Obstacle { index: 0, simulated: Pose::at(DVec3::ZERO), drawn: Pose::at(DVec3::Y * 0.3) };
        let around = [Around::new(&floor, &obstacle)];
        let world = DVec3::new(0.2, 0.1, 0.3);
        assert!(ridden(&around, world).distance(DVec3::Y * 0.3) < 1e-9);
        assert_eq!(ridden(&around, world + DVec3::Y * 2.0), DVec3::ZERO);
    }

    #[test]
    fn held_points_keep_their_place_between_two_transforms() {
        let before =
            DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), DQuat::from_rotation_x(0.3), DVec3::X);
        let turn = DQuat::from_rotation_z(2.0);
        let now = DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), turn, DVec3::new(5.0, 1.0, 0.0));
        let local = DVec3::new(0.3, 0.4, 0.5);
        let (alpha, frame) = interpolated_frame(before, now, 0.25);
        let world = before.transform_point3(local).lerp(now.transform_point3(local), 0.25);
        assert_eq!(alpha, 0.25);
        assert!(frame.transform_point3(world).abs_diff_eq(local, 1e-12));
    }

    #[test]
    fn mirrored_transforms_are_interpolated_too() {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let now = DAffine3::from_translation(DVec3::X) * mirror;
        let (alpha, frame) = interpolated_frame(mirror, now, 0.5);
        assert_eq!(alpha, 0.5);
        assert!(frame.transform_point3(DVec3::new(0.5, 0.0, 0.0)).length() < 1e-12);
    }

    #[test]
    fn half_a_turn_shows_the_later_transform() {
        let now = DAffine3::from_rotation_y(core::f64::consts::PI);
        let (alpha, frame) = interpolated_frame(DAffine3::IDENTITY, now, 0.5);
        assert_eq!(alpha, 1.0);
        assert!((frame * now).abs_diff_eq(DAffine3::IDENTITY, 1e-12));
    }
}
