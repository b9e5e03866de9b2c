//! What can be chosen about the linear solver.

use bevy::reflect::Reflect;
use bevy::reflect::std_traits::ReflectDefault;

/// The linear solver.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum SolverKind {
    /// Preconditioned conjugate gradients.
    ConjugateGradient {
        /// Stop when the residual is that of an acceleration of this size, root mean square, m/s². So the quality of a
        /// solve does not depend on the time step. 0.005 by default.
        tolerance: f32,
        /// Or when it is this share of what it was for the starting guess: motion need not be solved to the accuracy of rest.
        /// 0.03 by default.
        relative_tolerance: f32,
        /// Stop after so many iterations anyway; 500 by default.
        max_iterations: u32,
        /// The preconditioner; [`PreconditionerKind::Multigrid`] by default.
        preconditioner: PreconditionerKind,
    },
    /// faer's supernodal sparse Cholesky factorisation, in f64: the reference.
    #[cfg(feature = "cholesky")]
    Cholesky,
}

/// The preconditioner of conjugate gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
pub enum PreconditionerKind {
    /// Smoothed-aggregation multigrid, with as many levels as the cloth needs: the number of iterations hardly grows with the
    /// number of vertices. The quickest at every size.
    #[default]
    Multigrid,
    /// Incomplete Cholesky: the number of iterations grows with the number of vertices.
    IncompleteCholesky,
    /// The diagonal blocks: the least work per iteration and the least memory, and the most iterations.
    BlockJacobi,
}

impl SolverKind {
    /// Whether it stops at a tolerance.
    pub const fn is_iterative(self) -> bool {
        match self {
            Self::ConjugateGradient { .. } => true,
            #[cfg(feature = "cholesky")]
            Self::Cholesky => false,
        }
    }

    /// Conjugate gradients stopping at `tolerance`, m/s², and nowhere before.
    pub const fn conjugate_gradient(tolerance: f32) -> Self {
        Self::ConjugateGradient {
            tolerance,
            relative_tolerance: 0.0,
            max_iterations: 500,
            preconditioner: PreconditionerKind::Multigrid,
        }
    }
}

impl Default for SolverKind {
    fn default() -> Self {
        Self::ConjugateGradient {
            tolerance: 0.005,
            relative_tolerance: 0.03,
            max_iterations: 500,
            preconditioner: PreconditionerKind::Multigrid,
        }
    }
}
