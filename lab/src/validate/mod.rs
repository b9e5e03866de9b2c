//! Is it right? Cloths with an answer that is known without us.

mod bending;
mod convergence;
mod damping;
mod drape;
mod hanging;
mod motion;
mod plot;
mod row;
mod string;
pub(crate) mod strip;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use indicatif::ProgressBar;

pub use row::Row;

use crate::plot::save;
use crate::report::JsonLines;

/// Options of the validation.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// What to validate.
    #[arg(long, value_name = "CASE,…", value_delimiter = ',', value_enum, default_values_t = Case::value_variants().to_vec())]
    pub cases: Vec<Case>,

    /// Write the rows to FILE, one JSON object a line.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Draw how far off each row is into DIR.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A kind of known answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Case {
    /// A stretched sheet whose sides are free pulls with the same force on any mesh.
    Patch,
    /// A sheet hung by its top edge stretches under its weight, the same for every mesh and time step.
    Stretch,
    /// A sheet bent to a cylinder has the rigidity asked for, in every direction on every mesh.
    Rigidity,
    /// A heavy strip clamped at one end bends as the elastica.
    Cantilever,
    /// A strip on edge gives way sideways under the right weight.
    Buckling,
    /// A strip held by both ends hangs in a catenary.
    Catenary,
    /// A hanging strip swings at its natural frequencies.
    Swing,
    /// A stretched strip vibrates as a string.
    String,
    /// A clamped strip vibrates as a beam.
    Vibration,
    /// Integrators and material damp as they should.
    Damping,
    /// A free sheet keeps spinning.
    Spin,
    /// A free sheet keeps its momentum.
    Momentum,
    /// A swinging sheet gains no energy.
    Energy,
    /// A disc of fabric drapes as on Cusick's drapemeter.
    Drape,
    /// Errors fall as they should when mesh and step are refined.
    Convergence,
}

impl Case {
    fn rows(self) -> Vec<Row> {
        match self {
            Self::Patch => hanging::patch(),
            Self::Stretch => hanging::stretch(),
            Self::Rigidity => bending::rigidity(),
            Self::Cantilever => bending::cantilever(),
            Self::Buckling => bending::buckling(),
            Self::Catenary => hanging::catenary(),
            Self::Swing => motion::swing(),
            Self::String => string::string(),
            Self::Vibration => motion::vibration(),
            Self::Damping => damping::damping(),
            Self::Spin => motion::spin(),
            Self::Momentum => motion::momentum(),
            Self::Energy => motion::energy(),
            Self::Drape => drape::drape(),
            Self::Convergence => convergence::convergence(),
        }
    }
}

/// Validates, and prints a table. The status is 1 if a row is off by more than its tolerance.
///
/// # Errors
/// If the JSON file or the picture cannot be written.
pub fn run(options: &Options) -> Result<ExitCode, String> {
    let mut json = options.json.as_deref().map(JsonLines::create).transpose()?;
    let progress = ProgressBar::new(options.cases.len() as u64);
    let mut rows = Vec::new();
    for case in &options.cases {
        for row in case.rows() {
            json.as_mut().map_or(Ok(()), |json| json.write(&row))?;
            rows.push(row);
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    if let Some(out) = &options.out {
        save(&plot::Errors(&rows), out, "validate")?;
    }
    let failed = rows.iter().filter(|row| !row.pass).count();
    let text = format!("{}\n{} rows, {failed} off by more than their tolerance\n", row::table(&rows), rows.len());
    // A reader that closes the pipe has seen enough: the verdict still counts.
    let _ = std::io::stdout().write_all(text.as_bytes());
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_answer_is_right() {
        for case in Case::value_variants() {
            for row in case.rows() {
                assert!(row.pass, "{row:?}");
            }
        }
    }
}
