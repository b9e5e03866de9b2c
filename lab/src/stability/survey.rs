//! All runs: first those of the map, then those drawn at random.

use indicatif::ProgressBar;
use rand::Rng;
use rayon::prelude::*;
use serde::Serialize;

use super::sample::{Sample, Start, generator};
use super::trial::{self, Verdict};

/// Time steps of the map, by their logarithm to the base of ten, s.
pub const DT_DECADES: [f64; 13] = decades::<13>(-3.0, 0.25);
/// Stiffnesses of the map, by their logarithm to the base of ten, N/m.
pub const STIFFNESS_DECADES: [f64; 13] = decades::<13>(-3.0, 1.0);

const fn decades<const N: usize>(from: f64, by: f64) -> [f64; N] {
    let mut decades = [from; N];
    let mut i = 0;
    while i < N {
        decades[i] = from + by * i as f64;
        i += 1;
    }
    decades
}

/// Which runs there are.
#[derive(Clone, Copy, Debug)]
pub struct Survey {
    /// Seed of all of them.
    pub seed: u64,
    /// Runs in each cell of the map.
    pub cell_runs: u64,
    /// Runs drawn at random.
    pub random_runs: u64,
}

/// A cell of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Cell {
    /// Which of [`Start::HARDEST`].
    pub start: usize,
    /// Which of [`DT_DECADES`].
    pub dt: usize,
    /// Which of [`STIFFNESS_DECADES`].
    pub stiffness: usize,
}

/// A run to do.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// Its number.
    pub index: u64,
    /// Its cell, if it is one of the map.
    pub cell: Option<Cell>,
    /// Its parameters.
    pub sample: Sample,
}

/// A run done.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// What was done.
    #[serde(flatten)]
    pub plan: Plan,
    /// What became of it.
    #[serde(flatten)]
    pub verdict: Verdict,
}

impl Survey {
    /// Number of runs.
    pub fn len(&self) -> u64 {
        self.map_len() + self.random_runs
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn map_len(&self) -> u64 {
        (Start::HARDEST.len() * DT_DECADES.len() * STIFFNESS_DECADES.len()) as u64 * self.cell_runs
    }

    /// The run of this number.
    ///
    /// # Errors
    /// If there is none.
    pub fn describe(&self, index: u64) -> Result<Plan, String> {
        if index >= self.len() {
            return Err(format!("there is no run {index}: the last is {}", self.len().saturating_sub(1)));
        }
        Ok(self.plan(index))
    }

    fn plan(&self, index: u64) -> Plan {
        // Runs drawn at random are the same however many the map has.
        let Some(drawn) = index.checked_sub(self.map_len()) else { return self.plan_of_map(index) };
        Plan { index, cell: None, sample: Sample::random(&mut generator(self.seed, drawn)) }
    }

    fn plan_of_map(&self, index: u64) -> Plan {
        let (cell, repeat) = ((index / self.cell_runs) as usize, index % self.cell_runs);
        let (column, start) = (cell / STIFFNESS_DECADES.len(), cell / STIFFNESS_DECADES.len() / DT_DECADES.len());
        let cell = Cell { start, dt: column % DT_DECADES.len(), stiffness: cell % STIFFNESS_DECADES.len() };
        let [dt, stiffness] = [DT_DECADES[cell.dt], STIFFNESS_DECADES[cell.stiffness]].map(|d| 10_f64.powf(d));
        let detail = generator(!self.seed, index).random();
        // Either integrator has half of the runs.
        let sample = Sample::plain(Start::HARDEST[start], dt, stiffness, repeat % 2 == 1, detail);
        Plan { index, cell: Some(cell), sample }
    }

    /// The first runs that are drawn at random.
    pub fn random(&self, runs: u64) -> Vec<Plan> {
        let first = self.map_len();
        (first..first + runs).map(|index| self.plan(index)).collect()
    }

    /// Does all runs, in order, side by side.
    pub fn run(&self, progress: &ProgressBar) -> Vec<Run> {
        let runs = (0..self.len() as usize).into_par_iter().map(|index| {
            let plan = self.plan(index as u64);
            let verdict = trial::run(&plan.sample, |_| {});
            progress.inc(1);
            Run { plan, verdict }
        });
        runs.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_has_its_runs_and_the_rest_is_random() {
        let survey = Survey { seed: 1, cell_runs: 2, random_runs: 5 };
        assert_eq!(survey.len(), 6 * 13 * 13 * 2 + 5);
        let plans: Vec<_> = (0..survey.len()).map(|index| survey.describe(index).expect("a run")).collect();
        let corner = Cell { start: 5, dt: 12, stiffness: 0 };
        let there: Vec<_> = plans.iter().filter(|plan| plan.cell == Some(corner)).collect();
        assert_eq!(there.len(), 2);
        let sample = &there[0].sample;
        assert_eq!((sample.dt, sample.stiffness, sample.start), (1.0, 1e-3, Start::HARDEST[5]));
        assert!(there[0].sample.backward_euler != there[1].sample.backward_euler);
        assert_eq!(plans.iter().filter(|plan| plan.cell.is_none()).count(), 5);
        assert!(survey.describe(survey.len()).is_err());
        let without_map = Survey { cell_runs: 0, ..survey };
        assert_eq!(without_map.describe(3).expect("a run").sample, plans[plans.len() - 2].sample);
    }
}
