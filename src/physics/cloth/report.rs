//! How a step went.

use core::time::Duration;

use bevy::reflect::Reflect;
use thiserror::Error;

use crate::physics::solve::SolveError;

/// How a step went.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepReport {
    /// Whether the cloth moved on.
    pub outcome: StepOutcome,
    /// Substeps that were taken: more than the settings say where something comes in fast.
    pub substeps: u32,
    /// Iterations of the linear solver, all substeps together.
    pub iterations: u32,
    /// Substeps that failed the energy check and were taken again by the fallback.
    pub fallbacks: u32,
    /// Substeps after which velocities were scaled down, so that no energy is gained.
    pub velocity_clamps: u32,
    /// Solves of substeps in which contact was wrong at first.
    pub contact_solves: u32,
    /// Vertices that ended inside a collider and were moved out of it.
    pub rescues: u32,
    /// Time spent on finding contacts.
    pub contact: Duration,
    /// Time spent on A and b.
    pub assembly: Duration,
    /// Time spent on preparing the solver: the preconditioner, or the factorisation.
    pub preconditioner: Duration,
    /// Time spent on solving.
    pub solve: Duration,
    /// Time of the whole step.
    pub total: Duration,
}

/// Whether a step was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepOutcome {
    /// The cloth moved on.
    Accepted,
    /// It stays where it was, at rest.
    Rejected(ClothFault),
}

/// Why a step could not be taken.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq, Reflect)]
#[non_exhaustive]
pub enum ClothFault {
    /// The time step is negative or not a number.
    #[error("the time step is negative or not finite")]
    TimeStep,
    /// The state, a pin target or gravity is not finite, or so large that the forces are not.
    #[error("positions, velocities, pin targets or forces are not finite")]
    NotFinite,
    /// The matrix is not positive definite in the chosen precision.
    #[error("the linear system could not be solved in this precision")]
    Solver,
    /// The linear solver cannot take so many vertices.
    #[error("the cloth has too many vertices for Cholesky: choose `SolverKind::ConjugateGradient`")]
    TooLarge,
}

impl From<SolveError> for ClothFault {
    fn from(error: SolveError) -> Self {
        match error {
            SolveError::NotPositiveDefinite => Self::Solver,
            SolveError::NotFinite => Self::NotFinite,
            SolveError::TooLarge => Self::TooLarge,
        }
    }
}

impl StepReport {
    /// Of a step that has not begun.
    pub(in crate::physics) const NONE: Self = Self {
        outcome: StepOutcome::Accepted,
        substeps: 0,
        iterations: 0,
        fallbacks: 0,
        velocity_clamps: 0,
        contact_solves: 0,
        rescues: 0,
        contact: Duration::ZERO,
        assembly: Duration::ZERO,
        preconditioner: Duration::ZERO,
        solve: Duration::ZERO,
        total: Duration::ZERO,
    };
}
