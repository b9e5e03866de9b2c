//! Does it hold: cloths at the extremes of everything, and beyond.
//!
//! A [`sample`] has the parameters of a run; a [`scene`] lays it out; a [`trial`] steps it, while [`energy`] and [`stillness`]
//! judge it without asking the solver. The [`map`] shows how the time step and the stiffness fare from each start; the
//! [`plugin`] does the same as the core does, as a user would have it.

pub mod energy;
pub mod map;
pub mod plugin;
pub mod sample;
pub mod scene;
pub mod stillness;
pub mod summary;
pub mod survey;
pub mod trial;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use self::summary::Wanted;
use self::survey::Survey;
use crate::plot;
use crate::report::JsonLines;

/// Options of the survey.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Runs drawn at random over all extremes.
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    pub runs: u64,

    /// Runs in each cell of the map of time step and stiffness; without any there is no map.
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub cell_runs: u64,

    /// Of the runs drawn at random, so many are done again in the plugin, each in an app of its own.
    #[arg(long, value_name = "N", default_value_t = 300)]
    pub plugin_runs: u64,

    /// Another seed gives other runs.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,

    /// Do this run alone, and show every step.
    #[arg(long, value_name = "INDEX")]
    pub only: Option<u64>,

    /// Write the runs to FILE, one JSON object a line.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Write the map into this folder.
    #[arg(long, value_name = "DIR", default_value = "out/stability")]
    pub out: PathBuf,
}

/// Surveys, and prints a table. The status is 1 if less than what is wanted comes out.
///
/// # Errors
/// If a file cannot be written, or there is no run of the index asked for.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let survey = Survey { seed: options.seed, cell_runs: options.cell_runs, random_runs: options.runs };
    let mut json = options.json.as_deref().map(JsonLines::create).transpose()?;
    if let Some(index) = options.only {
        return show(&survey.describe(index)?);
    }
    let plugin_runs = options.plugin_runs.min(options.runs);
    let progress = progress_bar(survey.len() + plugin_runs);
    // What panics say is kept with the run.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let runs = survey.run(&progress);
    let in_plugin = plugin::survey(&survey, plugin_runs, &progress);
    std::panic::set_hook(hook);
    progress.finish_and_clear();

    for run in &runs {
        json.as_mut().map_or(Ok(()), |json| json.write(run))?;
    }
    for run in &in_plugin {
        json.as_mut().map_or(Ok(()), |json| json.write(run))?;
    }
    if options.cell_runs > 0 {
        plot::save(&map::Map::new(&runs), &options.out, "stability")?;
    }
    let wanted = [Wanted::of_core(&runs), Wanted::of_plugin(&in_plugin)];
    let text = format!(
        "{}\n{}\n{}",
        summary::table(&runs),
        plugin::table(&in_plugin),
        wanted.iter().map(ToString::to_string).collect::<String>()
    );
    // A reader that closes the pipe has seen enough: the verdict still counts.
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(if wanted.iter().all(Wanted::is_met) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Does a run step by step, and prints all of it.
fn show(run: &survey::Plan) -> Result<ExitCode, String> {
    let mut steps = summary::steps();
    let verdict = trial::run(&run.sample, |moment| summary::add_step(&mut steps, &moment));
    let text = format!("{:#?}\n\n{steps}\n{verdict:#?}\n", run.sample);
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(if verdict.outcome == trial::Outcome::Ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn progress_bar(runs: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs, {eta} left  {msg}");
    ProgressBar::new(runs).with_style(style.expect("the template is valid"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fixed_sample_of_the_extremes_holds() {
        let survey = Survey { seed: 1, cell_runs: 0, random_runs: 400 };
        let runs = survey.run(&ProgressBar::hidden());
        let wanted = Wanted::of_core(&runs);
        // A hundredth is for many runs: of these few, seven stand still.
        assert!(wanted.failed.is_empty() && wanted.frozen <= 8, "{wanted}");
        let in_plugin = plugin::survey(&survey, 20, &ProgressBar::hidden());
        let wanted = Wanted::of_plugin(&in_plugin);
        assert!(wanted.is_met(), "{wanted}");
    }
}
