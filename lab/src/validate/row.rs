//! What was expected and what came out.

use serde::Serialize;

use crate::report::{Table, figure, percent};

/// A known answer and ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What is validated, and in which unit.
    pub case: &'static str,
    /// For which parameters.
    pub parameters: String,
    /// The known answer.
    pub expected: f64,
    /// Ours.
    pub measured: f64,
    /// How far it is off, relative to the known answer.
    pub error: f64,
    /// How far it may be off.
    pub tolerance: f64,
    /// Whether it is not further off than that.
    pub pass: bool,
}

impl Row {
    /// Compares.
    pub fn new(case: &'static str, parameters: String, expected: f64, measured: f64, tolerance: f64) -> Self {
        let error = measured / expected - 1.0;
        Self { case, parameters, expected, measured, error, tolerance, pass: error.abs() <= tolerance }
    }
}

/// The rows for the reader.
pub fn table(rows: &[Row]) -> Table {
    let mut table = Table::new("case parameters expected measured error tolerance verdict");
    for row in rows {
        table.row([
            row.case.into(),
            row.parameters.clone(),
            figure(row.expected),
            figure(row.measured),
            percent(row.error),
            percent(row.tolerance),
            if row.pass { "right" } else { "off" }.into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_right_within_their_tolerance_only() {
        let row = |measured| Row::new("length/m", String::new(), 2.0, measured, 0.01);
        assert!(row(2.019).pass && row(1.981).pass);
        assert!(!row(2.021).pass && !row(f64::NAN).pass);
        assert_eq!(table(&[row(2.0)]).to_string().lines().count(), 2);
    }
}
