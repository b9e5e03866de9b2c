//! What accuracy costs: the work–precision diagram of our solver and of a baseline, XPBD.
//!
//! Every `method` moves the cloth of every `scene`; a `row` says what a frame takes and how far the motion is from the
//! converged one of the `reference`, beside the `noise` below which such differences mean nothing. From the rows come
//! a picture for each scene and size (`plot`), the Pareto `front` of our settings, and the `verdict`.

mod body;
mod cache;
mod errors;
mod front;
mod method;
mod noise;
mod options;
mod plot;
mod reference;
mod row;
mod scene;
mod spaced;
mod verdict;
pub mod xpbd;

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use rayon::ThreadPoolBuilder;
use serde::Serialize;

pub use errors::{Errors, Measure};
pub use method::Family;
pub use options::Options;
pub use row::Row;
pub use scene::Scene;
pub use verdict::Verdict;

use self::cache::Cache;
use self::front::Point;
use self::method::Method;
use self::plot::Diagram;
use self::reference::Reference;
use self::scene::Stage;
use crate::report::JsonLines;

/// An object of the JSON file.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Record<'a> {
    Method(&'a Row),
    Verdict(&'a Verdict),
}

/// Measures, prints tables and draws pictures. The status is 1 if what is wanted is missed.
///
/// # Errors
/// If a file cannot be written, or no thread can be had.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| error.to_string())?;
    pool.install(|| measure(options))
}

fn measure(options: &Options) -> Result<ExitCode, String> {
    let mut json = options.json.as_deref().map(JsonLines::create).transpose()?;
    let mut record = |record: Record| json.as_mut().map_or(Ok(()), |json| json.write(&record));
    let cache = Cache::new(&options.cache)?;
    let methods: Vec<Method> = options.methods.iter().flat_map(|family| family.methods()).collect();
    let count = |&scene: &Scene| methods.iter().filter(|method| scene.is_for(method)).count() as u64;
    let of_a_size: u64 = options.scenes.iter().map(|scene| 2 + row::STEPS * count(scene)).sum();
    let progress = progress_bar(options.sizes.len() as u64 * of_a_size);

    let (mut text, mut verdicts) = (String::new(), Vec::new());
    for (&scene, &side) in options.scenes.iter().flat_map(|scene| options.sizes.iter().map(move |side| (scene, side))) {
        let stage = Stage::new(scene, side);
        progress.set_message(format!("{}: converged motion", stage.name()));
        let reference = Reference::new(&stage, &cache)?;
        progress.inc(1);
        progress.set_message(format!("{}: noise", stage.name()));
        let noise = noise::floor(&stage);
        progress.inc(1);
        let mut rows = Vec::new();
        for method in methods.iter().filter(|method| scene.is_for(method)) {
            progress.set_message(format!("{}: {}, {}", stage.name(), method.family.title(), method.name));
            let row = row::measure(&stage, method, &reference, options.repeat, &progress);
            record(Record::Method(&row))?;
            rows.push(row);
        }
        let rows: Vec<_> = rows.iter().collect();
        for measure in Measure::ALL {
            plot::save(&Diagram::new(&stage, &rows, measure, measure.of(&noise)), &options.out)?;
        }
        text += &format!("{}, noise of the motion {:.2e} m\n{}\n", stage.name(), noise.motion_m, row::table(&rows));
        text += &format!("Pareto front of ours, by motion\n{}\n", row::table(&on_front(&rows)));
        for verdict in verdict::verdicts(&stage, &rows, &noise) {
            record(Record::Verdict(&verdict))?;
            verdicts.push(verdict);
        }
    }
    progress.finish_and_clear();

    if !verdicts.is_empty() {
        text += &format!("{}\n{}\n", verdict::table(&verdicts), verdict::LEGEND);
    }
    // A reader that closes the pipe has seen enough: the verdict still counts.
    let _ = std::io::stdout().write_all(text.as_bytes());
    let missed = verdicts.iter().any(|verdict| verdict.met == Some(false));
    Ok(if missed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Those of our rows that no other of ours beats in cost and error.
fn on_front<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    let point = |row: &Row| Point { cost: row.ms, error: row.errors.motion_m };
    let ours = rows.iter().filter(|row| !row.family.is_baseline());
    let front = front::front(ours.clone().map(|row| point(row)));
    front.iter().filter_map(|&on| ours.clone().find(|row| point(row) == on).copied()).collect()
}

fn progress_bar(steps: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len}, {eta} left  {msg}");
    let progress = ProgressBar::new(steps).with_style(style.expect("the template is valid"));
    progress.enable_steady_tick(Duration::from_millis(500));
    progress
}
