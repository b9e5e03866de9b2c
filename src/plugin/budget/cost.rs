//! What a step of a cloth will cost, from what steps have cost.

use super::rung::{RUNGS, Rung};

/// Time of a step per vertex at [`ClothQuality::Medium`](crate::plugin::ClothQuality::Medium) before any was measured, s: a
/// guess, forgotten with the first measurement.
const PER_VERTEX: f64 = 1e-6;
/// Work of a step on each rung before any was measured, relative to the default: a guess. Longer steps take more iterations.
const WORK: [f64; RUNGS] = [4.1, 2.0, 1.0, 0.95, 1.0, 1.1];
/// Weight of the latest step in an average, at least.
const LATEST: f64 = 0.125;
/// A step that took this many times the average so far counts as so many only: other programs run too.
const OUTLIER: f64 = 2.0;
/// Steps after which the average on a rung says something about the work there.
const TELLING: u32 = 8;
/// How far work is corrected by what one cloth experienced, as a share of the logarithm.
const CORRECTION: f64 = 0.1;
/// Largest factor that one cloth's experience counts for.
const MOST: f64 = 2.0;

/// What is known of all cloths together.
#[derive(Clone, Debug)]
pub(super) struct CostModel {
    /// Work of a step on each rung, relative to the others.
    work: [f64; RUNGS],
    /// Time of a step per vertex and unit of work, s.
    per_vertex: f64,
    measured: bool,
}

impl Default for CostModel {
    fn default() -> Self {
        Self { work: WORK, per_vertex: PER_VERTEX, measured: false }
    }
}

/// What is known of one cloth: the average time of a step on the rung where it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::plugin) struct Cost {
    /// s; of no meaning before the first sample.
    seconds: f64,
    rung: usize,
    /// Steps in the average, and those of them on this rung.
    samples: u32,
    here: u32,
    /// The rung before, and the average there.
    before: Option<(usize, f64)>,
}

impl CostModel {
    /// Takes note of a step of a cloth of so many vertices on `rung`.
    pub fn observe(&mut self, cost: &mut Cost, vertices: usize, rung: Rung, seconds: f64) {
        if cost.samples > 0 && cost.rung != rung.0 {
            // Until this rung has been measured, what is known of the work there must do.
            let before = (cost.here >= TELLING).then_some((cost.rung, cost.seconds));
            *cost = Cost { seconds: self.of(cost, vertices, rung), rung: rung.0, here: 0, before, ..*cost };
        }
        cost.rung = rung.0;
        let known = if cost.samples == 0 { seconds } else { cost.seconds };
        let weight = (1.0 / f64::from(cost.here + 1)).max(LATEST);
        // The first step on a rung is weighed as one of a few: it may be the odd one.
        let weight = if cost.samples > 0 { weight.min(0.5) } else { 1.0 };
        cost.seconds = known + weight * (seconds.min(OUTLIER * known) - known);
        cost.samples = cost.samples.saturating_add(1);
        cost.here = cost.here.saturating_add(1);

        let rate = cost.seconds / (vertices.max(1) as f64 * self.work[rung.0]);
        let weight = if self.measured { 0.01 } else { 1.0 };
        self.per_vertex += weight * (rate - self.per_vertex);
        self.measured = true;
        if cost.here == TELLING
            && let Some((before, seconds)) = cost.before
        {
            self.learn(before, seconds, rung.0, cost.seconds);
        }
    }

    /// A cloth took `seconds_a` on rung a, then `seconds_b` on rung b.
    fn learn(&mut self, a: usize, seconds_a: f64, b: usize, seconds_b: f64) {
        let off = (seconds_b / seconds_a / (self.work[b] / self.work[a])).clamp(1.0 / MOST, MOST);
        if off.is_finite() {
            let half = off.powf(0.5 * CORRECTION);
            self.work[b] *= half;
            self.work[a] /= half;
        }
    }

    /// Time of a step on a rung, s.
    pub fn of(&self, cost: &Cost, vertices: usize, rung: Rung) -> f64 {
        if cost.samples == 0 {
            self.per_vertex * vertices as f64 * self.work[rung.0]
        } else {
            cost.seconds * self.work[rung.0] / self.work[cost.rung]
        }
    }

    /// Time per tick on each rung, s.
    pub fn per_tick(&self, cost: &Cost, vertices: usize) -> [f64; RUNGS] {
        core::array::from_fn(|rung| self.of(cost, vertices, Rung(rung)) / f64::from(Rung(rung).interval()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEDIUM: Rung = Rung(2);

    #[test]
    fn a_cloth_never_measured_costs_what_others_do_per_vertex() {
        let (mut model, mut cost) = (CostModel::default(), Cost::default());
        for _ in 0..20 {
            model.observe(&mut cost, 1000, MEDIUM, 2e-3);
        }
        assert!((model.of(&cost, 1000, MEDIUM) - 2e-3).abs() < 1e-12);
        assert!((model.of(&Cost::default(), 500, MEDIUM) - 1e-3).abs() < 1e-12);
        // On other rungs, in proportion to the work there; per tick, spread over the ticks.
        let lowest = model.of(&cost, 1000, Rung::LOWEST);
        assert!((lowest / 2e-3 - WORK[RUNGS - 1]).abs() < 1e-9);
        assert_eq!(model.per_tick(&cost, 1000)[RUNGS - 1], lowest / 8.0);
    }

    #[test]
    fn an_outlier_hardly_counts_and_a_lasting_change_does() {
        let (mut model, mut cost) = (CostModel::default(), Cost::default());
        for _ in 0..20 {
            model.observe(&mut cost, 100, MEDIUM, 1e-3);
        }
        model.observe(&mut cost, 100, MEDIUM, 1.0);
        assert!(model.of(&cost, 100, MEDIUM) < 1.2e-3);
        for _ in 0..60 {
            model.observe(&mut cost, 100, MEDIUM, 5e-3);
        }
        assert!((model.of(&cost, 100, MEDIUM) / 5e-3 - 1.0).abs() < 0.01);
    }

    #[test]
    fn the_work_on_a_rung_is_learnt_from_cloths_that_went_there() {
        let mut model = CostModel::default();
        // Truly, the lower rung costs half.
        for _ in 0..60 {
            let mut cost = Cost::default();
            for (rung, seconds) in [(MEDIUM, 1e-3), (Rung(3), 0.5e-3)] {
                for _ in 0..10 {
                    model.observe(&mut cost, 100, rung, seconds);
                }
            }
        }
        let mut cost = Cost::default();
        model.observe(&mut cost, 100, MEDIUM, 4e-3);
        assert!((model.of(&cost, 100, Rung(3)) / 2e-3 - 1.0).abs() < 0.1, "{:?}", model.work);
    }
}
