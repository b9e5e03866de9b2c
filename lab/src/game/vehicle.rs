//! A flag on a vehicle: however fast that is, the flag streams in its wind, and is not carried along as in a room without any.

use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use bevy_cloth::plugin::{ClothMaterial, ClothPins};

use super::frames::Frames;
use super::stage::{Moved, Stage, When, path, sheet, worse};
use crate::row::{Row, Wanted};

/// Once it goes, s, and how long that takes.
const START: f64 = 0.5;
const SPURT: f64 = 1.0;
/// How long the flag may take to stream, and is watched from then on, s.
const SETTLING: f64 = 1.0;
const SECONDS: f64 = 2.0;
/// How fast, m/s.
const SPEEDS: [f64; 4] = [30.0, 60.0, 110.0, 130.0];
/// The vehicle sways: how far, rad, and how often a second. A flag without flutter would hang still in an even wind.
const SWAY: f64 = 0.2;
const SWAYS: f64 = 1.0;
/// Sides of the flag, m.
const LENGTH: f32 = 0.9;
const HEIGHT: f32 = 0.6;
/// Of the flag, 1/s. At 30 m/s it weighs six times as much as gravity: the flag hangs by 9° only.
const AIR_DRAG: f64 = 2.0;
/// How far it may hang below the level at the most, °. What is carried along hangs from its pole.
const DROOP: f64 = 25.0;

/// How the flag was seen, on average.
struct Outcome {
    /// Of its middle below the middle of its pole, °.
    droop: f64,
    /// Of the vertex that moves the most from picture to picture, in the frame of the vehicle, m.
    motion: f64,
    /// The most.
    stretch: f64,
}

fn outcome(hz: f64, speed: f64, when: When) -> Outcome {
    let mut stage = Stage::new(hz, Frames::Even(hz), 0.0, 0);
    let drive = path(move |time, transform| {
        let going = (time - START).max(0.0);
        let ahead = if going < SPURT { 0.5 * speed * going * going / SPURT } else { speed * (going - 0.5 * SPURT) };
        transform.translation.z = -ahead as f32;
        let sway = SWAY * (core::f64::consts::TAU * SWAYS * going).sin();
        transform.rotation = Quat::from_rotation_y(sway as f32);
    });
    let vehicle = stage.spawn((Transform::IDENTITY, Moved::by(when, &drive)), None);
    // The pole edge at the vehicle, the rest behind it.
    let behind = Quat::from_rotation_y(-core::f32::consts::FRAC_PI_2 + 0.1);
    let flag = stage.spawn_cloth(
        sheet(LENGTH, HEIGHT, 12).translated_by(Vec3::X * 0.5 * LENGTH),
        (
            ClothPins::where_position(|p| p.x < 1e-4),
            ClothMaterial(Fabric { air_drag: AIR_DRAG as f32, ..ClothMaterial::default().0 }),
            Transform::from_xyz(0.0, 2.0, 0.0).with_rotation(behind),
        ),
        Some(vehicle),
    );
    stage.run(START + SPURT + SETTLING);
    stage.take_seen();
    let mut last = stage.drawn(flag).to_vec();
    let (mut motion, mut droop, mut pictures) = (0.0, 0.0, 0.0);
    stage.run_and(SECONDS, |stage| {
        let drawn = stage.drawn(flag);
        let way = |(a, b): (&[f32; 3], &[f32; 3])| f64::from(Vec3::from(*a).distance(Vec3::from(*b)));
        motion += last.iter().zip(drawn).map(way).fold(0.0, worse);
        droop += droop_of(drawn);
        pictures += 1.0;
        last = drawn.to_vec();
    });
    Outcome { droop: droop / pictures, motion: motion / pictures, stretch: stage.take_seen().stretch }
}

/// How far the middle of a flag is below the level, seen from the middle of its pole, °.
fn droop_of(drawn: &[[f32; 3]]) -> f64 {
    let centre = drawn.iter().map(|&p| Vec3::from(p)).sum::<Vec3>() / drawn.len() as f32;
    f64::from((-0.5 * HEIGHT - centre.y).atan2(centre.xz().length()).to_degrees())
}

/// At several speeds and rates.
pub fn rows(quick: bool) -> Vec<Row> {
    let (rates, schedules) = if quick {
        (&[60.0][..], &[When::FixedUpdate][..])
    } else {
        (&[60.0, 30.0, 20.0][..], &[When::FixedUpdate, When::Update][..])
    };
    let mut rows = Vec::new();
    for &hz in rates {
        for speed in SPEEDS {
            for &when in schedules {
                let Outcome { droop, motion, stretch } = outcome(hz, speed, when);
                let scene = format!("flag at {speed} m/s, {hz} Hz, moved in {}", when.name());
                rows.push(Row::new(&scene, "hangs below the level/°", droop, Wanted::AtMost(DROOP)));
                rows.push(Row::new(&scene, "moves/(mm a tick)", 1e3 * motion, Wanted::Known));
                rows.push(Row::new(&scene, "stretch/%", 100.0 * stretch, Wanted::Known));
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flag_that_stands_out_is_level_and_one_that_hangs_is_not() {
        let out = [[0.0, 0.0, 0.0], [0.0, -HEIGHT, 0.0], [LENGTH, 0.0, 0.0], [LENGTH, -HEIGHT, 0.0]];
        assert!(droop_of(&out).abs() < 1e-3);
        let hung = out.map(|[x, y, z]| [0.1 * x, y - x, z]);
        assert!(droop_of(&hung) > 80.0);
    }
}
