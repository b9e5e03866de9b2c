//! Whether our levels are as much cheaper than the baseline as is wanted.

use serde::Serialize;

use super::front::{Point, front, gain, least_gain};
use super::method::Family;
use super::row::Row;
use super::scene::{Scene, Stage};
use crate::report::{Table, figure};

/// Largest error that is judged, m.
const MOST_ERROR: f64 = 5e-2;
/// Times that a level is to be cheaper than the baseline.
const WANTED: f64 = 3.0;
/// Vertices from which on it is judged.
const JUDGED_FROM: usize = 1000;
/// Errors shown, m.
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
    /// Errors below this mean nothing, m.
    pub noise_m: f64,
    /// How many times cheaper a level is than the baseline's front at 50, 30, 20, 10 and 5 mm. In JSON `null` where only levels
    /// reach the error, and where nothing does.
    pub gains: [Option<f64>; SHOWN.len()],
    /// The least gain over all errors from 50 mm down to the noise, and the error where it is, m; of JSON's `null` the same.
    pub least: Option<(f64, f64)>,
    /// The same for all of our methods, not only the levels.
    pub least_of_all: Option<(f64, f64)>,
    /// Whether it is what is wanted; `None` for cloths that are too small to be judged.
    pub met: Option<bool>,
}

/// Compares the rows of a stage, if there are levels and a baseline.
pub fn verdict(stage: &Stage, rows: &[&Row], noise: f64) -> Option<Verdict> {
    let of = |which: &dyn Fn(Family) -> bool| {
        let chosen = rows.iter().filter(|row| which(row.family));
        front(chosen.map(|row| Point { cost: row.ms, error: row.error_m }))
    };
    let levels = of(&|family| family == Family::Level);
    let (ours, theirs) = (of(&|family| !family.is_baseline()), of(&Family::is_baseline));
    if levels.is_empty() || theirs.is_empty() {
        return None;
    }
    let vertices = stage.shape.vertex_count();
    let least = least_gain(&levels, &theirs, MOST_ERROR, noise);
    Some(Verdict {
        scene: stage.scene,
        side: stage.side,
        vertices,
        noise_m: noise,
        gains: SHOWN.map(|error| gain(&levels, &theirs, error).filter(|_| error >= noise)),
        least,
        least_of_all: least_gain(&ours, &theirs, MOST_ERROR, noise),
        met: (vertices >= JUDGED_FROM).then(|| least.is_none_or(|(gain, _)| gain >= WANTED)),
    })
}

/// The verdicts for the reader.
pub fn table(verdicts: &[Verdict]) -> Table {
    let mut table = Table::new("gain noise/mm 50-mm 30-mm 20-mm 10-mm 5-mm least at/mm all-methods at/mm verdict");
    for verdict in verdicts {
        let pair = |least: Option<(f64, f64)>| {
            let (gain, error) = least.unzip();
            [times(gain), error.map_or("–".into(), |error| figure(1e3 * error))]
        };
        let mut cells = vec![format!("{} {}²", verdict.scene.name(), verdict.side), figure(1e3 * verdict.noise_m)];
        cells.extend(verdict.gains.map(times));
        cells.extend(pair(verdict.least));
        cells.extend(pair(verdict.least_of_all));
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
straight between its points in logarithms. ∞: XPBD never has so small an error; unreached: XPBD has it, no level of ours;
–: neither, or below the noise. Wanted: 3× at every error of 50 mm and less, from 1000 vertices on.";

#[cfg(test)]
mod tests {
    use super::*;

    fn row(family: Family, ms: f64, error_m: f64) -> Row {
        Row {
            scene: Scene::Sheet,
            side: 32,
            vertices: 1024,
            family,
            method: String::new(),
            line: 0,
            ms,
            error_m,
            settled_m: 0.0,
            stretch_error: 0.0,
            energy_error: 0.0,
        }
    }

    fn judged(rows: &[Row], side: u32) -> Option<Verdict> {
        verdict(&Stage::new(Scene::Sheet, side), &rows.iter().collect::<Vec<_>>(), 1e-3)
    }

    #[test]
    fn three_times_cheaper_everywhere_is_met_and_a_gap_is_missed() {
        let xpbd = [row(Family::Xpbd, 1.0, 0.1), row(Family::XpbdDamped, 10.0, 0.01)];
        let with = |levels: &[(f64, f64)]| {
            let mut rows = xpbd.to_vec();
            rows.extend(levels.iter().map(|&(ms, error)| row(Family::Level, ms, error)));
            rows
        };
        let good = judged(&with(&[(0.5, 0.02), (1.0, 0.008)]), 32).unwrap();
        assert_eq!(good.met, Some(true));
        assert!(good.gains[0].is_some_and(|gain| (gain - 4.0).abs() < 1e-9), "{good:?}");
        assert_eq!((good.gains[3], good.gains[4]), (Some(10.0), None));
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
