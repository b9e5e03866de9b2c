//! What the command line chooses.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::method::Family;
use super::scene::Scene;

/// Options of the trade.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// What is simulated.
    #[arg(long, value_name = "SCENE,…", value_delimiter = ',', value_enum, default_values_t = Scene::value_variants().to_vec())]
    pub scenes: Vec<Scene>,

    /// Vertices along a side of the sheets.
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_values_t = [20, 32, 64, 100, 141],
          value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub sizes: Vec<u32>,

    /// How it is simulated. What is wanted is judged only if both the levels and XPBD are among them.
    #[arg(long, value_name = "FAMILY,…", value_delimiter = ',', value_enum, default_values_t = Family::value_variants().to_vec())]
    pub methods: Vec<Family>,

    /// Run each method N times and take the least time of each frame: for a machine that does other things too.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub repeat: u32,

    /// Folder of converged motions, which take long and depend on no method.
    #[arg(long, value_name = "DIR", default_value = "target/lab-cache")]
    pub cache: PathBuf,

    /// Write the rows to FILE, one JSON object a line.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Folder of the pictures.
    #[arg(long, value_name = "DIR", default_value = "out/trade")]
    pub out: PathBuf,
}
