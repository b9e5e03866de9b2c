//! Whether our levels are as much cheaper than the baseline as is wanted.

use serde::Serialize;

use super::errors::{Errors, Measure};
use super::front::{Point, front, gain, least_gain};
use super::method::Family;
use super::row::Row;
use super::scene::{Scene, Stage};
use crate::report::{Table, figure};

/// Largest error that is judged.
const MOST_ERROR: f64 = 5e-2;
/// Times that a level is to be cheaper than the baseline.
const WANTED: f64 = 3.0;
/// Vertices from which on it is judged.
const JUDGED_FROM: usize = 1000;
/// Errors shown.
const SHOWN: [f64; 5] = [5e-2, 3e-2, 2e-2, 1e-2, 5e-3];

/// How our levels and the baseline compare in a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// What was simulated.
    pub scene: Scene,
    /// Vertices along a side.
    pub side: u32,
    /// Vertices.
    pub vertices: usize,
    /// Which errors are compared.
    pub measure: Measure,
    /// Errors below this mean nothing.
    pub noise: f64,
    /// How many times cheaper a level is than the baseline's front at errors of 5e-2, 3e-2, 2e-2, 1e-2 and 5e-3. In JSON `null`
    /// where only levels reach the error, and where nothing does.
    pub gains: [Option<f64>; SHOWN.len()],
    /// The least gain over all errors from 5e-2 down to the noise, and the error where it is; of JSON's `null` the same.
    pub least: Option<(f64, f64)>,
    /// The same against the baseline as it is published.
    pub least_against_published: Option<(f64, f64)>,
    /// The same as the first for all of our methods, not only the levels.
    pub least_of_all: Option<(f64, f64)>,
    /// Whether it is what is wanted; `None` for cloths that are too small to be judged.
    pub met: Option<bool>,
}

/// Compares the rows of a stage in each measure, if there are levels and a baseline.
pub fn verdicts(stage: &Stage, rows: &[&Row], noise: &Errors) -> Vec<Verdict> {
    Measure::ALL.into_iter().filter_map(|measure| verdict(stage, rows, measure, measure.of(noise))).collect()
}

fn verdict(stage: &Stage, rows: &[&Row], measure: Measure, noise: f64) -> Option<Verdict> {
    let of = |which: &dyn Fn(Family) -> bool| {
        let chosen = rows.iter().filter(|row| which(row.family));
        front(chosen.map(|row| Point { cost: row.ms, error: measure.of(&row.errors) }))
    };
    let levels = of(&|family| family == Family::Level);
    let (ours, theirs) = (of(&|family| !family.is_baseline()), of(&Family::is_baseline));
    let published = of(&|family| family == Family::Xpbd);
    if levels.is_empty() || theirs.is_empty() {
        return None;
    }
    let vertices = stage.shape.vertex_count();
    let least = least_gain(&levels, &theirs, MOST_ERROR, noise);
    Some(Verdict {
        scene: stage.scene,
        side: stage.side,
        vertices,
        measure,
        noise,
        gains: SHOWN.map(|error| gain(&levels, &theirs, error).filter(|_| error >= noise)),
        least,
        least_against_published: least_gain(&levels, &published, MOST_ERROR, noise),
        least_of_all: least_gain(&ours, &theirs, MOST_ERROR, noise),
        met: (vertices >= JUDGED_FROM).then(|| least.is_none_or(|(gain, _)| gain >= WANTED)),
    })
}

/// The verdicts for the reader.
pub fn table(verdicts: &[Verdict]) -> Table {
    let mut table =
        Table::new("gain measure noise 5e-2 3e-2 2e-2 1e-2 5e-3 least at published at all-methods at verdict");
    for verdict in verdicts {
        let mut cells = vec![
            format!("{} {}²", verdict.scene.name(), verdict.side),
            verdict.measure.name().into(),
            format!("{:.0e}", verdict.noise),
        ];
        cells.extend(verdict.gains.map(times));
        for least in [verdict.least, verdict.least_against_published, verdict.least_of_all] {
            let (gain, error) = least.unzip();
            cells.extend([times(gain), error.map_or("–".into(), |error| format!("{error:.0e}"))]);
        }
        cells.push(verdict.met.map_or("–", |met| if met { "met" } else { "missed" }).into());
        table.row(cells);
    }
    table
}

fn times(gain: Option<f64>) -> String {
    match gain {
        None => "–".into(),
        Some(gain) if gain.is_infinite() => "∞".into(),
        Some(0.0) => "unreached".into(),
        Some(gain) => format!("{}×", figure(gain)),
    }
}

/// What the columns mean.
pub const LEGEND: &str = "\
Gain: how many times cheaper the cheapest of our levels with no more than this error is than XPBD, whose front is taken as
straight between its points in logarithms. Errors are in m for sheets of 1 m, relative for stretch, and in weights of the sheet
times its side for energy. ∞: XPBD never has so small an error; unreached: XPBD has it, no level of ours; –: neither, or below
the noise. Least: of all errors from 5e-2 down to the noise, against the best XPBD; against XPBD as published; and of all of our
methods. Wanted: 3× at every error of 5e-2 and less, from 1000 vertices on.";

#[cfg(test)]
mod tests {
    use super::*;

    fn row(family: Family, ms: f64, motion_m: f64) -> Row {
        Row {
            scene: Scene::Sheet,
            side: 32,
            vertices: 1024,
            family,
            method: String::new(),
            line: 0,
            ms,
            errors: Errors { motion_m, ..Errors::default() },
        }
    }

    fn judged(rows: &[Row], side: u32) -> Option<Verdict> {
        verdict(&Stage::new(Scene::Sheet, side), &rows.iter().collect::<Vec<_>>(), Measure::Motion, 1e-3)
    }

    #[test]
    fn three_times_cheaper_everywhere_is_met_and_a_gap_is_missed() {
        let xpbd = [row(Family::Xpbd, 1.0, 0.1), row(Family::XpbdTuned, 10.0, 0.01)];
        let with = |levels: &[(f64, f64)]| {
            let mut rows = xpbd.to_vec();
            rows.extend(levels.iter().map(|&(ms, error)| row(Family::Level, ms, error)));
            rows
        };
        let good = judged(&with(&[(0.5, 0.02), (1.0, 0.008)]), 32).unwrap();
        assert_eq!(good.met, Some(true));
        assert!(good.gains[0].is_some_and(|gain| (gain - 4.0).abs() < 1e-9), "{good:?}");
        assert_eq!((good.gains[3], good.gains[4]), (Some(10.0), None));
        assert_eq!(good.least_against_published.map(|(gain, _)| gain), Some(f64::INFINITY));
        // At 50 mm the only level costs half of what the baseline does.
        let dear = judged(&with(&[(1.0, 0.008)]), 32).unwrap();
        assert_eq!(dear.met, Some(false));
        assert!(dear.least.is_some_and(|(gain, at)| (gain - 2.0).abs() < 1e-9 && at == MOST_ERROR));
        // No level reaches 10 mm.
        assert_eq!(judged(&with(&[(0.1, 0.02)]), 32).unwrap().met, Some(false));
        assert!(table(&[good, dear]).to_string().contains("4.00×"));
    }

    #[test]
    fn small_cloths_and_single_sides_are_not_judged() {
        let rows = [row(Family::Level, 1.0, 0.01), row(Family::Xpbd, 1.0, 0.1)];
        assert_eq!(judged(&rows, 20).unwrap().met, None);
        assert!(judged(&rows[..1], 32).is_none());
        assert!(judged(&rows[1..], 32).is_none());
    }
}
