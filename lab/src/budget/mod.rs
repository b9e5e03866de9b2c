//! Does the budget keep its word: many swaying cloths that need a multiple of it, then a few.
//!
//! The scene runs twice, the second time with a budget of a share of what the first took. Beside the time of frames stands the
//! largest move of any vertex in a frame, against that of the same frames without a budget: a pop would show.

mod phase;
mod scene;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use bevy_cloth::plugin::ClothBudget;
use clap::Args;
use indicatif::ProgressBar;
use rayon::{ThreadPool, ThreadPoolBuilder};

use phase::Recorded;
pub use phase::Row;
pub use scene::Scene;

use crate::report::JsonLines;

/// Options of the budget.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Number of cloths.
    #[arg(long, value_name = "N", default_value_t = 150, value_parser = clap::value_parser!(u32).range(8..=10_000))]
    pub cloths: u32,

    /// Vertices along a side of each.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub side: u32,

    /// How many times the budget the cloths need.
    #[arg(long, value_name = "FACTOR", default_value_t = 3.0, value_parser = load)]
    pub load: f64,

    /// Frames of 1/60 s with the budget before most cloths leave, and again after.
    #[arg(long, value_name = "N", default_value_t = 240, value_parser = clap::value_parser!(u32).range(120..=100_000))]
    pub frames: u32,

    /// Threads [default: as many as there are cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,

    /// Write the rows to FILE, one JSON object a line.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

fn load(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(load) if (1.0..=100.0).contains(&load) => Ok(load),
        _ => Err("must be a number from 1 to 100".into()),
    }
}

/// Frames before the budget comes: the cloths begin to hang.
const WARM_UP: u32 = 120;
/// Frames in which it may find its way.
const ONSET: u32 = 40;

/// Measures, and prints a table. The status is 1 if a row misses what is wanted.
///
/// # Errors
/// If the JSON file cannot be written, or no threads can be had.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let mut json = options.json.as_deref().map(JsonLines::create).transpose()?;
    let rows = pool(options)?.install(|| measure(options));
    for row in &rows {
        json.as_mut().map_or(Ok(()), |json| json.write(row))?;
    }
    let missed = rows.iter().filter(|row| !row.pass).count();
    let text = format!("{}\n{} rows, {missed} miss what is wanted\n", phase::table(&rows), rows.len());
    // A reader that closes the pipe has seen enough: the verdict still counts.
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(if missed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn pool(options: &Options) -> Result<ThreadPool, String> {
    let threads = options.threads.unwrap_or(0) as usize;
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| error.to_string())
}

fn measure(options: &Options) -> Vec<Row> {
    let &Options { cloths, side, load, frames, .. } = options;
    let few = few(cloths, load);
    let phases = [WARM_UP, ONSET, frames - ONSET, ONSET, frames - ONSET];
    let progress = ProgressBar::new(2 * u64::from(phases.iter().sum::<u32>()));
    let mut record = |scene: &mut Scene| {
        let mut next = |frames| Recorded::of(scene, frames, &progress);
        [next(phases[1]), next(phases[2])]
    };
    // Without a budget, then with one from the end of the warm-up on.
    let run = |budget: Option<ClothBudget>, record: &mut dyn FnMut(&mut Scene) -> [Recorded; 2]| {
        let mut scene = Scene::new(cloths as usize, side);
        let warm_up = Recorded::of(&mut scene, WARM_UP, &progress);
        if let Some(budget) = budget {
            scene.app.insert_resource(budget);
        }
        let many = record(&mut scene);
        scene.keep(few);
        (warm_up, many, record(&mut scene))
    };
    let (_, many, few_left) = run(None, &mut record);
    let requested = many[1].mean_ms();
    let budget = requested / load;
    let (warm_up, with_many, with_few) = run(Some(ClothBudget { ms: budget as f32 }), &mut record);
    progress.finish_and_clear();
    // What is shown with long steps is later: its motion may be that of any frame before.
    let largest = many.iter().chain([&warm_up]).map(Recorded::largest_move).fold(0.0, f32::max);
    let [onset, held] = with_many;
    let [relief, recovered] = with_few;
    vec![
        Row::new("onset", requested, budget, &onset, largest).moving(),
        Row::new("held", requested, budget, &held, largest).moving().within(),
        Row::new("relief", few_left[0].mean_ms(), budget, &relief, largest).moving(),
        Row::new("recovered", few_left[1].mean_ms(), budget, &recovered, largest).moving().within().whole(),
    ]
}

/// How many cloths need three quarters of the budget.
fn few(cloths: u32, load: f64) -> usize {
    (0.75 * f64::from(cloths) / load) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_crowd_gives_a_row_for_each_phase() {
        let options = Options { cloths: 12, side: 5, load: 3.0, frames: 120, threads: Some(1), json: None };
        // Threads of its own: in those of all, steps would wait for what other tests do.
        let rows = pool(&options).unwrap().install(|| measure(&options));
        let phases: Vec<_> = rows.iter().map(|row| (row.phase, row.cloths)).collect();
        assert_eq!(phases, [("onset", 12), ("held", 12), ("relief", 3), ("recovered", 3)]);
        for row in rows {
            assert!(row.mean_ms > 0.0 && row.p95_ms > 0.0, "{row:?}");
            assert!((row.requested_ms / row.budget_ms - 3.0).abs() < 1e-9 || row.cloths == 3, "{row:?}");
            assert!(row.jump > 0.0 && row.jump < 3.0, "{row:?}");
        }
    }
}
