//! What was measured, for the reader and for scripts.

use std::fmt;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;

/// A table of text with aligned columns: the first to the left, the others to the right.
#[derive(Clone, Debug)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// With these headings, one word each.
    pub fn new(headings: &str) -> Self {
        Self { rows: vec![headings.split_whitespace().map(String::from).collect()] }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// If it has not one cell per heading.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let cells: Vec<_> = cells.into_iter().collect();
        assert_eq!(cells.len(), self.rows[0].len(), "one cell per heading");
        self.rows.push(cells);
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = |column: usize| self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<_> = (0..self.rows[0].len()).map(width).collect();
        for row in &self.rows {
            write!(f, "{:<1$}", row[0], widths[0])?;
            for (cell, width) in row.iter().zip(&widths).skip(1) {
                write!(f, "  {cell:>width$}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

/// A file of JSON objects, one a line.
pub struct JsonLines(File);

impl JsonLines {
    /// Creates the file, empty, before anything long starts.
    ///
    /// # Errors
    /// If it cannot be created.
    pub fn create(path: &Path) -> Result<Self, String> {
        File::create(path).map(Self).map_err(|error| format!("cannot write {}: {error}", path.display()))
    }

    /// Adds an object.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&mut self, object: &impl Serialize) -> Result<(), String> {
        let line = serde_json::to_string(object).map_err(io::Error::from);
        line.and_then(|line| writeln!(self.0, "{line}")).map_err(|error| format!("cannot write JSON: {error}"))
    }
}

/// A figure with as many digits as say something.
pub fn figure(value: f64) -> String {
    match value.abs() {
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        v if v >= 1.0 => format!("{value:.2}"),
        v if v >= 1e-3 || v == 0.0 => format!("{value:.3}"),
        _ => format!("{value:.1e}"),
    }
}

/// A share as a percentage.
pub fn percent(share: f64) -> String {
    format!("{} %", figure(100.0 * share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let mut table = Table::new("scene ms");
        table.row(["100²".to_string(), "4.5".to_string()]);
        table.row(["100 × 20²".to_string(), "12.25".to_string()]);
        assert_eq!(table.to_string(), "scene         ms\n100²         4.5\n100 × 20²  12.25\n");
    }

    #[test]
    fn figures_have_three_digits_or_so() {
        assert_eq!([123.4, 12.34, 1.234, 0.1234].map(figure), ["123", "12.3", "1.23", "0.123"]);
        assert_eq!([0.0, 1.26e-4, f64::NAN].map(figure), ["0.000", "1.3e-4", "NaN"]);
        assert_eq!(percent(0.0567), "5.67 %");
    }
}
