//! Solvers of the symmetric positive definite system A d = b.
//!
//! A new solver implements [`LinearSolver`] and gets a variant of [`SolverKind`]; a new preconditioner implements
//! [`Preconditioner`]. Neither knows what the matrix means.

pub mod amg;
#[cfg(feature = "cholesky")]
mod cholesky;
mod conjugate_gradient;
mod gauss_seidel;
pub mod incomplete_cholesky;
mod kind;
mod preconditioner;

use core::time::Duration;
use std::sync::Arc;

use thiserror::Error;

pub use amg::Multigrid;
#[cfg(feature = "cholesky")]
pub use cholesky::Cholesky;
pub use conjugate_gradient::ConjugateGradient;
pub use incomplete_cholesky::IncompleteCholesky;
pub use kind::{PreconditionerKind, SolverKind};
pub use preconditioner::{BlockJacobi, Preconditioner};

use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{Padded, Scalar};

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Solved {
    /// Iterations taken; 0 for a direct solver.
    pub iterations: u32,
    /// False if the iterations ran out before the tolerance was met.
    pub converged: bool,
    /// Time spent on preparing: adapting the preconditioner, or factorising.
    pub preparation: Duration,
}

/// A solve that gave nothing usable.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SolveError {
    /// A pivot or curvature is not positive.
    #[error("the matrix is not positive definite in this precision")]
    NotPositiveDefinite,
    /// The solver has no room for so large a matrix.
    #[error("the matrix is too large for this solver")]
    TooLarge,
    /// A NaN or infinity came up.
    #[error("the matrix or the right-hand side is not finite")]
    NotFinite,
}

/// When an iterative solver may stop: once the residual r = b − A d is below either bound in the norm √(rᵀP⁻¹r) of its
/// preconditioner P ≈ A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// √kg·m.
    pub absolute: f64,
    /// Of what it was for the starting guess.
    pub relative: f64,
}

/// Solves A d = b, again and again for matrices of one pattern.
pub trait LinearSolver<T: Scalar>: Send + Sync {
    /// Solves, and may interleave A. `d` holds the starting guess on entry and the answer on return; a direct solver takes no
    /// notice of `target`.
    ///
    /// # Errors
    /// See [`SolveError`]; `d` is then not to be used.
    fn solve(
        &mut self,
        a: &mut BlockCsr<T>,
        b: &[Padded<T>],
        d: &mut [Padded<T>],
        target: Target,
    ) -> Result<Solved, SolveError>;
}

/// The solver of this kind for matrices of this pattern.
pub fn solver<T: Scalar>(kind: SolverKind, pattern: &Arc<BlockPattern>) -> Box<dyn LinearSolver<T>> {
    match kind {
        SolverKind::ConjugateGradient { max_iterations, preconditioner: kind, .. } => {
            Box::new(ConjugateGradient::new(pattern.row_count(), preconditioner(kind, pattern), max_iterations))
        }
        #[cfg(feature = "cholesky")]
        SolverKind::Cholesky => Box::new(Cholesky::new(pattern)),
    }
}

/// The preconditioner of this kind for matrices of this pattern.
pub fn preconditioner<T: Scalar>(kind: PreconditionerKind, pattern: &Arc<BlockPattern>) -> Box<dyn Preconditioner<T>> {
    match kind {
        PreconditionerKind::BlockJacobi => Box::new(BlockJacobi::new(pattern.row_count())),
        PreconditionerKind::IncompleteCholesky => Box::new(IncompleteCholesky::new(pattern)),
        PreconditionerKind::Multigrid => Box::new(Multigrid::new(pattern)),
    }
}
