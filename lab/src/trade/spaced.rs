//! A cloth that takes a step in one of several frames, and is shown in between on a straight line.

use bevy::math::DVec3;
use bevy_cloth::physics::Cloth;

use super::body::Body;
use crate::scenes::DT;

/// See [the module](self).
pub struct Spaced {
    cloth: Cloth,
    /// Frames from step to step, and those since the last.
    interval: u32,
    since: u32,
    /// Before the last step, m and m/s.
    before: [Vec<DVec3>; 2],
    /// m and m/s.
    shown: [Vec<DVec3>; 2],
}

impl Spaced {
    /// Steps `cloth` once in so many frames.
    pub fn new(cloth: Cloth, interval: u32) -> Self {
        let state = [cloth.positions().to_vec(), cloth.velocities().to_vec()];
        Self { cloth, interval, since: 0, before: state.clone(), shown: state }
    }
}

impl Body for Spaced {
    fn hold(&mut self, vertex: u32, target: DVec3) {
        self.cloth.pin(vertex, target);
    }

    fn frames_ahead(&self) -> Option<u32> {
        (self.since == 0).then_some(self.interval)
    }

    fn frame(&mut self) {
        if self.since == 0 {
            self.before = [self.cloth.positions().to_vec(), self.cloth.velocities().to_vec()];
            self.cloth.step(f64::from(self.interval) * DT);
        }
        self.since += 1;
        let share = f64::from(self.since) / f64::from(self.interval);
        let after = [self.cloth.positions(), self.cloth.velocities()];
        for ((shown, before), after) in self.shown.iter_mut().zip(&self.before).zip(after) {
            for ((shown, before), &after) in shown.iter_mut().zip(before).zip(after) {
                *shown = before.lerp(after, share);
            }
        }
        self.since %= self.interval;
    }

    fn place(&mut self, positions: &[DVec3]) {
        self.cloth.place(positions);
        self.since = 0;
    }

    fn positions(&self) -> &[DVec3] {
        &self.shown[0]
    }

    fn velocities(&self) -> &[DVec3] {
        &self.shown[1]
    }
}
