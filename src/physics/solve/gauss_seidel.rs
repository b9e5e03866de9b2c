//! Sweeps of block Gauss–Seidel over A = L + D + U (Saad 2003, section 4.1).

use core::ops::Range;
use std::sync::Arc;

use super::preconditioner::positive_inverse;
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{Kernel, M3, Scalar, V3, dispatch};

/// Forward and backward sweeps. A forward sweep from zero, any symmetric positive semidefinite correction, and a
/// backward sweep are a symmetric positive definite preconditioner.
///
/// The blocks are kept by columns, one after the other: so a block times a vector is three products of a scalar and a
/// vector of four lanes, the fourth of which reads on into the next column and is ignored.
#[derive(Clone, Debug)]
pub(super) struct GaussSeidel<T> {
    pattern: Arc<BlockPattern>,
    /// A, and one number more for the fourth lane.
    blocks: Vec<T>,
    /// D⁻¹, likewise.
    inverses: Vec<T>,
}

impl<T: Scalar> GaussSeidel<T> {
    /// For matrices of a pattern.
    pub fn new(pattern: &Arc<BlockPattern>) -> Self {
        Self {
            blocks: vec![T::zero(); 9 * pattern.block_count() + 1],
            inverses: vec![T::zero(); 9 * pattern.row_count() + 1],
            pattern: Arc::clone(pattern),
        }
    }

    /// Adapts to a new matrix.
    pub fn update(&mut self, a: &BlockCsr<T>) {
        for (columns, block) in self.blocks.chunks_exact_mut(9).zip(&a.blocks) {
            store_columns(columns, block);
        }
        for (row, columns) in self.inverses.chunks_exact_mut(9).enumerate() {
            store_columns(columns, &positive_inverse(&a.diagonal(row)));
        }
    }

    /// Solves `(D + L) z = r`: a forward sweep from zero.
    pub fn forward(&self, r: &[V3<T>], z: &mut [V3<T>]) {
        dispatch(Forward { smoother: self, r, z });
    }

    /// Passes on the residual that [`Self::forward`] leaves, `r − A z = −U z`, row by row.
    pub fn residual_after_forward(&self, z: &[V3<T>], receive: impl FnMut(usize, V3<T>)) {
        dispatch(ResidualAfterForward { smoother: self, z, receive });
    }

    /// Solves `(D + U) z' = r − L z`: a backward sweep from z.
    pub fn backward(&self, r: &[V3<T>], z: &mut [V3<T>]) {
        dispatch(Backward { smoother: self, r, z });
    }

    #[inline(always)]
    fn lower(&self, row: usize) -> Range<usize> {
        self.pattern.row(row).start..self.pattern.diagonals()[row] as usize
    }

    #[inline(always)]
    fn upper(&self, row: usize) -> Range<usize> {
        self.pattern.diagonals()[row] as usize + 1..self.pattern.row(row).end
    }

    #[inline(always)]
    fn subtract(&self, sum: &mut [T; 4], slots: impl Iterator<Item = usize>, z: &[V3<T>]) {
        let columns = self.pattern.columns();
        for slot in slots {
            let product = multiply(&self.blocks, slot, z[columns[slot] as usize].0);
            for lane in 0..4 {
                sum[lane] -= product[lane];
            }
        }
    }

    #[inline(always)]
    fn solve_diagonal(&self, row: usize, sum: [T; 4]) -> V3<T> {
        narrow(multiply(&self.inverses, row, narrow(sum).0))
    }
}

struct Forward<'a, T> {
    smoother: &'a GaussSeidel<T>,
    r: &'a [V3<T>],
    z: &'a mut [V3<T>],
}

impl<T: Scalar> Kernel for Forward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { smoother, r, z } = self;
        for row in 0..r.len() {
            let mut sum = widen(r[row]);
            smoother.subtract(&mut sum, smoother.lower(row), z);
            z[row] = smoother.solve_diagonal(row, sum);
        }
    }
}

struct ResidualAfterForward<'a, T, F> {
    smoother: &'a GaussSeidel<T>,
    z: &'a [V3<T>],
    receive: F,
}

impl<T: Scalar, F: FnMut(usize, V3<T>)> Kernel for ResidualAfterForward<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        for row in 0..self.z.len() {
            let mut sum = [T::zero(); 4];
            self.smoother.subtract(&mut sum, self.smoother.upper(row), self.z);
            (self.receive)(row, narrow(sum));
        }
    }
}

struct Backward<'a, T> {
    smoother: &'a GaussSeidel<T>,
    r: &'a [V3<T>],
    z: &'a mut [V3<T>],
}

impl<T: Scalar> Kernel for Backward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { smoother, r, z } = self;
        for row in (0..r.len()).rev() {
            let mut sum = widen(r[row]);
            smoother.subtract(&mut sum, smoother.lower(row), z);
            // The row solved just before comes last, so that the others need not wait for it.
            smoother.subtract(&mut sum, smoother.upper(row).rev(), z);
            z[row] = smoother.solve_diagonal(row, sum);
        }
    }
}

/// Block number `index` times a vector.
#[inline(always)]
fn multiply<T: Scalar>(blocks: &[T], index: usize, x: [T; 3]) -> [T; 4] {
    let block = &blocks[9 * index..9 * index + 10];
    core::array::from_fn(|lane| block[lane] * x[0] + block[lane + 3] * x[1] + block[lane + 6] * x[2])
}

fn store_columns<T: Scalar>(columns: &mut [T], block: &M3<T>) {
    columns.copy_from_slice(block.transpose().0.as_flattened());
}

#[inline(always)]
fn widen<T: Scalar>(v: V3<T>) -> [T; 4] {
    [v.0[0], v.0[1], v.0[2], T::zero()]
}

#[inline(always)]
fn narrow<T: Scalar>(lanes: [T; 4]) -> V3<T> {
    V3([lanes[0], lanes[1], lanes[2]])
}
