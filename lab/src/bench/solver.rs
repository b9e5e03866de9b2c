//! The physics alone: cloths stepped without an app.

use std::time::{Duration, Instant};

use bevy_cloth::physics::{Cloth, StepOutcome, StepReport};
use cpu_time::ProcessTime;
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde::Serialize;

use super::case::Case;
use super::spmv::Yardstick;
use super::statistics::{Frames, Spread, median};
use crate::memory::live_bytes;
use crate::report::{Table, figure, percent};
use crate::scenes::{DT, Sheet};

/// The fall of the free edge is read at 0.25 s.
const FALL_FRAME: u32 = 15;

/// Cost of a frame, and what the cloth looks like at the end.
#[derive(Clone, Debug, Serialize)]
pub struct SolverRow {
    /// What was measured.
    #[serde(flatten)]
    pub case: Case,
    /// Vertices of all cloths together.
    pub vertices: usize,
    /// Frames.
    pub frames: u32,
    /// Time of a frame, all cloths, ms.
    pub frame_ms: Spread,
    /// Median processor time of a frame, all threads together, ms: on one thread what the frame takes on a machine that does
    /// nothing else.
    pub cpu_ms: f64,
    /// Median time spent on A and b, ms; of several cloths, the sum, though they ran side by side.
    pub assembly_ms: f64,
    /// Median time spent on preparing the preconditioner, ms; likewise.
    pub preconditioner_ms: f64,
    /// Median time spent on solving, ms; likewise.
    pub solve_ms: f64,
    /// Median of what remains of the steps: prediction, energy check, the state written back, ms; likewise.
    pub write_back_ms: f64,
    /// Mean solver iterations of a cloth in a frame.
    pub iterations: f64,
    /// Median time of one product of the matrix of a cloth, both halves of it stored, with a vector, µs: between the frames.
    pub spmv_us: f64,
    /// The same as the solver has it, which stores one half, µs.
    pub half_spmv_us: f64,
    /// Median processor time of a cloth's frame in such products.
    pub frame_spmvs: f64,
    /// Memory of a cloth for each of its vertices, B.
    pub bytes_per_vertex: f64,
    /// Largest elongation of a yarn at the end.
    pub max_stretch: f64,
    /// Root mean square elongation at the end.
    pub rms_stretch: f64,
    /// How far the free edge is below where it began after 0.25 s, m, on average, if there were so many frames.
    pub fall_m: Option<f64>,
    /// Steps that failed the energy check and were taken again.
    pub fallbacks: u32,
    /// Steps that could not be taken.
    pub rejected: usize,
}

/// Runs a case in the current thread pool.
pub fn measure(case: Case, frames: u32, repeat: u32, progress: &ProgressBar) -> SolverRow {
    let sheet = Sheet::new(case.side, case.meshing);
    let mut run = Run::new(&sheet, case, frames, progress);
    for _ in 1..repeat {
        let again = Run::new(&sheet, case, frames, progress);
        run.times = run.times.least(again.times);
    }
    let [frame, cpu, assembly, preconditioner, solve, write_back, spmv, half_spmv] = &run.times.0;
    let (cpu_ms, spmv_ms, stretch) = (median(cpu), median(spmv), run.cloths[0].stretch());
    SolverRow {
        case,
        vertices: case.vertices(),
        frames,
        frame_ms: Spread::of(frame),
        cpu_ms,
        assembly_ms: median(assembly),
        preconditioner_ms: median(preconditioner),
        solve_ms: median(solve),
        write_back_ms: median(write_back),
        iterations: run.iterations as f64 / (case.cloths as f64 * f64::from(frames)),
        spmv_us: 1e3 * spmv_ms,
        half_spmv_us: 1e3 * median(half_spmv),
        frame_spmvs: cpu_ms / (case.cloths as f64 * spmv_ms),
        bytes_per_vertex: run.bytes as f64 / case.vertices() as f64,
        max_stretch: stretch.max,
        rms_stretch: stretch.rms,
        fall_m: run.fall,
        fallbacks: run.fallbacks,
        rejected: run.rejected,
    }
}

/// A scene from beginning to end.
struct Run {
    cloths: Vec<Cloth>,
    /// Of the frame, by the clock and of the processor; of its assembly, its preconditioners, its solves and what else there is in
    /// its steps; of the products between it and the next.
    times: Frames<8>,
    iterations: u64,
    fallbacks: u32,
    rejected: usize,
    bytes: isize,
    fall: Option<f64>,
}

impl Run {
    fn new(sheet: &Sheet, case: Case, frames: u32, progress: &ProgressBar) -> Self {
        // Room for the figures first: what is allocated from here on is cloth.
        let mut times = Frames::with_capacity(frames);
        let mut reports = Vec::with_capacity(case.cloths);
        let mut yardstick = Yardstick::new(&sheet.hang(case.quality.settings()));
        let before = live_bytes();
        let mut cloths: Vec<_> = (0..case.cloths).map(|_| sheet.hang(case.quality.settings())).collect();
        let (mut iterations, mut fallbacks, mut rejected, mut fall) = (0, 0, 0, None);
        for frame in 1..=frames {
            let (start, cpu_start) = (Instant::now(), ProcessTime::now());
            step(&mut cloths, &mut reports);
            let (elapsed, cpu) = (start.elapsed(), cpu_start.elapsed());

            let sum = |time: fn(&StepReport) -> Duration| reports.iter().map(time).sum::<Duration>();
            let (assembly, preconditioner) = (sum(|report| report.assembly), sum(|report| report.preconditioner));
            let solve = sum(|report| report.solve);
            let write_back = sum(|report| report.total).saturating_sub(assembly + preconditioner + solve);
            let [spmv, half_spmv] = yardstick.time();
            times.push([elapsed, cpu, assembly, preconditioner, solve, write_back, spmv, half_spmv]);
            iterations += reports.iter().map(|report| u64::from(report.iterations)).sum::<u64>();
            fallbacks += reports.iter().map(|report| report.fallbacks).sum::<u32>();
            rejected += reports.iter().filter(|report| report.outcome != StepOutcome::Accepted).count();
            if frame == FALL_FRAME {
                fall = Some(sheet.fall(&cloths[0]));
            }
            progress.inc(1);
        }
        let bytes = live_bytes() - before;
        Self { cloths, times, iterations, fallbacks, rejected, bytes, fall }
    }
}

/// One frame. A single cloth has the pool to itself.
fn step(cloths: &mut [Cloth], reports: &mut Vec<StepReport>) {
    match cloths {
        [cloth] => {
            reports.clear();
            reports.push(cloth.step(DT));
        }
        cloths => cloths.par_iter_mut().map(|cloth| cloth.step(DT)).collect_into_vec(reports),
    }
}

/// The rows for the reader.
pub fn table(rows: &[SolverRow]) -> Table {
    let mut table = Table::new(
        "cloth threads ms p95 CPU assembly preconditioner solve write-back iterations SpMV/µs half/µs in-SpMVs B/vertex stretch RMS fall/m fallbacks rejected",
    );
    for row in rows {
        table.row([
            row.case.name(),
            row.case.threads.to_string(),
            figure(row.frame_ms.median),
            figure(row.frame_ms.p95),
            figure(row.cpu_ms),
            figure(row.assembly_ms),
            figure(row.preconditioner_ms),
            figure(row.solve_ms),
            figure(row.write_back_ms),
            figure(row.iterations),
            figure(row.spmv_us),
            figure(row.half_spmv_us),
            figure(row.frame_spmvs),
            figure(row.bytes_per_vertex),
            percent(row.max_stretch),
            percent(row.rms_stretch),
            row.fall_m.map_or("–".into(), figure),
            row.fallbacks.to_string(),
            row.rejected.to_string(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::Meshing;

    #[test]
    fn a_small_sheet_gives_a_sane_row() {
        let row = measure(Case::sheet(10), 30, 2, &ProgressBar::hidden());
        assert_eq!((row.vertices, row.rejected), (100, 0));
        assert!(row.frame_ms.median > 0.0 && row.frame_ms.p95 >= row.frame_ms.median, "{row:?}");
        assert!(row.cpu_ms > 0.0 && row.assembly_ms > 0.0 && row.solve_ms > 0.0 && row.spmv_us > 0.0, "{row:?}");
        assert!(row.frame_spmvs > 1.0 && row.iterations >= 1.0, "{row:?}");
        // Free fall would be 0.307 m; the edge opposite a hinge falls faster, air and sag aside.
        assert!(row.fall_m.is_some_and(|fall| (0.2..0.5).contains(&fall)), "{row:?}");
        assert!(row.rms_stretch > 1e-4 && row.rms_stretch < 0.02 && row.max_stretch < 0.2, "{row:?}");
    }

    #[test]
    fn cloths_side_by_side_move_as_one_alone() {
        let alone = measure(Case::sheet(8), 15, 1, &ProgressBar::hidden());
        let crowd = measure(Case { cloths: 3, ..Case::sheet(8) }, 15, 1, &ProgressBar::hidden());
        assert_eq!((crowd.fall_m, crowd.rms_stretch), (alone.fall_m, alone.rms_stretch));
        assert_eq!(crowd.vertices, 192);
    }

    #[test]
    fn the_order_of_the_vertices_hardly_matters() {
        let row = |meshing| measure(Case { meshing, ..Case::sheet(10) }, 15, 1, &ProgressBar::hidden());
        let (ordered, shuffled) = (row(Meshing::Irregular), row(Meshing::Shuffled));
        let falls = ordered.fall_m.zip(shuffled.fall_m);
        assert!(falls.is_some_and(|(a, b)| (a - b).abs() < 1e-3), "{falls:?}");
    }

    #[test]
    fn a_row_is_valid_json() {
        let row = measure(Case::sheet(4), 2, 1, &ProgressBar::hidden());
        let json: serde_json::Value = serde_json::from_str(&serde_json::to_string(&row).unwrap()).unwrap();
        assert_eq!((&json["side"], &json["meshing"]), (&4.into(), &"grid".into()));
        assert!(json["frame_ms"]["median"].as_f64().is_some_and(|ms| ms > 0.0), "{json}");
        assert!(json["fall_m"].is_null(), "{json}");
        assert_eq!(table(&[row]).to_string().lines().count(), 2);
    }
}
