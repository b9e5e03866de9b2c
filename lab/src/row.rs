//! What is wanted of a scene and what came out.

use std::io::Write;
use std::process::ExitCode;

use serde::Serialize;

use crate::report::{Table, figure};

/// What a figure has to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Wanted {
    /// Not more than this.
    AtMost(f64),
    /// Not less than this.
    AtLeast(f64),
    /// From the first to the second.
    Within(f64, f64),
    /// Nothing: it stands there to be read.
    Known,
}

impl Wanted {
    /// As far off a known answer at most, relative to it.
    pub fn near(answer: f64, tolerance: f64) -> Self {
        let off = (tolerance * answer).abs();
        Self::Within(answer - off, answer + off)
    }

    /// Whether a figure is what it has to be. What is not a number never is, unless nothing is wanted.
    fn met_by(self, measured: f64) -> bool {
        match self {
            Self::AtMost(limit) => measured <= limit,
            Self::AtLeast(limit) => measured >= limit,
            Self::Within(low, high) => (low..=high).contains(&measured),
            Self::Known => true,
        }
    }

    fn text(self) -> String {
        match self {
            Self::AtMost(limit) => format!("≤ {}", figure(limit)),
            Self::AtLeast(limit) => format!("≥ {}", figure(limit)),
            Self::Within(low, high) => format!("{} … {}", figure(low), figure(high)),
            Self::Known => "–".into(),
        }
    }
}

/// A judgement of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The scene and its parameters.
    pub scene: String,
    /// What is measured, and in which unit.
    pub what: String,
    /// What came out.
    pub measured: f64,
    /// What is wanted.
    pub wanted: Wanted,
    /// Whether that came out.
    pub met: bool,
}

impl Row {
    /// Judges a figure.
    pub fn new(scene: impl Into<String>, what: impl Into<String>, measured: f64, wanted: Wanted) -> Self {
        Self { scene: scene.into(), what: what.into(), measured, wanted, met: wanted.met_by(measured) }
    }
}

/// The rows for the reader.
pub fn table(rows: &[Row]) -> Table {
    let mut table = Table::new("scene figure measured wanted verdict");
    for row in rows {
        let verdict = match (row.wanted, row.met) {
            (Wanted::Known, _) => "–",
            (_, true) => "met",
            (_, false) => "missed",
        };
        table.row([row.scene.clone(), row.what.clone(), figure(row.measured), row.wanted.text(), verdict.into()]);
    }
    table
}

/// Prints the rows and how many of them miss what is wanted. The status is 1 if one does.
pub fn conclude(rows: &[Row]) -> ExitCode {
    let missed = rows.iter().filter(|row| !row.met).count();
    let text = format!("{}\n{} rows, {missed} miss what is wanted\n", table(rows), rows.len());
    // A reader that closes the pipe has seen enough: the verdict still counts.
    let _ = std::io::stdout().write_all(text.as_bytes());
    if missed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_judged_by_what_is_wanted() {
        let met = |wanted, measured| Row::new("", "", measured, wanted).met;
        assert!(met(Wanted::AtMost(1.0), 1.0) && !met(Wanted::AtMost(1.0), 1.1));
        assert!(met(Wanted::AtLeast(1.0), 1.0) && !met(Wanted::AtLeast(1.0), 0.9));
        assert!(met(Wanted::near(-2.0, 0.1), -1.9) && !met(Wanted::near(-2.0, 0.1), -1.7));
        assert!(!met(Wanted::AtMost(1.0), f64::NAN) && !met(Wanted::AtLeast(1.0), f64::NAN));
        assert!(!met(Wanted::near(1.0, 0.1), f64::NAN) && met(Wanted::Known, f64::NAN));
    }

    #[test]
    fn the_table_says_which_rows_are_judged() {
        let row = |wanted| Row::new("drop 32²", "depth/mm", 2.0, wanted);
        let text = table(&[row(Wanted::AtMost(0.0)), row(Wanted::AtLeast(1.0)), row(Wanted::Known)]).to_string();
        let verdicts: Vec<_> = text.lines().skip(1).map(|line| line.split_whitespace().last().unwrap()).collect();
        assert_eq!(verdicts, ["missed", "met", "–"]);
    }
}
