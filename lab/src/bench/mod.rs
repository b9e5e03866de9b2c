//! What a frame costs: scene W1, a sheet of 1 m × 1 m that starts flat and horizontal and swings down on two pinned corners.
//!
//! Every row says what a frame takes beside what one product of the same matrix with a vector takes in the same run
//! ([`spmv`]): the ratio holds across machines, and, made of processor time, on a busy one.

pub mod accuracy;
mod case;
pub mod features;
mod options;
pub mod plugin;
pub mod solver;
pub mod spmv;
pub(crate) mod statistics;
pub mod targets;
pub mod terms;

use std::io::Write;
use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressStyle};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

pub use case::Case;
pub use options::{Options, Part};
pub use statistics::Spread;

use crate::contact::drop::{self, Cost};
use crate::report::JsonLines;

/// Vertices along a side of the sheet whose terms are measured.
const TERMS_SIDE: u32 = 64;

/// An object of the JSON file.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Record<'a> {
    Solver(&'a solver::SolverRow),
    Plugin(&'a plugin::PluginRow),
    Accuracy(&'a accuracy::AccuracyRow),
    Term(&'a terms::TermRow),
    Feature(&'a features::FeatureRow),
    Contact(&'a Cost),
    Target(&'a targets::Verdict),
}

/// Measures, and prints tables. The status is 1 if a target is missed and that is to be checked.
///
/// # Errors
/// If the JSON file cannot be written, or no threads can be had.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let mut json = options.json.as_deref().map(JsonLines::create).transpose()?;
    let mut record = |record: Record| json.as_mut().map_or(Ok(()), |json| json.write(&record));
    let (solver_cases, plugin_cases) = (Case::of_solver(options), Case::of_plugin(options));
    let accuracy_cases = Case::of_accuracy(options);
    let (frames, repeat) = (options.frames, options.repeat);
    let with_terms = options.parts.contains(&Part::Terms);
    let timed =
        (solver_cases.len() + plugin_cases.len() + 2 * usize::from(with_terms)) as u64 * u64::from(frames * repeat);
    let progress = progress_bar(timed + accuracy_cases.len() as u64 * accuracy::frames());

    let mut rows = Vec::new();
    for case in solver_cases {
        progress.set_message(case.name());
        let row = pool(case.threads)?.install(|| solver::measure(case, frames, repeat, &progress));
        record(Record::Solver(&row))?;
        rows.push(row);
    }
    let mut plugin_rows = Vec::new();
    for case in plugin_cases {
        progress.set_message(format!("plugin, {}", case.name()));
        let row = pool(case.threads)?.install(|| plugin::measure(case, frames, repeat, &progress));
        record(Record::Plugin(&row))?;
        plugin_rows.push(row);
    }
    let mut accuracy_rows = Vec::new();
    for case in accuracy_cases {
        progress.set_message(format!("accuracy, {}", case.name()));
        let row = pool(case.threads)?.install(|| accuracy::measure(case, case.side == Case::CONVERGED.side, &progress));
        record(Record::Accuracy(&row))?;
        accuracy_rows.push(row);
    }
    let (mut term_rows, mut feature_rows) = (Vec::new(), Vec::new());
    if with_terms {
        progress.set_message("terms");
        let settings = options.quality.settings();
        term_rows = pool(1)?.install(|| terms::measure(TERMS_SIDE, settings, frames, repeat, &progress));
        for row in &term_rows {
            record(Record::Term(row))?;
        }
        let case = Case { quality: options.quality, ..Case::CROWD };
        feature_rows = pool(1)?.install(|| features::measure(case, frames, repeat, &progress));
        for row in &feature_rows {
            record(Record::Feature(row))?;
        }
    }
    let mut contact_rows = Vec::new();
    if options.parts.contains(&Part::Contact) {
        for &side in &options.sizes {
            progress.set_message(format!("contact, {side}²"));
            let row = pool(1)?.install(|| drop::cost(side, drop::FRAMES, repeat));
            record(Record::Contact(&row))?;
            contact_rows.push(row);
        }
    }
    progress.finish_and_clear();

    let verdicts = targets::verdicts(&rows, &plugin_rows, &accuracy_rows);
    for verdict in &verdicts {
        record(Record::Target(verdict))?;
    }
    let tables = [
        (!rows.is_empty()).then(|| solver::table(&rows)),
        (!plugin_rows.is_empty()).then(|| plugin::table(&plugin_rows)),
        (!accuracy_rows.is_empty()).then(|| accuracy::table(&accuracy_rows)),
        (!term_rows.is_empty()).then(|| terms::table(&term_rows)),
        (!feature_rows.is_empty()).then(|| features::table(&feature_rows)),
        (!contact_rows.is_empty()).then(|| drop::table(&contact_rows)),
        (!verdicts.is_empty()).then(|| targets::table(&verdicts)),
    ];
    let mut text = format!("Sheets hung by two corners, {frames} frames of 1/60 s. Times in ms per frame.\n\n");
    text.extend(tables.into_iter().flatten().map(|table| format!("{table}\n")));
    // A reader that closes the pipe has seen enough: the verdict still counts.
    let _ = std::io::stdout().write_all(text.as_bytes());

    let missed = verdicts.iter().any(|verdict| !verdict.met);
    Ok(if options.check && missed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn pool(threads: usize) -> Result<ThreadPool, String> {
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| error.to_string())
}

fn progress_bar(frames: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left  {msg}");
    ProgressBar::new(frames).with_style(style.expect("the template is valid"))
}
