//! Scale that is animated: breathing, facing about by a mirror, popping in. What each update takes, beside a cloth that stands.

use std::time::Instant;

use bevy::prelude::*;
use bevy_cloth::plugin::ClothError;

use super::frames::Frames;
use super::jump::{SPEED, STRETCH};
use super::stage::{Moved, Path, Stage, When, path, sheet, top_edge, worse};
use crate::row::{Row, Wanted};

/// Updates that are timed.
const UPDATES: usize = 180;
/// Times what a cloth of the same size costs that stands still.
const FACTOR: f64 = 1.5;
/// Popping in: from when on, and for how long, s.
const POP: f64 = 0.5;
const POPPING: f64 = 0.33;

/// What is done to the scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scaled {
    Still,
    Breathing,
    Mirrored,
}

impl Scaled {
    fn path(self) -> Path {
        path(move |time, transform| {
            transform.scale = match self {
                Self::Still => Vec3::ONE,
                Self::Breathing => Vec3::splat(1.0 + 0.1 * (core::f64::consts::TAU * time).sin() as f32),
                // Half a second each way.
                Self::Mirrored => Vec3::new(if ((2.0 * time) as u64).is_multiple_of(2) { 1.0 } else { -1.0 }, 1.0, 1.0),
            };
        })
    }

    /// Median time of an update, and the longest, ms.
    fn times(self, cells: u32) -> [f64; 2] {
        let mut stage = Stage::new(64.0, Frames::Even(64.0), 0.0, 0);
        let place = Transform::from_xyz(0.0, 2.0, 0.0);
        stage.spawn_cloth(sheet(1.0, 1.0, cells), (top_edge(), place, Moved::by(When::Update, &self.path())), None);
        stage.run(1.0);
        let mut times: Vec<_> = (0..UPDATES)
            .map(|_| {
                let start = Instant::now();
                stage.frame();
                1e3 * start.elapsed().as_secs_f64()
            })
            .collect();
        let longest = times.iter().copied().fold(0.0, f64::max);
        times.sort_by(f64::total_cmp);
        [times[times.len() / 2], longest]
    }
}

/// A cape that pops in: from nothing to its size.
fn pop_in() -> Vec<Row> {
    let mut stage = Stage::new(64.0, Frames::Even(60.0), 0.0, 0);
    let pop = path(|time, transform| {
        transform.scale = Vec3::splat(((time - POP) / POPPING).clamp(0.0, 1.0) as f32);
    });
    let place = Transform::from_xyz(0.0, 2.0, 0.0).with_scale(Vec3::ZERO);
    let cape = stage.spawn_cloth(sheet(1.0, 1.0, 14), (top_edge(), place, Moved::by(When::Update, &pop)), None);
    let (mut stretch, mut fastest) = (0.0, 0.0);
    stage.run_and(3.0, |stage| {
        let seen = stage.take_seen();
        (stretch, fastest) = (worse(stretch, seen.stretch), worse(fastest, seen.fastest));
    });
    let wrong = stage.world().get::<ClothError>(cape).is_some();
    let scene = "cape that pops in";
    vec![
        Row::new(scene, "stretch/%", 100.0 * stretch, Wanted::AtMost(STRETCH)),
        Row::new(scene, "fastest/(m/s)", fastest, Wanted::AtMost(SPEED)),
        Row::new(scene, "errors left", f64::from(wrong), Wanted::AtMost(0.0)),
    ]
}

/// Times are judged only where nothing else is asked for: beside other work they say little.
pub fn rows(quick: bool, alone: bool) -> Vec<Row> {
    let mut rows = pop_in();
    for cells in if quick { &[12][..] } else { &[12, 20, 32, 64][..] } {
        let [still, _] = Scaled::Still.times(*cells);
        let scene = |what: &str| format!("sheet of {} vertices, {what}", (cells + 1) * (cells + 1));
        rows.push(Row::new(scene("still"), "update/ms", still, Wanted::Known));
        for (scaled, name) in [(Scaled::Breathing, "breathing"), (Scaled::Mirrored, "mirrored twice a second")] {
            let [update, longest] = scaled.times(*cells);
            let judged = |factor| if alone { Wanted::AtMost(factor * still) } else { Wanted::Known };
            rows.push(Row::new(scene(name), "update/ms", update, judged(FACTOR)));
            rows.push(Row::new(scene(name), "longest update/ms", longest, Wanted::Known));
        }
    }
    rows
}
