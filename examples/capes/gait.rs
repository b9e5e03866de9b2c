//! How a figure walks: angles of its joints, as functions of the way it has gone.

use bevy::prelude::*;
use std::f32::consts::TAU;

/// In metres per second, when it has set off.
pub const SPEED: f32 = 1.5;
/// How long it takes to set off, in seconds.
const SET_OFF: f32 = 1.0;
/// Length of two steps, in metres.
const STRIDE: f32 = 1.45;

/// How long two steps take when it has set off, in seconds.
#[allow(dead_code, reason = "of what includes this file, only the runner repeats two steps")]
pub const PERIOD: f32 = STRIDE / SPEED;
/// When all steps are alike, in seconds.
#[allow(dead_code, reason = "likewise")]
pub const EVEN: f32 = SET_OFF;

/// A moment of the walk.
#[derive(Clone, Copy)]
pub struct Gait {
    /// Metres gone.
    pub way: f32,
    /// Of a step to the left and one to the right, in radians.
    phase: f32,
    /// How far the limbs swing, from 0 at rest to 1.
    swing: f32,
}

/// The side of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    Left,
    Right,
}

/// What turns.
#[derive(Component, Clone, Copy, Debug)]
pub enum Joint {
    Hip(Side),
    Knee(Side),
    Shoulder(Side),
    Elbow(Side),
}

impl Gait {
    /// So many seconds after it was standing; one figure may be ahead of another by a share of the stride.
    pub fn at(seconds: f32, ahead: f32) -> Self {
        let setting_off = (seconds / SET_OFF).clamp(0.0, 1.0);
        // The speed grows evenly.
        let way = SPEED * (0.5 * SET_OFF * setting_off * setting_off + (seconds - SET_OFF).max(0.0));
        Self { way, phase: TAU * (way / STRIDE + ahead), swing: setting_off }
    }

    /// Of the hips above their mean height, in metres: highest when one leg passes the other.
    pub fn rise(&self) -> f32 {
        0.02 * self.swing * (2.0 * self.phase).cos()
    }

    /// Turns a limb that hangs down, forwards if positive, about the axis from left to right; in radians.
    pub fn bend(&self, joint: Joint) -> f32 {
        let phase = |side| if side == Side::Left { self.phase } else { self.phase + 0.5 * TAU };
        let angle = match joint {
            Joint::Hip(side) => 0.48 * phase(side).sin(),
            // Bent most while the leg swings forwards.
            Joint::Knee(side) => -0.12 - 0.8 * phase(side).cos().max(0.0),
            Joint::Shoulder(side) => -0.42 * phase(side).sin(),
            Joint::Elbow(side) => 0.35 - 0.2 * phase(side).sin(),
        };
        self.swing * angle
    }
}
