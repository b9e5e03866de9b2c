//! Is contact right, and what does it cost: cloths on, around and in the way of solids, each judged by figures.
//!
//! Depths are measured by what the physics does not know: distances of [`solid`]s in closed form, or of parry.

mod absent;
mod body;
mod capstan;
mod coarse;
mod depth;
pub mod drop;
mod fit;
mod impact;
mod machine;
mod rest;
mod runner;
mod slope;
pub mod solid;
mod timing;
mod towel;
mod trial;
mod wrap;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::ThreadPoolBuilder;

pub use crate::row::{Row, Wanted};

use crate::report::JsonLines;
use crate::row;

/// Options of contact.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Which scenes.
    #[arg(long, value_name = "SCENE,…", value_delimiter = ',', value_enum, default_values_t = Scene::value_variants().to_vec())]
    pub only: Vec<Scene>,

    /// Vertices along a side of the sheets that are dropped [default: 32, 64, 100; quick: 16].
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub sizes: Vec<u32>,

    /// Small and short, for a look: costs say little.
    #[arg(long)]
    pub quick: bool,

    /// Write the rows to FILE, one JSON object a line.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// A kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scene {
    /// A sheet dropped on a ball, beside one hung by two corners: cost, depth, rest.
    Drop,
    /// A sheet on a slope stays or slides as Coulomb says.
    Slope,
    /// A towel over a rod stays or slides.
    Towel,
    /// A strip pulled around a rod slides at Euler's ratio of tensions.
    Capstan,
    /// A ball of 50 m/s does not pass through a sheet.
    Ball,
    /// A ball flies into a curtain and takes it along.
    Thrown,
    /// A sheet of 50 m/s does not pass through a wall.
    Wall,
    /// A sheet is crushed to 3 cm.
    Press,
    /// A paddle turns ten times a second in a sheet.
    Paddle,
    /// A belt takes a sheet along.
    Belt,
    /// A sheet falls down stairs.
    Stairs,
    /// A character runs in a cape.
    Runner,
    /// A sheet at rest on a ball, a box, a mesh, a heightfield stays so.
    Rest,
    /// A corner and a rod do not look through a coarse sheet.
    Coarse,
    /// Colliders far away cost nothing.
    Absent,
}

impl Scene {
    fn rows(self, options: &Options) -> Vec<Row> {
        let quick = options.quick;
        let of = |long: f64, short: f64| if quick { short } else { long };
        match self {
            Self::Drop => {
                let frames = if quick { 60 } else { drop::FRAMES };
                let seconds = of(10.0, 5.0);
                options.sizes().into_iter().flat_map(|n| drop::rows(n, frames, seconds)).collect()
            }
            Self::Slope if quick => slope::rows(slope::Floor::HalfSpace, 0.5, 60.0),
            Self::Slope => {
                let mut rows = Vec::new();
                for (floor, friction) in slope::Floor::ALL.iter().flat_map(|f| slope::FRICTIONS.map(|mu| (*f, mu))) {
                    rows.extend(slope::RATES.into_iter().flat_map(|rate| slope::rows(floor, friction, rate)));
                }
                rows
            }
            Self::Towel => towel::rows(of(10.0, 3.0)),
            Self::Capstan if quick => capstan::rows(capstan::CASES[0].0, capstan::CASES[0].1),
            Self::Capstan => capstan::CASES.into_iter().flat_map(|(phi, mu)| capstan::rows(phi, mu)).collect(),
            Self::Ball => impact::Held::ALL.into_iter().flat_map(impact::ball).collect(),
            Self::Thrown => impact::FRICTIONS.into_iter().flat_map(impact::thrown).collect(),
            Self::Wall => impact::Flight::ALL.into_iter().flat_map(impact::wall).collect(),
            Self::Press => machine::press(),
            Self::Paddle => machine::paddle(),
            Self::Belt => slope::Floor::ALL.into_iter().flat_map(machine::belt).collect(),
            Self::Stairs => machine::stairs(),
            Self::Runner => runner::rows(of(4.0, 1.0)),
            Self::Rest => rest::Bed::ALL.into_iter().flat_map(rest::rows).collect(),
            Self::Coarse => coarse::Fine::ALL.into_iter().flat_map(|fine| coarse::rows(fine, of(3.0, 1.0))).collect(),
            Self::Absent if quick => absent::rows(16, 30, 3),
            Self::Absent => absent::rows(64, 120, 5),
        }
    }
}

impl Options {
    fn sizes(&self) -> Vec<u32> {
        match (&self.sizes[..], self.quick) {
            ([], true) => vec![16],
            ([], false) => vec![32, 64, 100],
            (sizes, _) => sizes.to_vec(),
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
