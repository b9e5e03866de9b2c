//! A wearer that turns about, dashes, blinks: the cape goes along, and is not dragged at speeds that nobody asked for.

use core::f64::consts::PI;

use bevy::prelude::*;

use super::frames::Frames;
use super::stage::{Moved, Path, Seen, Stage, When, path, sheet, top_edge};
use crate::row::{Row, Wanted};

/// When it happens, s, and how long it is watched from a little before that on.
const AT: f64 = 3.0;
const BEFORE: f64 = 0.1;
const SECONDS: f64 = 2.0;
/// Ticks a second.
pub const HZ: f64 = 64.0;
/// m/s, of a wearer that runs, and how long it takes to, s.
const RUN: f64 = 6.0;
const SPURT: f64 = 0.5;
/// Ticks of a dash.
const DASH: f64 = 10.0;
/// What is wanted: %, and m/s more than the wearer has.
pub const STRETCH: f64 = 10.0;
pub const SPEED: f64 = 5.0;

/// What a wearer does at once.
#[derive(Clone, Copy, Debug)]
enum Jump {
    /// It faces elsewhere, by so many degrees.
    Turn(f64),
    /// It faces about while it runs, and runs on as it did.
    TurnRunning,
    /// It faces about while it runs, and runs back.
    RunBack,
    /// It is so far away, m.
    Blink(f64),
    /// So far each tick, m.
    Dash(f64),
}

const JUMPS: [Jump; 14] = [
    Jump::Turn(30.0),
    Jump::Turn(90.0),
    Jump::Turn(135.0),
    Jump::Turn(180.0),
    Jump::TurnRunning,
    Jump::RunBack,
    Jump::Blink(0.3),
    Jump::Blink(1.0),
    Jump::Blink(1.9),
    Jump::Blink(2.1),
    Jump::Dash(0.2),
    Jump::Dash(0.5),
    Jump::Dash(1.9),
    Jump::Dash(2.1),
];

/// A look at all jumps.
const QUICK: [Jump; 3] = [Jump::Turn(180.0), Jump::Blink(1.0), Jump::Dash(0.5)];

/// How far one has run that began at the start, m.
fn run(time: f64) -> f64 {
    if time < SPURT { 0.5 * RUN * time * time / SPURT } else { RUN * (time - 0.5 * SPURT) }
}

impl Jump {
    fn name(self) -> String {
        match self {
            Self::Turn(degrees) => format!("turned by {degrees}°"),
            Self::TurnRunning => format!("turned by 180° at {RUN} m/s"),
            Self::RunBack => format!("turned by 180° at {RUN} m/s, and runs back"),
            Self::Blink(distance) => format!("moved by {distance} m"),
            Self::Dash(distance) => format!("dash of {DASH} ticks of {distance} m"),
        }
    }

    /// The fastest that the wearer itself is, m/s.
    fn own_speed(self) -> f64 {
        match self {
            Self::Turn(_) | Self::Blink(_) => 0.0,
            Self::TurnRunning | Self::RunBack => RUN,
            Self::Dash(distance) => distance * HZ,
        }
    }

    fn path(self) -> Path {
        let place = move |time: f64| {
            let (after, since) = (time >= AT, time - AT);
            match self {
                Self::Turn(degrees) => (0.0, if after { degrees.to_radians() } else { 0.0 }),
                Self::TurnRunning => (run(time), if after { PI } else { 0.0 }),
                Self::RunBack => (if after { run(AT) - RUN * since } else { run(time) }, if after { PI } else { 0.0 }),
                Self::Blink(distance) => (if after { distance } else { 0.0 }, 0.0),
                Self::Dash(distance) => (distance * (HZ * since).clamp(0.0, DASH), 0.0),
            }
        };
        path(move |time, transform| {
            let (ahead, angle) = place(time);
            transform.translation.z = -ahead as f32;
            transform.rotation = Quat::from_rotation_y(angle as f32);
        })
    }

    fn seen(self, when: When, fps: f64) -> Seen {
        let mut stage = Stage::new(HZ, Frames::Even(fps), AT, 0);
        let wearer = stage.spawn((Transform::IDENTITY, Moved::by(when, &self.path())), None);
        let behind = Transform::from_xyz(0.0, 1.4, 0.25);
        stage.spawn_cloth(sheet(0.8, 0.8, 14), (top_edge(), behind), Some(wearer));
        stage.run(AT - BEFORE);
        stage.take_seen();
        stage.run(SECONDS);
        stage.take_seen()
    }

    /// One figure of each kind, the worst of the frame rates.
    fn rows(self, when: When, rates: &[f64]) -> [Row; 2] {
        let scene = format!("cape, {}, in {}", self.name(), when.name());
        let own = self.own_speed();
        let all: Vec<_> = rates.iter().map(|&fps| (fps, self.seen(when, fps))).collect();
        [
            worst(&scene, "stretch/%", all.iter().map(|(fps, seen)| (*fps, 100.0 * seen.stretch)), STRETCH),
            worst(&scene, "faster than it/(m/s)", all.iter().map(|(fps, seen)| (*fps, seen.fastest - own)), SPEED),
        ]
    }
}

/// A row of the worst of several frame rates, which it names.
pub fn worst(scene: &str, what: &str, figures: impl Iterator<Item = (f64, f64)>, wanted: f64) -> Row {
    let (fps, figure) = figures.max_by(|a, b| a.1.total_cmp(&b.1)).expect("a frame rate");
    Row::new(scene, format!("{what}, at worst ({fps} fps)"), figure, Wanted::AtMost(wanted))
}

/// All jumps, made in either schedule at several frame rates.
pub fn rows(quick: bool) -> Vec<Row> {
    let (jumps, rates) = if quick { (&QUICK[..], &[60.0][..]) } else { (&JUMPS[..], &[30.0, 60.0, 144.0][..]) };
    let schedules = [When::FixedUpdate, When::Update];
    jumps.iter().flat_map(|jump| schedules.into_iter().flat_map(|when| jump.rows(when, rates))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_are_where_they_say() {
        let at = |jump: Jump, time| {
            let mut transform = Transform::IDENTITY;
            jump.path()(time, &mut transform);
            (-transform.translation.z, transform.rotation.angle_between(Quat::IDENTITY))
        };
        assert_eq!(at(Jump::Blink(0.3), AT - 1e-6), (0.0, 0.0));
        assert_eq!(at(Jump::Blink(0.3), AT), (0.3, 0.0));
        assert!((at(Jump::Turn(90.0), AT).1 - 0.5 * core::f32::consts::PI).abs() < 1e-3);
        let (dashed, _) = at(Jump::Dash(0.5), AT + 1.0);
        assert!((dashed - 5.0).abs() < 1e-5);
        let (there, back) = (at(Jump::RunBack, AT).0, at(Jump::RunBack, AT + 1.0).0);
        assert!((there - back - 6.0).abs() < 1e-4);
    }

    #[test]
    fn the_worst_rate_is_named() {
        let row = worst("scene", "stretch/%", [(30.0, 3.0), (60.0, 12.0), (144.0, 5.0)].into_iter(), 10.0);
        assert!(row.what.ends_with("(60 fps)") && row.measured == 12.0 && !row.met);
    }
}
