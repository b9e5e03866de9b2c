//! The preconditioner of small cloths.

use std::sync::Arc;

use super::{IncompleteCholesky, Multigrid, Preconditioner};
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{Padded, Scalar};

/// Diagonal shift beyond which incomplete Cholesky is a poor preconditioner, relative to the diagonal.
const MOST_SHIFT: f64 = 1e-2;

/// Incomplete Cholesky, or multigrid for matrices that it would need a large shift for.
#[derive(Clone, Debug)]
pub struct Auto<T: Scalar> {
    pattern: Arc<BlockPattern>,
    cholesky: IncompleteCholesky<T>,
    /// Made when first needed: most cloths never do.
    multigrid: Option<Multigrid<T>>,
}

impl<T: Scalar> Auto<T> {
    /// For matrices of a pattern.
    pub fn new(pattern: &Arc<BlockPattern>) -> Self {
        Self { pattern: Arc::clone(pattern), cholesky: IncompleteCholesky::new(pattern), multigrid: None }
    }

    fn shifted_far(&self) -> bool {
        self.cholesky.shift() > MOST_SHIFT
    }
}

impl<T: Scalar> Preconditioner<T> for Auto<T> {
    fn update(&mut self, a: &BlockCsr<T>) {
        self.cholesky.update(a);
        if self.shifted_far() {
            self.multigrid.get_or_insert_with(|| Multigrid::new(&self.pattern)).update(a);
        }
    }

    fn apply(&mut self, a: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> f64 {
        if self.shifted_far()
            && let Some(multigrid) = &mut self.multigrid
        {
            multigrid.apply(a, r, z)
        } else {
            self.cholesky.apply(a, r, z)
        }
    }
}
