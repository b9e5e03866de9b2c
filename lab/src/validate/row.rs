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
    /// How far it is off: relative to the known answer, or where that is zero or a range, absolutely.
    pub error: f64,
    /// How far it may be off, likewise.
    pub tolerance: f64,
    /// Whether error and tolerance are relative.
    pub relative: bool,
    /// Whether it is not further off than that.
    pub pass: bool,
}

impl Row {
    /// Compares, relative to the known answer.
    pub fn new(
        case: &'static str,
        parameters: impl Into<String>,
        expected: f64,
        measured: f64,
        tolerance: f64,
    ) -> Self {
        let error = measured / expected - 1.0;
        Self {
            error,
            pass: error.abs() <= tolerance,
            relative: true,
            ..Self::absolute(case, parameters, expected, measured, tolerance)
        }
    }

    /// Compares absolutely.
    pub fn absolute(
        case: &'static str,
        parameters: impl Into<String>,
        expected: f64,
        measured: f64,
        tolerance: f64,
    ) -> Self {
        let error = measured - expected;
        let parameters = parameters.into();
        let pass = error.abs() <= tolerance;
        Self { case, parameters, expected, measured, error, tolerance, relative: false, pass }
    }

    /// Compares with a range.
    pub fn within(case: &'static str, parameters: impl Into<String>, [low, high]: [f64; 2], measured: f64) -> Self {
        Self::absolute(case, parameters, 0.5 * (low + high), measured, 0.5 * (high - low))
    }
}

/// The rows for the reader.
pub fn table(rows: &[Row]) -> Table {
    let mut table = Table::new("case parameters expected measured error tolerance verdict");
    for row in rows {
        let format = |value: f64| if row.relative { percent(value) } else { figure(value) };
        table.row([
            row.case.into(),
            row.parameters.clone(),
            figure(row.expected),
            figure(row.measured),
            format(row.error),
            format(row.tolerance),
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
        let row = |measured| Row::new("length/m", "", 2.0, measured, 0.01);
        assert!(row(2.019).pass && row(1.981).pass);
        assert!(!row(2.021).pass && !row(f64::NAN).pass);
        let range = |measured| Row::within("share", "", [0.2, 0.4], measured);
        assert!(range(0.21).pass && range(0.39).pass && !range(0.19).pass && !range(f64::NAN).pass);
        assert!(Row::absolute("drift", "", 0.0, -1e-7, 1e-6).pass);
        assert_eq!(table(&[row(2.0), range(0.5)]).to_string().lines().count(), 3);
    }
}
