//! Settings by name, from a crowd far away to film.

use core::fmt;

use bevy::reflect::Reflect;

use super::{Integrator, Precision, SolverSettings};
use crate::physics::solve::{PreconditionerKind, SolverKind};

/// How accurately a cloth is solved, the lower levels first.
///
/// A level says nothing about the material: what a cloth stretches, weighs and damps at rest is the same at every level, and
/// changing it in mid-motion builds nothing anew, and no motion is lost.
///
/// Costs and errors are those of `lab trade --scenes sheet --sizes 64` on one core (AMD EPYC 9004): time of a frame of 1/60 s of
/// 4,096 vertices, and root mean square distance from the converged motion of a sheet of 1 m over half a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum Quality {
    /// A crowd in the background: a step in every fourth tick. 0.48 ms, 88 mm.
    Crowd,
    /// Beside what the game is about, or on a slow machine: a step in every second tick. 0.95 ms, 29 mm.
    Low,
    /// What a cloth has if nothing is chosen: a step a tick. 2.1 ms, 9.3 mm.
    #[default]
    Medium,
    /// A main character: two substeps. 4.0 ms, 3.4 mm.
    High,
    /// Film: four substeps, tightly solved. 8.3 ms, 1.2 mm.
    Film,
}

impl Quality {
    /// All levels, the lowest first.
    pub const ALL: [Self; 5] = [Self::Crowd, Self::Low, Self::Medium, Self::High, Self::Film];

    /// What the level stands for.
    pub const fn settings(self) -> SolverSettings {
        // Share of its first residual that motion is solved to; acceleration that rest is solved to, m/s². Looser solves than
        // these leave BDF2 room to gain energy.
        let (relative_tolerance, tolerance, substeps, newton_steps) = match self {
            Self::Crowd | Self::Low => (0.1, 0.005, 1, 1),
            Self::Medium => (0.03, 0.005, 1, 1),
            Self::High => (0.03, 0.005, 2, 1),
            Self::Film => (0.01, 0.005, 4, 1),
        };
        SolverSettings {
            integrator: Integrator::Bdf2,
            kind: SolverKind::ConjugateGradient {
                tolerance,
                relative_tolerance,
                max_iterations: 500,
                preconditioner: PreconditionerKind::Multigrid,
            },
            precision: Precision::Single,
            substeps,
            newton_steps,
        }
    }

    /// Ticks of the game, of 1/60 s or so, from step to step: a step is as many times longer.
    pub const fn interval(self) -> u32 {
        match self {
            Self::Crowd => 4,
            Self::Low => 2,
            Self::Medium | Self::High | Self::Film => 1,
        }
    }

    /// Its name, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Crowd => "crowd",
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
            Self::Film => "film",
        }
    }

    /// The level called `name`; case does not matter.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|level| level.name().eq_ignore_ascii_case(name))
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl From<Quality> for SolverSettings {
    fn from(quality: Quality) -> Self {
        quality.settings()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_usable_distinct_and_in_order() {
        assert_eq!(Quality::default().settings(), SolverSettings::default());
        for (i, level) in Quality::ALL.into_iter().enumerate() {
            assert_eq!(level.settings().validate(), Ok(()));
            assert!(
                !Quality::ALL[..i]
                    .iter()
                    .any(|other| (other.settings(), other.interval()) == (level.settings(), level.interval())),
                "{level}"
            );
            assert!(Quality::ALL[..i].iter().all(|&lower| lower < level));
            assert_eq!(Quality::by_name(&level.name().to_uppercase()), Some(level));
        }
        assert_eq!(Quality::by_name("best"), None);
    }

    #[test]
    fn the_lowest_levels_take_fewer_steps() {
        assert_eq!(Quality::ALL.map(Quality::interval), [4, 2, 1, 1, 1]);
    }

    #[test]
    fn no_level_needs_another_engine() {
        let settings = Quality::ALL.map(Quality::settings);
        assert!(settings.iter().all(|level| level.same_engine(&settings[0])));
    }
}
