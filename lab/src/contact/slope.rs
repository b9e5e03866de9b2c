//! A small sheet on a slope: it stays below the angle of friction, and slides with a = g (sin α − μ cos α) above it.

use bevy::math::{DQuat, DVec3};
use bevy_cloth::physics::{Cloth, ContactSettings, Fabric, Pose, SolverSettings};

use super::body::Body;
use super::fit::acceleration;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::trial::{ROUNDING, Trial};
use crate::validate::strip::{Strip, place};

/// Coefficients of friction.
pub const FRICTIONS: [f64; 4] = [0.1, 0.3, 0.5, 1.0];
/// Steps a second.
pub const RATES: [f64; 3] = [30.0, 60.0, 240.0];
/// m/s².
const GRAVITY: f64 = 9.81;
/// Of a sheet that stays: its tan α in μ.
const BELOW: f64 = 0.95;
/// Of a sheet that slides: its tan α beyond μ.
const BEYOND: f64 = 0.2;
/// How long it is watched, s.
const SECONDS: f64 = 2.0;
/// How long it may take to find its way, s.
const ONSET: f64 = 0.5;
/// Room below the sheet at first, beyond the thickness, m.
const GAP: f64 = 1e-5;

/// Stiff, in a vacuum: nothing but friction holds it.
pub fn board() -> Fabric {
    Fabric { air_drag: 0.0, ..Fabric::isotropic(0.15, 1000.0, 0.3, 1e-3) }
}

/// A sheet of 0.2 m with its middle above the origin, so much above it that it just does not feel it.
pub fn small_sheet(friction: f64) -> Cloth {
    let mut cloth = Strip::new(0.2, 0.2, 7, 7).cloth(board(), SolverSettings::default());
    cloth.set_contact_settings(ContactSettings { friction, ..Default::default() }).expect("settings");
    let height = cloth.contact_settings().thickness + GAP;
    place(&mut cloth, |x| x + DVec3::new(-0.1, height, -0.1));
    cloth
}

/// Whose upper side is y = 0, and where that is.
#[derive(Clone, Copy, Debug)]
pub enum Floor {
    /// All below it.
    HalfSpace,
    /// A cuboid of 40 m.
    Cuboid,
}

impl Floor {
    /// Both.
    pub const ALL: [Self; 2] = [Self::HalfSpace, Self::Cuboid];

    /// The floor, and the offset of its origin from its upper side, m.
    pub fn solid(self) -> (Solid, DVec3) {
        match self {
            Self::HalfSpace => (Solid::HalfSpace, DVec3::ZERO),
            Self::Cuboid => (Solid::Cuboid { half: DVec3::new(20.0, 0.5, 20.0) }, DVec3::NEG_Y * 0.5),
        }
    }

    /// What tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::HalfSpace => "half-space",
            Self::Cuboid => "cuboid",
        }
    }
}

/// The way of the centre downhill, m, after every step.
fn way(floor: Floor, friction: f64, tangent: f64, rate: f64) -> (Trial, Vec<f64>) {
    let turn = DQuat::from_rotation_z(-tangent.atan());
    let (solid, offset) = floor.solid();
    let mut cloth = small_sheet(friction);
    let tilted: Vec<_> = cloth.positions().iter().map(|&x| turn * x).collect();
    cloth.set_state(&tilted, &vec![DVec3::ZERO; tilted.len()]);
    let body = Body::fixed(solid, friction, Pose { translation: turn * offset, rotation: turn });
    let mut trial = Trial::new(cloth, vec![body], 1.0 / rate);
    let (start, downhill) = (trial.centre(), turn * DVec3::X);
    let mut way = vec![0.0];
    trial.run_with(SECONDS, |trial| way.push((trial.centre() - start).dot(downhill)));
    (trial, way)
}

/// How far a sheet moves that should stay, and how fast one becomes that should slide.
pub fn rows(floor: Floor, friction: f64, rate: f64) -> Vec<Row> {
    let scene = |tangent: f64| format!("slope {} μ {friction} tan α {tangent:.3} {rate} Hz", floor.name());
    let (below, beyond) = (BELOW * friction, friction + BEYOND);
    let (still, moves) = way(floor, friction, below, rate);
    let farthest = moves.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let (sliding, moves) = way(floor, friction, beyond, rate);
    let (sin, cos) = beyond.atan().sin_cos();
    let expected = GRAVITY * (sin - friction * cos);
    let measured = acceleration(&moves[(ONSET * rate) as usize..], 1.0 / rate);
    let depth = 1e3 * still.seen().vertex_depth.max(sliding.seen().vertex_depth);
    vec![
        Row::new(scene(below), "moved/mm", 1e3 * farthest, Wanted::AtMost(1.0)),
        Row::new(scene(beyond), "a/(m/s²)", measured, Wanted::near(expected, 0.02)),
        Row::new(scene(beyond), "vertex depth of both/mm", depth, Wanted::AtMost(ROUNDING)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sheet_begins_just_above_the_floor() {
        for floor in Floor::ALL {
            let (trial, _) = way(floor, 0.5, 0.3, 30.0);
            let body = &trial.bodies[0];
            for &x in small_sheet(0.5).positions() {
                let tilted = DQuat::from_rotation_z(-0.3_f64.atan()) * x;
                assert!((body.solid.distance(body.pose(0.0).local(tilted)) - 3e-3 - GAP).abs() < 1e-9, "{floor:?}");
            }
        }
    }
}
