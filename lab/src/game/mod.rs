//! Does cloth hold in a game's hands: moved in any schedule at any frame rate, jumped, turned, paused, scaled, and drawn beside
//! what it touches.
//!
//! Everything runs in an app without a window with the plugin as it comes, and is seen through what is public.

mod curtain;
mod event;
mod frames;
mod jump;
mod lift;
mod runner;
mod scale;
mod stage;
mod vehicle;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::ThreadPoolBuilder;

use crate::report::JsonLines;
use crate::row::{self, Row};

/// Options of game.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Which scenes. Times in `scale` are judged where it is the only one.
    #[arg(long, value_name = "SCENE,…", value_delimiter = ',', value_enum, default_values_t = Scene::value_variants().to_vec())]
    pub only: Vec<Scene>,

    /// One frame rate, one start, a few of the rows: for a look.
    #[arg(long)]
    pub quick: bool,

    /// Write the rows to FILE, one JSON object a line.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// A kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scene {
    /// A cape on a runner that is moved in one schedule or another, at many frame rates.
    Runner,
    /// The same with frames that are not alike.
    Uneven,
    /// A cape on a bone that sways, on a root that stands or runs.
    Sway,
    /// A sheet that lies on a lift.
    Lift,
    /// A curtain and a capsule: what is drawn in what.
    Curtain,
    /// A wearer that turns about, dashes, blinks.
    Jump,
    /// Moved while time stands or the cloth is frozen, hung or held elsewhere, origin shifted.
    Event,
    /// A flag on a vehicle.
    Vehicle,
    /// Scale that is animated.
    Scale,
}

impl Scene {
    fn rows(self, options: &Options) -> Vec<Row> {
        let quick = options.quick;
        match self {
            Self::Runner => runner::even(quick),
            Self::Uneven => runner::uneven(quick),
            Self::Sway => runner::sway(quick),
            Self::Lift => lift::rows(quick),
            Self::Curtain => curtain::rows(quick),
            Self::Jump => jump::rows(quick),
            Self::Event => event::rows(quick),
            Self::Vehicle => vehicle::rows(quick),
            Self::Scale => scale::rows(quick, options.only == [Self::Scale] && !quick),
        }
    }
}

/// Measures, and prints a table. The status is 1 if a row misses what is wanted.
///
/// # Errors
/// If the JSON file cannot be written, or no threads can be had.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let mut json = options.json.as_deref().map(JsonLines::create).transpose()?;
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| error.to_string())?;
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} scenes  {msg}");
    let progress = ProgressBar::new(options.only.len() as u64).with_style(style.expect("the template is valid"));
    let mut rows = Vec::new();
    for &scene in &options.only {
        progress.set_message(format!("{scene:?}").to_lowercase());
        for row in pool.install(|| scene.rows(options)) {
            json.as_mut().map_or(Ok(()), |json| json.write(&row))?;
            rows.push(row);
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(row::conclude(&rows))
}
