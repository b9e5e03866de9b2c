//! How held vertices come to where they are held: at once where they are there already, else at a speed that does not tear the cloth.

use std::collections::BTreeMap;

use bevy::math::{DAffine3, DVec3, Vec3};

use super::leaps;
use super::way::Way;
use crate::plugin::ClothPinTargets;

/// Speed and acceleration at which a vertex glides to where it is held, m/s and m/s². A corner of a hanging sheet of cotton that is
/// grabbed 1 m away stretches it by less than 10 % so.
const SPEED: f64 = 1.8;
const ACCELERATION: f64 = 10.0;
/// A distance that is none, m.
const THERE: f64 = 1e-6;

/// Held vertices that are not where they are held yet.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::plugin) struct Glides(BTreeMap<u32, Glide>);

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct Glide {
    /// From where it is held to where it is, in the space of the entity.
    offset: DVec3,
    /// m/s.
    speed: f64,
}

impl Glides {
    /// A vertex that has come to be held somewhere else by an offset (in the space of the entity) must glide there.
    pub fn begin(&mut self, vertex: u32, offset: DVec3) {
        self.0.entry(vertex).or_insert(Glide { offset: DVec3::ZERO, speed: 0.0 }).offset += offset;
    }

    /// Forgets vertices that are not held any more, and all of them if the cloth was put to rest.
    pub fn retain(&mut self, held: impl Fn(u32) -> bool) {
        self.0.retain(|&vertex, _| held(vertex));
    }

    /// Moves all by a tick of `dt`, under the transform of the entity.
    pub fn advance(&mut self, anchor: DAffine3, dt: f64) {
        self.0.retain(|_, glide| {
            let distance = (anchor.matrix3 * glide.offset).length();
            // Fast enough to stop where it is held.
            let stopping = (2.0 * ACCELERATION * distance).sqrt();
            glide.speed = SPEED.min(glide.speed + ACCELERATION * dt).min(stopping);
            let left = distance - glide.speed * dt;
            glide.offset *= (left / distance).max(0.0);
            left > THERE && distance.is_finite()
        });
    }

    /// From where a vertex is held to where it must be in this tick, in the space of the entity.
    pub fn offset(&self, vertex: u32) -> DVec3 {
        self.0.get(&vertex).map_or(DVec3::ZERO, |glide| glide.offset)
    }
}

/// The ways of [`ClothPinTargets`]: a game moves them once a frame, as it moves transforms.
#[derive(Default)]
pub(in crate::plugin) struct TargetWays(BTreeMap<u32, Way<Vec3>>);

impl TargetWays {
    /// Takes note of what the frame left that ended at `time`.
    pub fn end_frame(&mut self, targets: &ClothPinTargets, time: f64, oldest: f64) {
        self.0.retain(|vertex, _| targets.contains_key(vertex));
        for (vertex, way) in &mut self.0 {
            let value = targets[vertex];
            if value.is_finite() {
                way.end_frame(time, value, oldest, leaps);
            }
        }
    }

    /// Takes note of what the fixed loop left.
    pub fn end_ticks(&mut self, targets: &ClothPinTargets, time: f64) {
        for (vertex, way) in &mut self.0 {
            if let Some(&value) = targets.get(vertex).filter(|value| value.is_finite()) {
                way.tick(time, value, true);
            }
        }
    }

    /// Where a vertex is held in this tick. `times` are those of [`Motions::times`](super::Motions::times).
    pub fn at(&mut self, vertex: u32, value: Vec3, times: Option<(f64, f64)>) -> DVec3 {
        let Some((time, end)) = times else { return value.as_dvec3() };
        let way = self.0.entry(vertex).or_insert_with(|| Way::new(end, value));
        way.tick(end, value, false);
        way.at(time).as_dvec3()
    }

    /// Forgets what is not held any more.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_glide_is_smooth_and_ends_exactly_there() {
        let anchor = DAffine3::from_scale(DVec3::splat(2.0));
        let mut glides = Glides::default();
        glides.begin(7, DVec3::X * 0.5);
        let (dt, mut before, mut speed) = (1.0 / 60.0, 1.0, 0.0);
        let mut ticks = 0;
        while glides.offset(7) != DVec3::ZERO {
            glides.advance(anchor, dt);
            let left = (anchor.matrix3 * glides.offset(7)).length();
            let now = (before - left) / dt;
            assert!(now <= SPEED + 1e-9 && now - speed <= ACCELERATION * dt + 1e-9, "{now}");
            (before, speed, ticks) = (left, now, ticks + 1);
        }
        assert!((35..80).contains(&ticks), "{ticks}");
        assert_eq!(glides.offset(3), DVec3::ZERO);
    }
}
