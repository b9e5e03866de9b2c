//! How well the systems of a row are solved.

use bevy_cloth::physics::{SolverKind, SolverSettings};
use clap::ValueEnum;
use serde::Serialize;

/// Settings by name. None of them changes the material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// Motion solved to a tenth of its first residual, rest to 20 mm/s².
    Quick,
    /// What a cloth has if nothing is chosen.
    #[default]
    Default,
    /// Two substeps.
    Fine,
    /// Four substeps, each solved to a hundredth of its first residual.
    Finest,
}

impl Quality {
    /// The settings.
    pub fn settings(self) -> SolverSettings {
        let default = SolverSettings::default();
        let solved_to = |relative: f32, absolute: f32| {
            let mut kind = default.kind;
            if let SolverKind::ConjugateGradient { relative_tolerance, tolerance, .. } = &mut kind {
                (*relative_tolerance, *tolerance) = (relative, absolute);
            }
            kind
        };
        match self {
            Self::Quick => SolverSettings { kind: solved_to(0.1, 0.02), ..default },
            Self::Default => default,
            Self::Fine => SolverSettings { substeps: 2, ..default },
            Self::Finest => SolverSettings { kind: solved_to(0.01, 0.005), substeps: 4, ..default },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quality_is_usable_and_another() {
        let settings: Vec<_> = Quality::value_variants().iter().map(|quality| quality.settings()).collect();
        for (i, a) in settings.iter().enumerate() {
            assert_eq!(a.validate(), Ok(()));
            assert!(!settings[..i].contains(a), "{a:?}");
        }
    }
}
