//! What can be chosen about a step. None of it changes the material: only accuracy and cost.

use bevy::reflect::Reflect;
use bevy::reflect::std_traits::ReflectDefault;
use thiserror::Error;

use crate::physics::material::MaterialError;
#[cfg(not(feature = "cholesky"))]
use crate::physics::solve::PreconditionerKind;
use crate::physics::solve::{SolverKind, Target};
use crate::physics::step::Integrator;

/// How a step is solved.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
pub struct SolverSettings {
    /// The time integrator; [`Integrator::Bdf2`] by default.
    pub integrator: Integrator,
    /// The linear solver; conjugate gradients by default, see [`SolverKind::default`].
    pub kind: SolverKind,
    /// Precision of elements, matrix and vectors; positions are always kept in f64. [`Precision::Single`] by default.
    pub precision: Precision,
    /// Implicit steps per call of [`Cloth::step`](crate::physics::Cloth::step), at least 1, which is the default.
    pub substeps: u32,
    /// Linear solves of a step at most, each linearised where the one before led (Newton's method), at least 1. More than one
    /// pays where the cloth turns or wrinkles much in a step; where nothing is left to solve, they end sooner. 1 by default.
    pub newton_steps: u32,
}

/// Precision of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
pub enum Precision {
    /// f32, several elements at a time.
    #[default]
    Single,
    /// f64: the reference.
    Double,
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self {
            integrator: Integrator::default(),
            kind: SolverKind::default(),
            precision: Precision::default(),
            substeps: 1,
            newton_steps: 1,
        }
    }
}

/// A setting that cannot be used.
#[derive(Clone, Copy, Debug, Error, PartialEq, Reflect)]
pub enum SettingsError {
    /// The tolerance is NaN, infinite or negative.
    #[error("the tolerance is {0}: it must be a finite number, not negative, in m/s²")]
    Tolerance(f32),
    /// The relative tolerance is NaN, negative, or 1 or more.
    #[error("the relative tolerance is {0}: it must be at least 0 and below 1")]
    RelativeTolerance(f32),
    /// No iterations are allowed.
    #[error("`max_iterations` is 0: the solver may not even start")]
    NoIterations,
    /// No substeps.
    #[error("`substeps` is 0: it must be at least 1")]
    NoSubsteps,
    /// No Newton steps.
    #[error("`newton_steps` is 0: it must be at least 1")]
    NoNewtonSteps,
}

/// Why there is no cloth of a fabric and settings, see [`Cloth::new`](crate::physics::Cloth::new).
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NewClothError {
    /// A constant of the fabric is invalid.
    #[error("the fabric: {0}")]
    Fabric(#[from] MaterialError),
    /// A setting cannot be used.
    #[error("the settings: {0}")]
    Settings(#[from] SettingsError),
}

impl SolverSettings {
    /// Checks every setting.
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn validate(&self) -> Result<(), SettingsError> {
        if self.substeps == 0 {
            return Err(SettingsError::NoSubsteps);
        }
        if self.newton_steps == 0 {
            return Err(SettingsError::NoNewtonSteps);
        }
        match self.kind {
            SolverKind::ConjugateGradient { tolerance, .. } if !(tolerance.is_finite() && tolerance >= 0.0) => {
                Err(SettingsError::Tolerance(tolerance))
            }
            SolverKind::ConjugateGradient { relative_tolerance, .. } if !(0.0..1.0).contains(&relative_tolerance) => {
                Err(SettingsError::RelativeTolerance(relative_tolerance))
            }
            SolverKind::ConjugateGradient { max_iterations: 0, .. } => Err(SettingsError::NoIterations),
            _ => Ok(()),
        }
    }

    /// Whether an engine made for these settings can take the others: they ask for the same solver in the same precision.
    pub(super) fn same_engine(&self, other: &Self) -> bool {
        self.precision == other.precision
            && match (self.kind, other.kind) {
                (
                    SolverKind::ConjugateGradient { max_iterations: a, preconditioner: p, .. },
                    SolverKind::ConjugateGradient { max_iterations: b, preconditioner: q, .. },
                ) => a == b && p == q,
                #[cfg(feature = "cholesky")]
                (a, b) => a == b,
            }
    }

    /// Where the solver may stop, for a cloth of `mass` (kg) and a step of γ = `gamma` (s).
    pub(crate) fn target(&self, mass: f64, gamma: f64) -> Target {
        match self.kind {
            SolverKind::ConjugateGradient { tolerance, relative_tolerance, .. } => Target {
                absolute: f64::from(tolerance) * gamma * gamma * mass.sqrt(),
                relative: relative_tolerance.into(),
            },
            #[cfg(feature = "cholesky")]
            SolverKind::Cholesky => Target { absolute: 0.0, relative: 0.0 },
        }
    }

    /// The reference: Cholesky in f64 where the feature `cholesky` is on, else conjugate gradients to rounding.
    pub fn reference() -> Self {
        #[cfg(feature = "cholesky")]
        let kind = SolverKind::Cholesky;
        #[cfg(not(feature = "cholesky"))]
        let kind = SolverKind::ConjugateGradient {
            tolerance: 1e-9,
            relative_tolerance: 0.0,
            max_iterations: 100_000,
            preconditioner: PreconditionerKind::Multigrid,
        };
        Self { integrator: Integrator::default(), kind, precision: Precision::Double, substeps: 1, newton_steps: 1 }
    }
}
