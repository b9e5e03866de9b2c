//! How accurately cloths are solved, as components.

use bevy::prelude::*;

use crate::physics::{Quality, SolverSettings};

/// How accurately a cloth is solved, the lower levels first: accuracy and cost, never the look of the material. May change at
/// any time.
///
/// A cloth without this component has the level of [`ClothDefaultQuality`]; one with [`ClothSolver`] has the settings given
/// there instead.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub enum ClothQuality {
    /// [`Quality::Crowd`]: a crowd in the background, stepped in every fourth tick.
    Crowd,
    /// [`Quality::Low`]: beside what the game is about, or on a slow machine: stepped in every second tick.
    Low,
    /// [`Quality::Medium`]: what a cloth has if nothing is chosen.
    #[default]
    Medium,
    /// [`Quality::High`]: a main character.
    High,
    /// [`Quality::Film`]: film.
    Film,
}

impl ClothQuality {
    /// What the level stands for.
    pub const fn settings(self) -> SolverSettings {
        self.level().settings()
    }

    /// Ticks from step to step: see [`Quality::interval`].
    pub const fn interval(self) -> u32 {
        self.level().interval()
    }

    const fn level(self) -> Quality {
        match self {
            Self::Crowd => Quality::Crowd,
            Self::Low => Quality::Low,
            Self::Medium => Quality::Medium,
            Self::High => Quality::High,
            Self::Film => Quality::Film,
        }
    }
}

impl From<ClothQuality> for Quality {
    fn from(quality: ClothQuality) -> Self {
        quality.level()
    }
}

impl From<Quality> for ClothQuality {
    fn from(quality: Quality) -> Self {
        match quality {
            Quality::Crowd => Self::Crowd,
            Quality::Low => Self::Low,
            Quality::Medium => Self::Medium,
            Quality::High => Self::High,
            Quality::Film => Self::Film,
        }
    }
}

/// The quality of every cloth that has neither [`ClothQuality`] nor [`ClothSolver`]: [`ClothQuality::Medium`] by default.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Deref, DerefMut, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct ClothDefaultQuality(pub ClothQuality);

/// Optional: how a cloth is solved, setting by setting, instead of a level of [`ClothQuality`].
///
/// Tolerances, substeps, Newton iterations and the integrator may change at any time, at no cost; another solver,
/// preconditioner or precision is built anew, which takes as long as the cloth took to start.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Deref, DerefMut, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothSolver(pub SolverSettings);

impl From<ClothQuality> for ClothSolver {
    fn from(quality: ClothQuality) -> Self {
        Self(quality.settings())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_those_of_the_physics() {
        for level in Quality::ALL {
            assert_eq!(Quality::from(ClothQuality::from(level)), level);
            assert_eq!(format!("{:?}", ClothQuality::from(level)), format!("{level:?}"));
        }
        assert_eq!(ClothQuality::default(), Quality::default().into());
        assert!(ClothQuality::Crowd < ClothQuality::Film);
    }
}
