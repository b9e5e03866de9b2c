//! What the command line chooses.

use std::path::PathBuf;

use bevy_cloth::physics::Quality;
use clap::{Args, ValueEnum};

use crate::quality;

/// Options of the bench.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Vertices along a side of the sheets.
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_values_t = [20, 32, 64, 100, 141, 200],
          value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub sizes: Vec<u32>,

    /// What to measure.
    #[arg(long, value_name = "PART,…", value_delimiter = ',', value_enum, default_values_t = Part::ALL)]
    pub parts: Vec<Part>,

    /// Threads of the rows that have several; beside each stands the same on one [default: 2, or 1 on a machine of one
    /// core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,

    /// How well the cloths are solved. The targets are for the default.
    #[arg(long, value_name = "NAME", default_value_t, value_parser = quality::parser())]
    pub quality: Quality,

    /// Frames of 1/60 s.
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,

    /// Run each scene N times, which gives the same frames, and take the least time of each frame: for a machine that
    /// does other things too.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub repeat: u32,

    /// Write the rows and targets to FILE, one JSON object a line.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Exit with status 1 if a target is missed.
    #[arg(long)]
    pub check: bool,
}

/// A group of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// The hung sheet in every size, on one thread.
    Sheets,
    /// The sheet of 100² on several threads.
    Threads,
    /// 100 sheets of 20², side by side.
    Crowd,
    /// Irregular meshes of 100², in good order and in none.
    Irregular,
    /// The whole plugin in an app without a window.
    Plugin,
    /// Error and stretch of the default step against converged ones, in every size.
    Accuracy,
    /// What each optional term of the model and each optional feature of the plugin costs.
    Terms,
    /// The sheet dropped on a ball (scene W2) beside the hung one, at the default quality, on one thread, in every size.
    Contact,
}

impl Part {
    const ALL: [Self; 8] = [
        Self::Sheets,
        Self::Threads,
        Self::Crowd,
        Self::Irregular,
        Self::Plugin,
        Self::Accuracy,
        Self::Terms,
        Self::Contact,
    ];
}

impl Options {
    /// See [`Options::threads`].
    pub fn thread_count(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
        self.threads.map_or(cores.min(2), |threads| threads as usize)
    }
}
