//! One run: a cloth in a scene, step by step, and what became of it.

use std::any::Any;
use std::cmp::Ordering;
use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy_cloth::physics::{Cloth, StepOutcome, StepReport};
use serde::Serialize;

use super::energy::{Account, Accountant, TOLERANCE};
use super::sample::{STEPS, Sample};
use super::scene::Scene;
use super::stillness::Stillness;

/// What became of a run, from good to bad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// As it should be.
    #[default]
    Ok,
    /// It stood still where the reference moves, or a step was rejected.
    Frozen,
    /// It gained energy that nothing gave it.
    GainedEnergy,
    /// A position or velocity was not finite.
    NonFinite,
    /// The library panicked.
    Panic,
}

impl Outcome {
    /// All, from good to bad.
    pub const ALL: [Self; 5] = [Self::Ok, Self::Frozen, Self::GainedEnergy, Self::NonFinite, Self::Panic];

    /// As a heading has it.
    pub fn name(self) -> &'static str {
        ["ok", "frozen", "gained", "non-finite", "panic"][self as usize]
    }
}

/// What became of a run, and how often the safeguard had to act.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verdict {
    /// The worst of it.
    pub outcome: Outcome,
    /// Steps taken, the rejected ones included.
    pub steps: u32,
    /// Substeps taken.
    pub substeps: u32,
    /// Substeps taken by the fallback.
    pub fallbacks: u32,
    /// Fallbacks after which velocities were scaled down.
    pub velocity_clamps: u32,
    /// Steps that were not taken at all.
    pub rejected: u32,
    /// Iterations of the linear solver.
    pub iterations: u64,
    /// Energy gained, at worst, as a share of what was in play.
    pub gain: f64,
    /// What the panic said, or why a step was rejected.
    pub message: Option<String>,
}

/// A step of a run, for those who look on.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// How many there were before.
    pub step: u32,
    /// Its length, s.
    pub dt: f64,
    /// What the library says of it.
    pub report: &'a StepReport,
    /// What the cloth has after it.
    pub account: &'a Account,
    /// Energy gained, as a share of what was in play.
    pub gain: f64,
    /// Whether it concludes a stretch in which the cloth was frozen.
    pub frozen: bool,
}

/// Runs a sample to its end, or until something is not finite.
pub fn run(sample: &Sample, mut look_on: impl FnMut(Moment)) -> Verdict {
    let mut verdict = Verdict::default();
    let result = catch_unwind(AssertUnwindSafe(|| step_through(sample, &mut verdict, &mut look_on)));
    if let Err(panic) = result {
        verdict.outcome = Outcome::Panic;
        verdict.message = Some(message(&*panic));
    }
    verdict
}

/// What a panic says.
pub fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_string());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}

fn step_through(sample: &Sample, verdict: &mut Verdict, look_on: &mut impl FnMut(Moment)) {
    let scene = Scene::new(sample);
    let mut cloth = scene.cloth(sample);
    let mut accountant = Accountant::new(&cloth, scene.free());
    let mut stillness = Stillness::new(sample, &scene, &cloth);
    let mut time = 0.0;
    for step in 0..STEPS {
        let dt = sample.dt_of(step);
        time += dt;
        scene.move_pins(&mut cloth, step, time);
        let work = accountant.work_of_pins(&cloth);
        let report = cloth.step(dt);
        verdict.count(&report, cloth.settings().substeps);
        if !is_finite(&cloth) {
            verdict.outcome = Outcome::NonFinite;
            return;
        }
        let rejected = report.outcome != StepOutcome::Accepted;
        // A rejected step leaves pins where they were.
        let account = accountant.after(&cloth, dt, if rejected { 0.0 } else { work });
        let gain = accountant.gain();
        verdict.gain = verdict.gain.max(gain);
        // Not a number is no less than the tolerance either.
        if !matches!(gain.partial_cmp(&TOLERANCE), Some(Ordering::Less)) {
            verdict.outcome = verdict.outcome.max(Outcome::GainedEnergy);
        }
        let frozen = stillness.is_frozen(&cloth, step + 1, time);
        if frozen || rejected {
            verdict.outcome = verdict.outcome.max(Outcome::Frozen);
        }
        look_on(Moment { step, dt, report: &report, account: &account, gain, frozen });
    }
}

impl Verdict {
    /// Adds a step.
    pub fn count(&mut self, report: &StepReport, substeps: u32) {
        self.steps += 1;
        self.substeps += substeps;
        self.fallbacks += report.fallbacks;
        self.velocity_clamps += report.velocity_clamps;
        self.iterations += u64::from(report.iterations);
        if let StepOutcome::Rejected(fault) = report.outcome {
            self.rejected += 1;
            self.message = Some(fault.to_string());
        }
    }
}

fn is_finite(cloth: &Cloth) -> bool {
    cloth.positions().iter().chain(cloth.velocities()).all(|v| v.is_finite()) && cloth.energy().total().is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::sample::{Start, generator};

    #[test]
    fn a_run_alone_is_the_same_as_among_others() {
        let sample = Sample::random(&mut generator(5, 11));
        let mut moments = 0;
        let first = run(&sample, |_| moments += 1);
        assert_eq!(first, run(&sample, |_| {}));
        assert_eq!((first.steps, moments), (STEPS, STEPS));
    }

    #[test]
    fn an_ordinary_cloth_is_ok() {
        let verdict = run(&Sample::plain(Start::Rest, 1.0 / 60.0, 1000.0, false, 1), |_| {});
        assert_eq!((verdict.outcome, verdict.fallbacks, verdict.rejected), (Outcome::Ok, 0, 0), "{verdict:?}");
    }

    #[test]
    fn a_panic_is_an_outcome() {
        let sample = Sample::plain(Start::Rest, 1.0 / 60.0, 1000.0, false, 1);
        let verdict = run(&sample, |moment| assert!(moment.step < 3, "not further than {}", moment.step));
        assert_eq!((verdict.outcome, verdict.message.as_deref()), (Outcome::Panic, Some("not further than 3")));
    }
}
