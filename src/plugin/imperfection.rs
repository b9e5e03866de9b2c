//! The breath of air that a plane cloth begins with.
//!
//! A cloth that is plane to the last bit, at rest, with gravity in its plane, never leaves that plane in arithmetic: a flag held at
//! its pole stands out like a board, as nothing in its equations says to which side it should fold. Real cloth is not plane, and
//! air is not still. So such a cloth starts with a little speed across its plane, in waves: the same on every mesh and in every run.

use core::f64::consts::TAU;

use bevy::math::DVec3;

use super::geometry::extent;
use super::state::ClothState;
use crate::physics::Cloth;

/// How far it would take a hanging cloth out of its plane, relative to its size. A flag of cotton of 1 m, of 16 × 16 cells, has fallen by
/// 0.30 m after 1 s (with three tenths of this, by 0.18 m; as far as it will ever hang, 0.33 m, after 2 s); a sheet that
/// hangs from its upper edge is never farther off its plane than 0.31 mm.
const DEPTH: f64 = 1e-3;
/// Waves across the cloth: with one, that sheet is off by 0.87 mm, and the flag no sooner down.
const WAVES: f64 = 4.0;
/// Off an upright plane by less than this, relative to the size, it is plane. What is farther off falls as soon by itself.
const PLANE: f64 = 1e-4;

impl ClothState {
    /// Where a held cloth that has not moved yet would never leave its plane, starts it out of it. One that is not held falls as it
    /// is: nothing presses it together.
    pub(super) fn breathe(&mut self) {
        let held = self.is_anchored();
        let cloth = &mut self.cloth;
        if held
            && !self.stepped
            && cloth.velocities().iter().all(|v| *v == DVec3::ZERO)
            && let Some(velocities) = breath(cloth)
        {
            let positions = cloth.positions().to_vec();
            cloth.set_state(&positions, &velocities);
        }
    }
}

/// Velocities across the plane of a cloth, m/s; `None` if it is in no plane with gravity.
fn breath(cloth: &Cloth) -> Option<Vec<DVec3>> {
    let positions = cloth.positions();
    let down = cloth.gravity().try_normalize()?;
    let [low, high] = extent(positions.iter().copied());
    let (centre, size) = (0.5 * (low + high), low.distance(high));
    // Level in the plane, and across it.
    let level = |p: DVec3| (p - centre).reject_from_normalized(down);
    let farthest =
        positions.iter().copied().map(level).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let along = farthest.try_normalize()?;
    // A sign that does not depend on which end is the farthest.
    let along = if along.dot(DVec3::new(1.0, 0.1, 0.01)) < 0.0 { -along } else { along };
    let across = down.cross(along);
    let flat = positions.iter().all(|p| (*p - centre).dot(across).abs() <= PLANE * size);
    let speed = DEPTH * (cloth.gravity().length() * size).sqrt();
    // Along both diagonals, as either may be the one that is pressed together; neither even nor odd about any line.
    let wave = |p: DVec3| {
        let [level, deep] = [along, down].map(|axis| TAU * WAVES * (p - centre).dot(axis) / size);
        0.5 * ((level + deep + 0.5).sin() + (1.1 * (level - deep) + 0.5).sin())
    };
    flat.then(|| positions.iter().map(|&p| across * speed * wave(p)).collect())
}
