//! A stretch of frames.

use std::collections::BTreeMap;
use std::time::Duration;

use bevy_cloth::plugin::{ClothBudgetReport, ClothQuality};
use indicatif::ProgressBar;
use serde::Serialize;

use super::Scene;
use crate::bench::Spread;
use crate::report::{Table, figure};
use crate::scenes::DT;

/// Mean time of a frame, as a share of the budget, that passes for within it.
const WITHIN: f64 = 1.1;
/// Largest move of a vertex in a frame, against that without a budget: catching up, two ticks are shown in one.
const JUMP: f64 = 2.2;

/// What was seen in it.
pub struct Recorded {
    times: Vec<Duration>,
    moves: Vec<f32>,
    report: ClothBudgetReport,
    /// Number of cloths on each rung at the end, and of those that have all they asked for.
    rungs: BTreeMap<(u32, ClothQuality), usize>,
    whole: usize,
    /// How often a cloth changed its level or its interval.
    changes: usize,
}

impl Recorded {
    /// Runs so many frames.
    pub fn of(scene: &mut Scene, frames: u32, progress: &ProgressBar) -> Self {
        let (mut times, mut moves, mut changes) = (Vec::new(), Vec::new(), 0);
        let mut before = scene.levels();
        for _ in 0..frames {
            let (time, moved) = scene.frame();
            times.push(time);
            moves.push(moved);
            let now = scene.levels();
            changes += before.iter().zip(&now).filter(|(before, now)| before != now).count();
            before = now;
            progress.inc(1);
        }
        let report = *scene.app.world().resource::<ClothBudgetReport>();
        let (mut rungs, mut whole) = (BTreeMap::new(), 0);
        for (interval, quality) in before.into_iter().flatten() {
            *rungs.entry((interval, quality)).or_default() += 1;
            whole += usize::from(quality == ClothQuality::default());
        }
        Self { times, moves, report, rungs, whole, changes }
    }

    /// Mean time of a frame, ms.
    pub fn mean_ms(&self) -> f64 {
        1e3 * self.times.iter().sum::<Duration>().as_secs_f64() / self.times.len() as f64
    }

    /// Largest move of a vertex in a frame, m.
    pub fn largest_move(&self) -> f32 {
        self.moves.iter().copied().fold(0.0, f32::max)
    }

    /// "3 medium, 5 crowd/4": a step in every fourth tick.
    fn levels(&self) -> String {
        let mut rungs: Vec<_> = self.rungs.iter().collect();
        rungs.sort_by_key(|((interval, quality), _)| (*interval, std::cmp::Reverse(*quality)));
        let name = |interval: u32, quality: ClothQuality| {
            let quality = format!("{quality:?}").to_lowercase();
            if interval == 1 { quality } else { format!("{quality}/{interval}") }
        };
        let rungs: Vec<_> = rungs
            .into_iter()
            .map(|(&(interval, quality), count)| format!("{count} {}", name(interval, quality)))
            .collect();
        rungs.join(", ")
    }
}

/// A phase, for the reader.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What it is.
    pub phase: &'static str,
    /// Number of cloths.
    pub cloths: usize,
    /// Mean time of the same frames without a budget, ms.
    pub requested_ms: f64,
    /// The budget, ms.
    pub budget_ms: f64,
    /// Mean time of a frame: collecting, stepping, writing back, ms.
    pub mean_ms: f64,
    /// 95th percentile of it, ms.
    pub p95_ms: f64,
    /// What the plugin predicted at the end, ms.
    pub predicted_ms: f32,
    /// Number of cloths on each level at the end; `crowd/4` takes a step in every fourth tick.
    pub levels: String,
    /// Largest move of a shown vertex in a frame, m.
    pub largest_move_m: f32,
    /// The same, against the largest without a budget.
    pub jump: f64,
    /// How often a cloth changed its level or its interval, 1/s, on average.
    pub changes_hz: f64,
    /// Share of the cloths that have what they asked for at the end.
    pub whole: f64,
    /// Whether it is as wanted.
    pub pass: bool,
}

impl Row {
    /// Of what was recorded; without a budget no vertex moved more than `largest` (m) in a frame.
    pub fn new(phase: &'static str, requested_ms: f64, budget_ms: f64, recorded: &Recorded, largest: f32) -> Self {
        let cloths = recorded.rungs.values().sum();
        Self {
            phase,
            cloths,
            requested_ms,
            budget_ms,
            mean_ms: recorded.mean_ms(),
            p95_ms: Spread::of(&recorded.times).p95,
            predicted_ms: recorded.report.predicted_ms,
            levels: recorded.levels(),
            largest_move_m: recorded.largest_move(),
            jump: f64::from(recorded.largest_move() / largest),
            changes_hz: recorded.changes as f64 / (recorded.times.len() * cloths) as f64 / DT,
            whole: recorded.whole as f64 / cloths as f64,
            pass: true,
        }
    }

    fn and(self, wanted: bool) -> Self {
        Self { pass: self.pass && wanted, ..self }
    }

    /// Nothing is to pop.
    pub fn moving(self) -> Self {
        let wanted = self.jump <= JUMP;
        self.and(wanted)
    }

    /// The mean is to stay within the budget.
    pub fn within(self) -> Self {
        let wanted = self.mean_ms <= WITHIN * self.budget_ms;
        self.and(wanted)
    }

    /// Everyone is to have what was asked for.
    pub fn whole(self) -> Self {
        let wanted = self.whole == 1.0;
        self.and(wanted)
    }
}

/// The rows for the reader.
pub fn table(rows: &[Row]) -> Table {
    let mut table =
        Table::new("phase cloths requested/ms budget/ms mean/ms p95/ms predicted/ms jump changes/Hz levels verdict");
    for row in rows {
        table.row([
            row.phase.into(),
            row.cloths.to_string(),
            figure(row.requested_ms),
            figure(row.budget_ms),
            figure(row.mean_ms),
            figure(row.p95_ms),
            figure(row.predicted_ms.into()),
            figure(row.jump),
            figure(row.changes_hz),
            row.levels.clone(),
            if row.pass { "as wanted" } else { "missed" }.into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recorded(ms: u64) -> Recorded {
        let rungs = [((4, ClothQuality::Crowd), 2), ((1, ClothQuality::Low), 1), ((1, ClothQuality::Medium), 1)];
        Recorded {
            times: vec![Duration::from_millis(ms); 10],
            moves: vec![0.1; 10],
            report: ClothBudgetReport::default(),
            rungs: rungs.into(),
            whole: 1,
            changes: 2,
        }
    }

    #[test]
    fn each_wish_is_checked() {
        let row = |ms, largest| Row::new("held", 30.0, 10.0, &recorded(ms), largest);
        assert!(row(11, 0.1).moving().within().pass);
        assert!(!row(12, 0.1).within().pass && row(12, 0.1).moving().pass);
        assert!(!row(10, 0.04).moving().pass);
        assert!(!row(10, 0.1).whole().within().pass);
        assert!((row(10, 0.1).changes_hz - 3.0).abs() < 1e-9);
        assert_eq!(row(10, 0.1).levels, "1 medium, 1 low, 2 crowd/4");
        assert_eq!(table(&[row(10, 0.1)]).to_string().lines().count(), 2);
    }
}
