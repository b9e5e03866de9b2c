//! What is to be reached, beside what was.

use bevy_cloth::physics::Quality;
use serde::Serialize;

use super::accuracy::AccuracyRow;
use super::case::Case;
use super::plugin::PluginRow;
use super::solver::SolverRow;
use crate::report::{Table, figure};
use crate::scenes::Meshing;

/// Side → ms per frame and, for the larger, products of the same matrix; one thread.
const SHEETS: [(u32, f64, Option<f64>); 6] = [
    (20, 0.12, None),
    (32, 0.35, None),
    (64, 1.5, Some(60.0)),
    (100, 4.5, Some(60.0)),
    (141, 11.0, Some(60.0)),
    (200, 30.0, Some(60.0)),
];

/// A target and what was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// What it is about.
    pub target: String,
    /// The bound.
    pub limit: f64,
    /// Whether the figure must be at least the bound; else at most.
    pub at_least: bool,
    /// The figure.
    pub measured: f64,
    /// Whether it is reached.
    pub met: bool,
}

impl Verdict {
    fn at_most(target: impl Into<String>, limit: f64, measured: f64) -> Self {
        Self { target: target.into(), limit, at_least: false, measured, met: measured <= limit }
    }

    fn at_least(target: impl Into<String>, limit: f64, measured: f64) -> Self {
        Self { target: target.into(), limit, at_least: true, measured, met: measured >= limit }
    }
}

/// The targets that these rows say something about.
pub fn verdicts(rows: &[SolverRow], plugin: &[PluginRow], accuracy: &[AccuracyRow]) -> Vec<Verdict> {
    let ms = |case: Case| rows.iter().find(|row| row.case == case).map(|row| row.frame_ms.median);
    let mut verdicts = Vec::new();
    for (side, limit, spmvs) in SHEETS {
        let Some(row) = rows.iter().find(|row| row.case == Case::sheet(side)) else { continue };
        verdicts.push(Verdict::at_most(format!("{side}²: ms per frame"), limit, row.frame_ms.median));
        if let Some(limit) = spmvs {
            verdicts.push(Verdict::at_most(format!("{side}²: frame in SpMVs"), limit, row.frame_spmvs));
        }
    }
    if let Some(ms) = ms(Case { threads: 2, ..Case::CROWD }) {
        verdicts.push(Verdict::at_most("100 × 20², 2 threads: ms per frame", 7.0, ms));
    }
    if let (Some(small), Some(large)) = (ms(Case::sheet(32)), ms(Case::sheet(200))) {
        let exponent = (large / small).ln() / (200.0_f64 / 32.0).powi(2).ln();
        verdicts.push(Verdict::at_most("growth from 32² to 200²: exponent", 1.15, exponent));
    }
    // In products of the same run, for a machine whose speed changes between the rows.
    let products =
        |case: Case| rows.iter().find(|row| row.case == case).map(|row| 1e3 * row.frame_ms.median / row.spmv_us);
    for (case, limit) in [(Case::sheet(100), 1.7), (Case::CROWD, 1.85)] {
        if let (Some(one), Some(two)) = (products(case), products(Case { threads: 2, ..case })) {
            verdicts.push(Verdict::at_least(format!("{}: gain from a second thread", case.name()), limit, one / two));
        }
    }
    if let Some(row) = plugin.iter().find(|row| row.case == Case::sheet(100)) {
        verdicts.push(Verdict::at_most("100²: share of an update that is not the step", 0.1, row.around));
    }
    let grids = rows.iter().filter(|row| row.case.meshing == Meshing::Grid);
    if let Some(bytes) = grids.map(|row| row.bytes_per_vertex).reduce(f64::max) {
        verdicts.push(Verdict::at_most("memory: bytes per vertex, the most", 1500.0, bytes));
    }
    for row in accuracy {
        if let Some(error) = row.error_m.filter(|_| row.case == Case::CONVERGED) {
            verdicts.push(Verdict::at_most(format!("{}: error over half a second, m", row.case.name()), 1.5e-2, error));
        }
    }
    let judged = accuracy.iter().filter(|row| row.case.quality == Quality::Medium);
    if let Some(error) = judged.map(AccuracyRow::stretch_error).reduce(f64::max) {
        verdicts.push(Verdict::at_most("RMS stretch against exact solves, the worst", 0.02, error));
    }
    verdicts
}

/// The verdicts for the reader.
pub fn table(verdicts: &[Verdict]) -> Table {
    let mut table = Table::new("target limit measured verdict");
    for verdict in verdicts {
        table.row([
            verdict.target.clone(),
            format!("{} {}", if verdict.at_least { "≥" } else { "≤" }, verdict.limit),
            figure(verdict.measured),
            if verdict.met { "met" } else { "missed" }.into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::statistics::Spread;
    use super::*;

    fn row(case: Case, ms: f64) -> SolverRow {
        SolverRow {
            case,
            vertices: case.vertices(),
            frames: 120,
            frame_ms: Spread { median: ms, p95: ms },
            cpu_ms: ms,
            assembly_ms: 0.0,
            preconditioner_ms: 0.0,
            solve_ms: 0.0,
            write_back_ms: 0.0,
            iterations: 5.0,
            spmv_us: 100.0,
            half_spmv_us: 100.0,
            frame_spmvs: 10.0 * ms,
            bytes_per_vertex: 1000.0,
            max_stretch: 0.0,
            rms_stretch: 0.0,
            fall_m: None,
            fallbacks: 0,
            rejected: 0,
        }
    }

    #[test]
    fn only_what_was_measured_is_judged() {
        let verdicts = verdicts(&[row(Case::sheet(64), 2.0)], &[], &[]);
        let judged: Vec<_> = verdicts.iter().map(|v| (v.target.as_str(), v.met)).collect();
        let expected =
            [("64²: ms per frame", false), ("64²: frame in SpMVs", true), ("memory: bytes per vertex, the most", true)];
        assert_eq!(judged, expected);
    }

    #[test]
    fn growth_and_gain_compare_rows() {
        let pair = |case, ms| [row(case, ms), row(Case { threads: 2, ..case }, ms / 1.8)];
        let [one, two] = pair(Case::CROWD, 9.0);
        let [sheet, sheet_on_two] = pair(Case::sheet(100), 4.0);
        let rows = [row(Case::sheet(32), 0.3), row(Case::sheet(200), 0.3 * 39.0625), one, two, sheet, sheet_on_two];
        let verdicts = verdicts(&rows, &[], &[]);
        let find = |text: &str| verdicts.iter().find(|v| v.target.starts_with(text)).expect("judged");
        assert!((find("growth").measured - 1.0).abs() < 1e-12);
        let gains: Vec<_> = verdicts.iter().filter(|v| v.at_least).map(|v| v.met).collect();
        assert_eq!(gains, [true, false]);
        assert!(find("100 × 20², 2 threads").met);
        assert!(table(&verdicts).to_string().contains("≥ 1.85"));
    }
}
