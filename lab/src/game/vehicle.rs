//! A flag on a vehicle: however fast that is, the flag moves in its wind, and is not carried along like a board.

use bevy::prelude::*;
use bevy_cloth::plugin::{ClothMaterial, ClothPins};

use super::frames::Frames;
use super::stage::{Moved, Stage, When, path, sheet, worse};
use crate::row::{Row, Wanted};

/// Once it goes, s, and how long that takes.
const START: f64 = 0.5;
const SPURT: f64 = 1.0;
/// How long it is watched from then on, s.
const SECONDS: f64 = 2.0;
/// How fast, m/s.
const SPEEDS: [f64; 4] = [30.0, 60.0, 110.0, 130.0];
/// The vehicle sways: how far, rad, and how often a second. A flag without flutter would hang still in an even wind.
const SWAY: f64 = 0.2;
const SWAYS: f64 = 1.0;
/// Least motion of the fastest vertex in the frame of the vehicle, mm a second: what is carried along has none.
const MOTION: f64 = 60.0;

/// Mean motion of the vertex that moves the most from picture to picture, in the frame of the vehicle, m, and the stretch.
fn motion(hz: f64, speed: f64, when: When) -> (f64, f64) {
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
        sheet(0.9, 0.6, 12).translated_by(Vec3::X * 0.45),
        (
            ClothPins::where_position(|p| p.x < 1e-4),
            ClothMaterial(bevy_cloth::physics::Fabric { air_drag: 2.0, ..ClothMaterial::default().0 }),
            Transform::from_xyz(0.0, 2.0, 0.0).with_rotation(behind),
        ),
        Some(vehicle),
    );
    stage.run(START + SPURT + 0.2);
    stage.take_seen();
    let mut last = stage.drawn(flag).to_vec();
    let (mut sum, mut pictures) = (0.0, 0.0);
    stage.run_and(SECONDS, |stage| {
        let drawn = stage.drawn(flag);
        let way = |(a, b): (&[f32; 3], &[f32; 3])| f64::from(Vec3::from(*a).distance(Vec3::from(*b)));
        sum += last.iter().zip(drawn).map(way).fold(0.0, worse);
        pictures += 1.0;
        last = drawn.to_vec();
    });
    (sum / pictures, stage.take_seen().stretch)
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
                let (motion, stretch) = motion(hz, speed, when);
                let scene = format!("flag at {speed} m/s, {hz} Hz, moved in {}", when.name());
                rows.push(Row::new(&scene, "moves/(mm a tick)", 1e3 * motion, Wanted::AtLeast(MOTION / hz)));
                rows.push(Row::new(&scene, "stretch/%", 100.0 * stretch, Wanted::Known));
            }
        }
    }
    rows
}
