//! A cape on a runner whose motion comes from one schedule or another: what is drawn shakes no more than where the motion is
//! made in the schedule of the cloth.

use bevy::prelude::*;
use bevy_cloth::plugin::ClothCollider;

use super::frames::Frames;
use super::stage::{Moved, Path, Shake, Stage, When, path, sheet, top_edge};
use crate::row::{Row, Wanted};

/// m/s, once it runs, and when it starts to and how long that takes, s.
const SPEED: f64 = 6.0;
const START: f64 = 0.3;
const SPURT: f64 = 0.5;
/// Of the sway, rad, and how many a second.
const SWAY: f64 = 0.5;
const SWAYS: f64 = 1.0;
/// When what is watched begins and how long it lasts, s.
const WATCHED: f64 = 3.0;
const SECONDS: f64 = 2.0;
/// Starts that each figure is the worst of. The motion is not the same in all of them, as contact and folds make much of little.
pub const STARTS: u32 = 3;
/// Shake may be so many times that of the cape that is moved in `FixedUpdate`, and more than that by what nobody sees, mm.
const FACTOR: f64 = 1.5;
const UNSEEN: f64 = 0.1;
/// Stretch may be so much more, in points of a hundred.
const POINTS: f64 = 1.0;

/// How the cape is moved: what the root does, and what the bone does that the cape hangs on.
#[derive(Clone, Copy, Debug)]
struct Mover {
    name: &'static str,
    /// It runs.
    run: Option<(Part, When)>,
    /// It sways.
    sway: Option<(Part, When)>,
}

/// A part of the figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Root,
    Bone,
}

/// How a cape fared.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    /// mm.
    rms: f64,
    /// mm.
    most: f64,
    /// %.
    stretch: f64,
}

impl Outcome {
    fn worst(a: Self, b: Self) -> Self {
        Self { rms: a.rms.max(b.rms), most: a.most.max(b.most), stretch: a.stretch.max(b.stretch) }
    }
}

/// Runs in -z: how far it is, m.
pub fn distance(time: f64) -> f64 {
    let time = (time - START).max(0.0);
    if time < SPURT { 0.5 * SPEED * time * time / SPURT } else { SPEED * (time - 0.5 * SPURT) }
}

fn run_path() -> Path {
    path(|time, transform| transform.translation.z = -distance(time) as f32)
}

fn sway_path() -> Path {
    path(|time, transform| {
        let angle = SWAY * (core::f64::consts::TAU * SWAYS * time).sin() * (time / SPURT).min(1.0);
        transform.rotation = Quat::from_rotation_y(angle as f32);
    })
}

fn outcome(hz: f64, frames: Frames, body: bool, mover: Mover, start: u32) -> Outcome {
    let mut stage = Stage::new(hz, frames, WATCHED, start);
    let mut parts = [Moved::default(), Moved::default()];
    for (moving, path) in [(mover.run, run_path()), (mover.sway, sway_path())] {
        if let Some((part, when)) = moving {
            parts[part as usize].0.push((when, path));
        }
    }
    let [root, bone] = parts;
    let root = stage.spawn((Transform::IDENTITY, root), None);
    let bone = stage.spawn((Transform::IDENTITY, bone), Some(root));
    let behind = Transform::from_xyz(0.0, 1.4, 0.25);
    let cape = stage.spawn_cloth(sheet(0.6, 0.8, 14), (top_edge(), behind), Some(bone));
    if body {
        stage.spawn((ClothCollider::capsule(0.2, 0.8), Transform::from_xyz(0.0, 0.9, 0.0)), Some(bone));
    }
    stage.run(WATCHED);
    stage.take_seen();
    let mut shake = Shake::default();
    stage.run_and(SECONDS, |stage| shake.see(stage.drawn(cape)));
    Outcome { rms: 1e3 * shake.rms(), most: 1e3 * shake.most, stretch: 100.0 * stage.take_seen().stretch }
}

fn worst_of_starts(hz: f64, frames: Frames, body: bool, mover: Mover, starts: u32) -> Outcome {
    (0..starts).map(|start| outcome(hz, frames, body, mover, start)).fold(Outcome::default(), Outcome::worst)
}

/// All movers beside the first, which is moved in `FixedUpdate` alone.
fn compared(hz: f64, frames: Frames, body: bool, movers: &[Mover], starts: u32) -> Vec<Row> {
    let cape = if body { "cape and body" } else { "cape" };
    let mut rows = Vec::new();
    let mut reference: Option<Outcome> = None;
    for &mover in movers {
        let Outcome { rms, most, stretch } = worst_of_starts(hz, frames, body, mover, starts);
        let scene = format!("{cape}, {hz} Hz, {}: {}", frames.name(), mover.name);
        let [shakes, stretches] = match reference {
            None => [Wanted::Known; 2],
            Some(reference) => {
                [Wanted::AtMost(FACTOR * reference.rms + UNSEEN), Wanted::AtMost(reference.stretch + POINTS)]
            }
        };
        reference.get_or_insert(Outcome { rms, most, stretch });
        rows.push(Row::new(&scene, "shake, rms/mm", rms, shakes));
        rows.push(Row::new(&scene, "shake, most/mm", most, Wanted::Known));
        rows.push(Row::new(&scene, "stretch/%", stretch, stretches));
    }
    rows
}

const RUNNERS: [Mover; 3] = [
    Mover { name: "FixedUpdate", run: Some((Part::Root, When::FixedUpdate)), sway: None },
    Mover { name: "Update", run: Some((Part::Root, When::Update)), sway: None },
    Mover { name: "animated bone", run: Some((Part::Bone, When::Animation)), sway: None },
];

/// The table of frame rates.
pub fn even(quick: bool) -> Vec<Row> {
    let (rates, fps, starts) = if quick {
        (&[64.0][..], &[60.0][..], 1)
    } else {
        (&[64.0, 60.0][..], &[30.0, 59.94, 60.0, 75.0, 120.0, 144.0][..], STARTS)
    };
    let mut rows = Vec::new();
    for body in [false, true] {
        for &hz in rates {
            for &fps in fps {
                rows.extend(compared(hz, Frames::Even(fps), body, &RUNNERS, starts));
            }
        }
    }
    rows
}

/// The same with frames that are not alike.
pub fn uneven(quick: bool) -> Vec<Row> {
    let (fps, starts) = if quick { (&[60.0][..], 1) } else { (&[30.0, 60.0][..], STARTS) };
    let frames = fps.iter().flat_map(|&fps| Frames::uneven(fps));
    frames.flat_map(|frames| compared(64.0, frames, true, &RUNNERS, starts)).collect()
}

const SWAYERS: [Mover; 3] = [
    Mover { name: "bone sways in FixedUpdate", run: None, sway: Some((Part::Bone, When::FixedUpdate)) },
    Mover { name: "bone sways in Update", run: None, sway: Some((Part::Bone, When::Update)) },
    Mover { name: "bone sways in PostUpdate", run: None, sway: Some((Part::Bone, When::Animation)) },
];

const MIXED: [Mover; 6] = [
    Mover {
        name: "root and bone in FixedUpdate",
        run: Some((Part::Root, When::FixedUpdate)),
        sway: Some((Part::Bone, When::FixedUpdate)),
    },
    Mover {
        name: "root in FixedUpdate, bone in PostUpdate",
        run: Some((Part::Root, When::FixedUpdate)),
        sway: Some((Part::Bone, When::Animation)),
    },
    Mover {
        name: "root in Update, bone in FixedUpdate",
        run: Some((Part::Root, When::Update)),
        sway: Some((Part::Bone, When::FixedUpdate)),
    },
    Mover {
        name: "root in Update, bone in PostUpdate",
        run: Some((Part::Root, When::Update)),
        sway: Some((Part::Bone, When::Animation)),
    },
    Mover {
        name: "root in PreUpdate, bone in PostUpdate",
        run: Some((Part::Root, When::PreUpdate)),
        sway: Some((Part::Bone, When::Animation)),
    },
    Mover {
        name: "root runs in FixedUpdate and turns in Update",
        run: Some((Part::Root, When::FixedUpdate)),
        sway: Some((Part::Root, When::Update)),
    },
];

/// A bone that sways, on a root that stands or runs.
pub fn sway(quick: bool) -> Vec<Row> {
    let (fps, starts) = if quick { (&[60.0][..], 1) } else { (&[30.0, 60.0, 144.0][..], STARTS) };
    let mut rows = Vec::new();
    for &fps in fps {
        rows.extend(compared(64.0, Frames::Even(fps), true, &SWAYERS, starts));
        rows.extend(compared(64.0, Frames::Even(fps), true, &MIXED, starts));
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_runner_runs_and_the_cape_hangs() {
        assert!((distance(3.0) - distance(2.0) - SPEED).abs() < 1e-12);
        let Outcome { rms, most, stretch } = outcome(60.0, Frames::Even(60.0), true, RUNNERS[0], 0);
        assert!(rms > 0.0 && rms < 5.0 && most >= rms && stretch > 0.0 && stretch < 5.0, "{rms} {most} {stretch}");
    }
}
