//! A cape on a character that runs in a circle: capsules, all of them moving fast, among swinging limbs.

use core::f64::consts::TAU;

use bevy::math::{DQuat, DVec3};
use bevy_cloth::physics::{Cloth, Pose, SolverSettings};

use super::body::Body;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::trial::Trial;
use crate::scenes::{DT, fabric};
use crate::validate::strip::{Strip, place, vertices};

/// m/s, once it runs, and how long it takes to, s.
const SPEED: f64 = 6.0;
const START: f64 = 0.5;
/// Of its circle, m.
const CIRCLE: f64 = 4.0;
/// Swings of its limbs a second, and how far they go, radians.
const STRIDES: f64 = 1.6;
const SWING: f64 = 0.7;
/// Height of its shoulders, m, and how far behind its axis the cape hangs.
const SHOULDERS: f64 = 1.45;
const BEHIND: f64 = 0.22;
/// Width and length of the cape, m, and its cells along them.
const CAPE: [f64; 2] = [0.6, 0.9];
const CELLS: [u32; 2] = [18, 27];

/// Where it stands and looks, the latter along its own z.
fn stance(time: f64) -> Pose {
    let run = if time < START { 0.5 * SPEED * time * time / START } else { SPEED * (time - 0.5 * START) };
    let turn = DQuat::from_rotation_y(run / CIRCLE);
    let bob = 0.04 * (1.0 - (TAU * 2.0 * STRIDES * time).cos());
    Pose { translation: turn * DVec3::NEG_X * CIRCLE + DVec3::Y * bob, rotation: turn }
}

/// A part of the body that hangs from a joint and swings by an angle about the joint, in the frame of the character.
fn limb(joint: DVec3, length: f64, radius: f64, swing: f64) -> Body {
    let half_length = 0.5 * length;
    Body::moving(Solid::Capsule { half_length, radius }, 0.4, move |time| {
        let body = stance(time);
        let angle = swing * (TAU * STRIDES * time).sin() * (time / START).min(1.0);
        // The capsule's own axis is z: down, then swung.
        let local = DQuat::from_rotation_x(angle) * DQuat::from_rotation_x(core::f64::consts::FRAC_PI_2);
        Pose { translation: body.place(joint + local * DVec3::Z * half_length), rotation: body.rotation * local }
    })
}

fn bodies() -> Vec<Body> {
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    vec![
        limb(at(0.0, 1.35), 0.35, 0.16, 0.0),
        limb(at(0.11, 0.9), 0.8, 0.08, SWING),
        limb(at(-0.11, 0.9), 0.8, 0.08, -SWING),
        limb(at(0.27, 1.38), 0.6, 0.05, -SWING),
        limb(at(-0.27, 1.38), 0.6, 0.05, SWING),
    ]
}

/// Where a point of the flat cape hangs at first, in the frame of the character.
fn hung(x: DVec3) -> DVec3 {
    DVec3::new(x.z - 0.5 * CAPE[0], SHOULDERS - x.x, -BEHIND)
}

fn cape() -> Cloth {
    let strip = Strip::new(CAPE[1], CAPE[0], CELLS[1], CELLS[0]);
    let mut cloth = strip.cloth(fabric(), SolverSettings::default());
    place(&mut cloth, |x| stance(0.0).place(hung(x)));
    cloth
}

/// How the cape fares.
pub fn rows(seconds: f64) -> Vec<Row> {
    let cape = cape();
    let shoulders = vertices(&cape, |x| x.x == 0.0);
    let mut trial = Trial::new(cape, bodies(), DT);
    let mut stretch = 0.0_f64;
    while trial.time < seconds - 0.5 * DT {
        let stance = stance(trial.time + DT);
        for &vertex in &shoulders {
            let place = hung(trial.cloth.shape().positions[vertex as usize]);
            trial.cloth.pin(vertex, stance.place(place));
        }
        trial.step();
        stretch = stretch.max(trial.cloth.stretch().rms);
    }
    let mut rows = trial.rows("cape on a runner");
    rows.push(Row::new("cape on a runner", "RMS stretch/%, the most", 100.0 * stretch, Wanted::AtMost(10.0)));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cape_begins_outside_and_the_character_runs() {
        let (cape, bodies) = (cape(), bodies());
        let distance =
            |x: DVec3| bodies.iter().map(|body| body.solid.distance(body.pose(0.0).local(x))).fold(1.0, f64::min);
        let nearest = cape.positions().iter().map(|&x| distance(x)).fold(1.0, f64::min);
        assert!(nearest > 0.02, "{nearest}");
        let speed = stance(2.0).translation.distance(stance(2.01).translation) / 0.01;
        assert!((speed - SPEED).abs() < 0.5, "{speed}");
        // It looks where it goes.
        let ahead = stance(2.01).translation - stance(2.0).translation;
        assert!((stance(2.0).rotation * DVec3::Z).dot(ahead.normalize()) > 0.9);
        // The cape is behind it.
        assert!(stance(0.0).local(cape.positions()[0]).z < 0.0);
    }

    #[test]
    fn held_shoulders_stay_clear_of_swinging_arms() {
        let bodies = bodies();
        for step in 0..300 {
            let time = f64::from(step) * DT;
            for x in [0.0, 0.15, 0.3, 0.45, 0.6] {
                let place = stance(time).place(hung(DVec3::new(0.0, 0.0, x)));
                let nearest =
                    bodies.iter().map(|body| body.solid.distance(body.pose(time).local(place))).fold(1.0, f64::min);
                assert!(nearest > 0.01, "{nearest} at {time} s");
            }
        }
    }
}
