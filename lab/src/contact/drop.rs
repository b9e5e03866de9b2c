//! Scene W2: a sheet of 1 m × 1 m dropped on a ball, beside scene W1, the same sheet hung by two corners.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, Pose, SolverSettings};
use serde::Serialize;

use super::body::Body;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::timing::{Timed, median_and_mean, side_by_side};
use super::trial::Trial;
use crate::bench::statistics::Frames;
use crate::report::{Table, figure, percent};
use crate::scenes::{DT, Meshing, Sheet, fabric};
use crate::validate::strip::{Strip, place};

/// Frames that are timed.
pub const FRAMES: u32 = 180;
/// Of the ball, m.
const RADIUS: f64 = 0.3;
/// Between the top of the ball and the sheet, m.
const GAP: f64 = 0.05;
/// Air that stops the swing of what hangs free, which no contact would, 1/s: what still moves then is contact's.
const THICK_AIR: f32 = 8.0;

/// Cost of a frame of both scenes.
#[derive(Clone, Debug, Serialize)]
pub struct Cost {
    /// Vertices along a side.
    pub side: u32,
    /// Median and mean processor time of a frame of W1, ms.
    pub hung_ms: [f64; 2],
    /// Median and mean processor time of a frame of W2, ms.
    pub dropped_ms: [f64; 2],
    /// Share of the time of its steps that W2 finds contacts in.
    pub finding: f64,
}

impl Cost {
    /// Of W2 in those of W1: the medians and the means.
    pub fn ratios(&self) -> [f64; 2] {
        [0, 1].map(|i| self.dropped_ms[i] / self.hung_ms[i])
    }
}

/// A horizontal sheet of n × n vertices with its middle at a place.
pub fn sheet(n: u32, middle: DVec3, fabric: Fabric) -> Cloth {
    let mut cloth = Strip::new(1.0, 1.0, n - 1, n - 1).cloth(fabric, SolverSettings::default());
    place(&mut cloth, |x| x + middle - DVec3::new(0.5, 0.0, 0.5));
    cloth
}

/// The sheet above the ball, whose centre is the origin.
fn dropped(n: u32) -> Trial {
    let ball = Body::fixed(Solid::Ball { radius: RADIUS }, 0.5, Pose::IDENTITY);
    Trial::new(sheet(n, DVec3::Y * (RADIUS + GAP), fabric()), vec![ball], DT)
}

enum Scene {
    Hung(Cloth),
    Dropped { trial: Trial, finding: f64, total: f64 },
}

impl Timed for Scene {
    fn frame(&mut self, frame: &mut dyn FnMut(&mut dyn FnMut())) {
        match self {
            Self::Hung(cloth) => frame(&mut || {
                cloth.step(DT);
            }),
            Self::Dropped { trial, finding, total } => trial.step_by(|cloth, dt| {
                let mut report = None;
                frame(&mut || report = Some(cloth.step(dt)));
                let report = report.expect("the frame takes the step");
                *finding += report.contact.as_secs_f64();
                *total += report.total.as_secs_f64();
                report
            }),
        }
    }
}

fn timed(n: u32, frames: u32, repeat: u32) -> (Trial, Cost) {
    let hung = Sheet::new(n, Meshing::Grid);
    let scenes = || {
        let dropped = Scene::Dropped { trial: dropped(n), finding: 0.0, total: 0.0 };
        [Scene::Hung(hung.hang(SolverSettings::default())), dropped]
    };
    let (scenes, Frames(times)) = side_by_side(frames, repeat, scenes);
    let [hung_ms, dropped_ms] = times.each_ref().map(|times| median_and_mean(times));
    let [_, Scene::Dropped { trial, finding, total }] = scenes else { unreachable!("the second is dropped") };
    (trial, Cost { side: n, hung_ms, dropped_ms, finding: finding / total })
}

/// What both scenes cost.
pub fn cost(n: u32, frames: u32, repeat: u32) -> Cost {
    timed(n, frames, repeat).1
}

/// The rows of the bench for the reader: CPU time, the median unless said.
pub fn table(rows: &[Cost]) -> Table {
    let mut table = Table::new("dropped ms mean hung-ms mean ratio ratio-of-means finding");
    for row in rows {
        let [dropped, hung] = [row.dropped_ms, row.hung_ms];
        let figures = dropped.into_iter().chain(hung).chain(row.ratios()).map(figure);
        table.row(core::iter::once(format!("{0}²", row.side)).chain(figures).chain([percent(row.finding)]));
    }
    table
}

/// The judgements at a size: what it costs, how deep it is, whether it lies there at last.
pub fn rows(n: u32, frames: u32, seconds: f64) -> Vec<Row> {
    let (mut trial, cost) = timed(n, frames, if n > 64 { 2 } else { 3 });
    let scene = format!("drop {n}²");
    let row = |what: &str, measured, wanted| Row::new(&scene, what, measured, wanted);
    let stretch = 100.0 * trial.cloth.stretch().rms;
    let [hung, dropped] = [cost.hung_ms, cost.dropped_ms];
    let mut rows = vec![
        row("ms a frame, median", dropped[0], Wanted::Known),
        row("ms a frame, mean", dropped[1], Wanted::Known),
        row("hung: ms a frame, median", hung[0], Wanted::Known),
        row("hung: ms a frame, mean", hung[1], Wanted::Known),
        row("times hung, median", cost.ratios()[0], Wanted::AtMost(2.0)),
        row("times hung, mean", cost.ratios()[1], Wanted::AtMost(2.0)),
        row("finding contacts/%", 100.0 * cost.finding, Wanted::Known),
        row("RMS stretch/%", stretch, Wanted::AtMost(0.3)),
    ];
    let air = Fabric { air_drag: THICK_AIR, ..fabric() };
    trial.cloth.set_fabric(air).expect("the fabric is valid");
    trial.run(seconds - trial.time - 1.0);
    let (mut peak, mut top) = (0.0_f64, f64::INFINITY);
    trial.run_with(1.0, |trial| {
        peak = peak.max(trial.peak_speed());
        top = top.min(trial.highest());
    });
    rows.extend(trial.rows(&scene));
    rows.push(trial.energy_row(&scene));
    rows.push(row("lowest top over the ball/mm", 1e3 * (top - RADIUS), Wanted::Within(0.0, 10.0)));
    let centre = trial.centre();
    rows.push(row("centre off the axis/mm", 1e3 * centre.x.hypot(centre.z), Wanted::AtMost(50.0)));
    rows.push(row("peak speed at rest/(mm/s)", 1e3 * peak, Wanted::AtMost(1.0)));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_scenes_are_the_same_sheet() {
        let (trial, hung) = (dropped(9), Sheet::new(9, Meshing::Grid).hang(SolverSettings::default()));
        assert_eq!(trial.cloth.masses(), hung.masses());
        let triangles = |cloth: &Cloth| cloth.shape().triangles.iter().map(|t| t.vertices).collect::<Vec<_>>();
        assert_eq!(triangles(&trial.cloth), triangles(&hung));
        assert!((trial.highest() - RADIUS - GAP).abs() < 1e-12 && trial.centre().x.abs() < 1e-12);
    }

    #[test]
    fn costs_are_of_both() {
        let cost = cost(8, 6, 2);
        assert!(cost.hung_ms.iter().chain(&cost.dropped_ms).all(|&ms| ms > 0.0), "{cost:?}");
        assert_eq!(table(std::slice::from_ref(&cost)).to_string().lines().count(), 2);
        assert!(cost.ratios()[0] > 0.2 && cost.finding >= 0.0, "{cost:?}");
    }
}
