//! What each optional feature of the plugin costs: an update with it against an update without any.

use std::time::{Duration, Instant};

use bevy::diagnostic::DiagnosticsPlugin;
use bevy::prelude::*;
use bevy_cloth::plugin::{ClothBudget, ClothDiagnosticsPlugin};
use indicatif::ProgressBar;
use serde::Serialize;

use super::case::Case;
use super::plugin::app;
use super::statistics::median;
use crate::report::{Table, figure};

/// Something that a user may add to an app.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feature {
    /// Nothing.
    None,
    /// `ClothDiagnosticsPlugin`.
    Diagnostics,
    /// `ClothBudget`, so large that nothing is taken away.
    Budget,
}

impl Feature {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::None, Self::Diagnostics, Self::Budget];

    fn name(self) -> &'static str {
        match self {
            Self::None => "plugin alone",
            Self::Diagnostics => "+ diagnostics",
            Self::Budget => "+ budget, unlimited",
        }
    }

    fn app(self, case: Case) -> App {
        let mut app = app(case, |app| match self {
            Self::None => {}
            Self::Diagnostics => {
                app.add_plugins((DiagnosticsPlugin, ClothDiagnosticsPlugin));
            }
            Self::Budget => {
                app.insert_resource(ClothBudget { ms: 1e6 });
            }
        });
        app.update();
        app
    }
}

/// Cost of an update.
#[derive(Clone, Debug, Serialize)]
pub struct FeatureRow {
    /// What there is.
    pub feature: Feature,
    /// The cloths.
    #[serde(flatten)]
    pub case: Case,
    /// Median time of an update, ms.
    pub update_ms: f64,
    /// That over an update without any feature.
    pub ratio: f64,
}

/// Runs apps with each of the features in turns, update by update, so that they find the machine in the same state. Of `repeat`
/// runs the least time of each update counts.
pub fn measure(case: Case, frames: u32, repeat: u32, progress: &ProgressBar) -> Vec<FeatureRow> {
    let mut times = vec![[Duration::MAX; Feature::ALL.len()]; frames as usize];
    for _ in 0..repeat {
        let mut apps = Feature::ALL.map(|feature| feature.app(case));
        for times in &mut times {
            for (app, time) in apps.iter_mut().zip(times) {
                let start = Instant::now();
                app.update();
                *time = (*time).min(start.elapsed());
            }
            progress.inc(1);
        }
    }
    let of = |which: usize| median(&times.iter().map(|times| times[which]).collect::<Vec<_>>());
    let row = |(which, feature)| FeatureRow { feature, case, update_ms: of(which), ratio: of(which) / of(0) };
    Feature::ALL.into_iter().enumerate().map(row).collect()
}

/// The rows for the reader.
pub fn table(rows: &[FeatureRow]) -> Table {
    let mut table = Table::new("feature cloths update/ms against-none");
    for row in rows {
        table.row([
            row.feature.name().into(),
            row.case.name(),
            figure(row.update_ms),
            format!("{:+.1} %", 100.0 * (row.ratio - 1.0)),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_feature_is_compared_with_none() {
        let rows = measure(Case { cloths: 2, ..Case::sheet(6) }, 3, 2, &ProgressBar::hidden());
        assert!(rows.iter().all(|row| row.update_ms > 0.0) && rows[0].ratio == 1.0, "{rows:?}");
        assert_eq!(table(&rows).to_string().lines().count(), 4);
    }
}
