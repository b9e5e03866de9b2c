//! How far from the truth a frame is for what it costs: against converged steps.

use bevy_cloth::physics::{Cloth, Precision, SolverKind, SolverSettings};
use indicatif::ProgressBar;
use serde::Serialize;

use super::case::Case;
use crate::report::{Table, figure, percent};
use crate::scenes::{DT, Sheet};

/// Half a second.
const FRAMES: u32 = 30;
/// Substeps of a converged frame: steps of 1/1920 s.
const CONVERGED: u32 = 32;

/// Accuracy over the first half second.
#[derive(Clone, Debug, Serialize)]
pub struct AccuracyRow {
    /// What was measured.
    #[serde(flatten)]
    pub case: Case,
    /// Root mean square distance from where steps of 1/1920 s lead, over vertices and frames, m, if it was to be measured.
    pub error_m: Option<f64>,
    /// Root mean square elongation with those steps, on average over the frames, likewise.
    pub converged_rms_stretch: Option<f64>,
    /// The same with ours.
    pub rms_stretch: f64,
    /// The same with ours, but every system solved exactly: Cholesky in f64.
    pub exact_rms_stretch: f64,
}

impl AccuracyRow {
    /// How far the stretch is from that of exact solves, relative to it.
    pub fn stretch_error(&self) -> f64 {
        (self.rms_stretch / self.exact_rms_stretch - 1.0).abs()
    }
}

/// Runs a case; `converged` if its error is to be measured too, which takes long.
pub fn measure(case: Case, converged: bool, progress: &ProgressBar) -> AccuracyRow {
    let sheet = Sheet::new(case.side, case.meshing);
    let mut cloth = sheet.hang(case.quality.settings());
    let substeps = case.quality.settings().substeps;
    let mut exact = sheet.hang(SolverSettings { substeps, ..SolverSettings::reference() });
    let mut fine = converged.then(|| sheet.hang(fine_settings()));
    let (mut stretch, mut exact_stretch, mut converged_stretch, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for _ in 0..FRAMES {
        cloth.step(DT);
        exact.step(DT);
        stretch += cloth.stretch().rms / f64::from(FRAMES);
        exact_stretch += exact.stretch().rms / f64::from(FRAMES);
        if let Some(fine) = &mut fine {
            fine.step(DT);
            converged_stretch += fine.stretch().rms / f64::from(FRAMES);
            squares += mean_square_distance(&cloth, fine) / f64::from(FRAMES);
        }
        progress.inc(1);
    }
    AccuracyRow {
        case,
        error_m: converged.then(|| squares.sqrt()),
        converged_rms_stretch: converged.then_some(converged_stretch),
        rms_stretch: stretch,
        exact_rms_stretch: exact_stretch,
    }
}

/// Frames that the progress of a case counts.
pub const fn frames() -> u64 {
    FRAMES as u64
}

fn fine_settings() -> SolverSettings {
    SolverSettings {
        kind: SolverKind::conjugate_gradient(1e-3),
        precision: Precision::Double,
        substeps: CONVERGED,
        ..Default::default()
    }
}

fn mean_square_distance(a: &Cloth, b: &Cloth) -> f64 {
    let squares = a.positions().iter().zip(b.positions()).map(|(a, b)| a.distance_squared(*b));
    squares.sum::<f64>() / a.positions().len() as f64
}

/// The rows for the reader.
pub fn table(rows: &[AccuracyRow]) -> Table {
    let mut table = Table::new("accuracy error/mm RMS-stretch solved-exactly difference converged");
    for row in rows {
        table.row([
            row.case.name(),
            row.error_m.map_or("–".into(), |error| figure(1e3 * error)),
            percent(row.rms_stretch),
            percent(row.exact_rms_stretch),
            percent(row.stretch_error()),
            row.converged_rms_stretch.map_or("–".into(), percent),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_sheet_is_near_the_truth_and_not_there() {
        let row = measure(Case::sheet(8), true, &ProgressBar::hidden());
        assert!(row.error_m.is_some_and(|error| (1e-4..0.05).contains(&error)), "{row:?}");
        assert!(row.stretch_error() > 0.0 && row.stretch_error() < 0.05, "{row:?}");
    }
}
