//! How it is simulated.

use bevy_cloth::physics::{Integrator, Precision, Quality, SolverKind, SolverSettings};
use clap::ValueEnum;
use serde::Serialize;

use super::xpbd;

/// Methods that differ in one thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Every quality level.
    Level,
    /// BDF2 in so many substeps.
    Bdf2,
    /// BDF2 with a step in one of so many frames.
    Spaced,
    /// Backward Euler in so many substeps.
    Euler,
    /// BDF2 solved to so much of its first residual.
    Tolerance,
    /// BDF2 with so many Newton iterations a step.
    Newton,
    /// BDF2 in f64.
    Double,
    /// BDF2 in f64, solved by Cholesky's factorisation.
    Cholesky,
    /// Extended position-based dynamics in so many substeps, as it is published.
    Xpbd,
    /// The same, over-relaxed and with bending solved rarely.
    XpbdTuned,
    /// The same with the material's damping, in a pass over the velocities.
    XpbdDamped,
    /// As published, with the material's damping in the constraints.
    XpbdEq26,
}

/// A way to simulate.
#[derive(Clone, Debug)]
pub struct Method {
    /// What it is a variant of.
    pub family: Family,
    /// Which of its lines in a picture it belongs to.
    pub line: u32,
    /// Which variant.
    pub name: String,
    /// How.
    pub kind: Kind,
}

/// How a method simulates.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// By our implicit steps.
    Implicit(SolverSettings),
    /// The same, with a step in one of so many frames.
    Spaced(SolverSettings, u32),
    /// By the baseline.
    Xpbd(xpbd::Settings),
}

impl Kind {
    /// As the plugin steps this level in ticks of 1/60 s.
    fn of(quality: Quality) -> Self {
        match quality.interval() {
            1 => Self::Implicit(quality.settings()),
            interval => Self::Spaced(quality.settings(), interval),
        }
    }

    /// Frames from step to step.
    pub const fn interval(self) -> u32 {
        if let Self::Spaced(_, interval) = self { interval } else { 1 }
    }
}

impl Family {
    /// In words.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Level => "our quality levels",
            Self::Bdf2 => "BDF2, 1…8 substeps",
            Self::Spaced => "BDF2, a step in 1…4 frames",
            Self::Euler => "backward Euler, 1…8 substeps",
            Self::Tolerance => "BDF2, tolerance 0.1…0.001",
            Self::Newton => "BDF2, 1…3 Newton iterations",
            Self::Double => "BDF2 in f64",
            Self::Cholesky => "BDF2 by Cholesky in f64",
            Self::Xpbd => "XPBD, 5…320 substeps",
            Self::XpbdTuned => "XPBD, tuned, 5…320",
            Self::XpbdDamped => "XPBD, tuned and damped",
            Self::XpbdEq26 => "XPBD, damped by eq. 26",
        }
    }

    /// Whether it is the baseline.
    pub const fn is_baseline(self) -> bool {
        matches!(self, Self::Xpbd | Self::XpbdTuned | Self::XpbdDamped | Self::XpbdEq26)
    }

    /// All of its methods.
    pub fn methods(self) -> Vec<Method> {
        let method = |line, name: String, kind| Method { family: self, line, name, kind };
        let implicit = |line, name, settings| method(line, name, Kind::Implicit(settings));
        let substeps = |counts: &[u32], base: SolverSettings| -> Vec<Method> {
            let settings = |&substeps: &u32| SolverSettings { substeps, ..base };
            counts.iter().map(|n| implicit(0, format!("{n} substeps"), settings(n))).collect()
        };
        let default = SolverSettings::default();
        match self {
            Self::Level => Quality::ALL.map(|quality| method(0, quality.to_string(), Kind::of(quality))).into(),
            Self::Bdf2 => substeps(&[1, 2, 4, 8], default),
            Self::Spaced => {
                let grid = [2, 4].into_iter().flat_map(|interval| [0.1, 0.03].map(|tolerance| (interval, tolerance)));
                grid.map(|(interval, tolerance)| {
                    let settings = SolverSettings { kind: solved_to(tolerance), ..default };
                    method(interval, format!("{tolerance}, 1 of {interval} frames"), Kind::Spaced(settings, interval))
                })
                .collect()
            }
            Self::Euler => substeps(&[1, 2, 4, 8], SolverSettings { integrator: Integrator::BackwardEuler, ..default }),
            Self::Tolerance => {
                let steps = [1, 2, 4, 8].into_iter().enumerate();
                let grid =
                    steps.flat_map(|(line, n)| [0.1, 0.03, 0.01, 0.001].map(|tolerance| (line as u32, n, tolerance)));
                grid.map(|(line, substeps, tolerance)| {
                    let settings = SolverSettings { substeps, kind: solved_to(tolerance), ..default };
                    implicit(line, format!("{tolerance}, {substeps} substeps"), settings)
                })
                .collect()
            }
            Self::Newton => {
                let steps = [1, 2, 4].into_iter().enumerate();
                let grid = steps.flat_map(|(line, substeps)| [1, 2, 3].map(|newton| (line as u32, substeps, newton)));
                grid.map(|(line, substeps, newton_steps)| {
                    let settings = SolverSettings { substeps, newton_steps, ..default };
                    implicit(line, format!("{newton_steps} iterations, {substeps} substeps"), settings)
                })
                .collect()
            }
            Self::Double => substeps(&[1, 4], SolverSettings { precision: Precision::Double, ..default }),
            // One, as it takes as long as all the others together.
            Self::Cholesky => substeps(&[1], SolverSettings::reference()),
            Self::Xpbd => baseline(self, &SUBSTEPS, xpbd::Settings::published),
            Self::XpbdTuned => baseline(self, &SUBSTEPS, xpbd::Settings::tuned),
            Self::XpbdDamped => {
                let damped = |n| xpbd::Settings { damping: xpbd::Damping::Velocities, ..xpbd::Settings::tuned(n) };
                baseline(self, &SUBSTEPS, damped)
            }
            Self::XpbdEq26 => {
                let damped = |n| xpbd::Settings { damping: xpbd::Damping::Constraints, ..xpbd::Settings::published(n) };
                // More would take as long as all the others together, and still be far off.
                baseline(self, &SUBSTEPS[..5], damped)
            }
        }
    }
}

/// Substeps of the baseline.
const SUBSTEPS: [u32; 7] = [5, 10, 20, 40, 80, 160, 320];

fn baseline(family: Family, substeps: &[u32], settings: impl Fn(u32) -> xpbd::Settings) -> Vec<Method> {
    let kind = |n| Kind::Xpbd(settings(n));
    substeps.iter().map(|&n| Method { family, line: 0, name: format!("{n} substeps"), kind: kind(n) }).collect()
}

/// The default solver with another relative tolerance.
fn solved_to(relative: f32) -> SolverKind {
    let mut kind = SolverKind::default();
    if let SolverKind::ConjugateGradient { relative_tolerance, .. } = &mut kind {
        *relative_tolerance = relative;
    }
    kind
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_family_has_valid_methods_of_different_names() {
        for family in Family::value_variants() {
            let methods = family.methods();
            assert!(!methods.is_empty(), "{family:?}");
            for (i, method) in methods.iter().enumerate() {
                assert!(methods[..i].iter().all(|other| other.name != method.name), "{}", method.name);
                match method.kind {
                    Kind::Implicit(settings) | Kind::Spaced(settings, _) => assert_eq!(settings.validate(), Ok(())),
                    Kind::Xpbd(settings) => assert!(settings.substeps >= 5),
                }
            }
        }
    }
}
