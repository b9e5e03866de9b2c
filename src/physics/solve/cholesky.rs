//! Sparse Cholesky factorisation by faer: the reference solver.

use std::sync::Arc;

use bevy::platform::time::Instant;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side, Spec};

use super::{LinearSolver, SolveError, Solved, Target};
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{Padded, ROWS, Scalar};

/// Supernodal Cholesky with approximate-minimum-degree ordering, always in f64. The symbolic analysis is made once per
/// pattern; every buffer is reused.
pub struct Cholesky(Option<Factor>);

struct Factor {
    lower: SymbolicSparseColMat<u32>,
    /// Where each entry of the lower triangle comes from: block · 9 + row · 3 + column within the block, blocks being those
    /// of the diagonal, by row, and then the others, by slot.
    sources: Vec<u32>,
    symbolic: SymbolicCholesky<u32>,
    values: Vec<f64>,
    factor: Vec<f64>,
    solution: Vec<f64>,
    memory: MemBuffer,
}

impl Cholesky {
    /// Analyses a pattern. If its factor has 2³² entries or more, or finds no memory, every solve is
    /// [`SolveError::TooLarge`].
    pub fn new(pattern: &Arc<BlockPattern>) -> Self {
        Self(Factor::new(pattern))
    }
}

/// Whether all entries of the blocks have numbers.
fn has_numbers(rows: usize, groups: usize) -> bool {
    u32::try_from(9 * (rows + ROWS * groups)).is_ok()
}

/// Zeros, if there is memory for them.
fn zeros(count: usize) -> Option<Vec<f64>> {
    let mut zeros = Vec::new();
    zeros.try_reserve_exact(count).ok()?;
    zeros.resize(count, 0.0);
    Some(zeros)
}

impl Factor {
    fn new(pattern: &BlockPattern) -> Option<Self> {
        if !has_numbers(pattern.row_count(), pattern.group_count()) {
            return None;
        }
        let (lower, sources) = scalar_lower_triangle(pattern);
        let params = CholeskySymbolicParams {
            // The simplicial variant is much slower on the wide fronts of a surface mesh.
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(lower.as_ref(), Side::Lower, SymmetricOrdering::Amd, params).ok()?;
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        Some(Self {
            values: zeros(sources.len())?,
            factor: zeros(symbolic.len_val())?,
            solution: zeros(3 * pattern.row_count())?,
            memory: MemBuffer::try_new(scratch).ok()?,
            lower,
            sources,
            symbolic,
        })
    }
}

impl<T: Scalar> LinearSolver<T> for Cholesky {
    fn solve(
        &mut self,
        a: &mut BlockCsr<T>,
        b: &[Padded<T>],
        d: &mut [Padded<T>],
        _: Target,
    ) -> Result<Solved, SolveError> {
        let start = Instant::now();
        let Factor { lower, sources, symbolic, values, factor, solution, memory } =
            self.0.as_mut().ok_or(SolveError::TooLarge)?;
        for (value, &source) in values.iter_mut().zip(&*sources) {
            let (block, row, column) = (source as usize / 9, source as usize / 3 % 3, source as usize % 3);
            let block = if block < b.len() { a.diagonal(block) } else { a.block(block - b.len()) };
            *value = block.0[row][column].to_f64();
        }
        for (entries, b) in solution.chunks_exact_mut(3).zip(b) {
            entries.copy_from_slice(&b.to_f64());
        }
        if !values.iter().chain(&*solution).all(|v| v.is_finite()) {
            return Err(SolveError::NotFinite);
        }
        let llt = symbolic
            .factorize_numeric_llt(
                factor,
                SparseColMatRef::new(lower.as_ref(), values),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(memory),
                Spec::default(),
            )
            .map_err(|_| SolveError::NotPositiveDefinite)?;
        let preparation = start.elapsed();
        let rows = solution.len();
        llt.solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(solution, rows, 1),
            Par::Seq,
            MemStack::new(memory),
        );
        for (d, entries) in d.iter_mut().zip(solution.chunks_exact(3)) {
            *d = Padded::from_f64([entries[0], entries[1], entries[2]]);
        }
        Ok(Solved { iterations: 0, converged: true, preparation })
    }
}

/// The scalar pattern of the lower triangle by columns, and the entry of a block behind each of its entries.
fn scalar_lower_triangle(pattern: &BlockPattern) -> (SymbolicSparseColMat<u32>, Vec<u32>) {
    // The blocks below the diagonal by column.
    let mut below: Vec<Vec<[usize; 2]>> = vec![Vec::new(); pattern.row_count()];
    for row in 0..pattern.row_count() {
        for slot in pattern.row(row) {
            below[pattern.column(slot) as usize].push([row, pattern.row_count() + slot]);
        }
    }
    let size = 3 * pattern.row_count();
    let (mut starts, mut rows, mut sources) = (vec![0], Vec::new(), Vec::new());
    for (diagonal, below) in below.into_iter().enumerate() {
        for column in 0..3 {
            let mut push = |block_row: usize, block: usize, row: usize| {
                rows.push((3 * block_row + row) as u32);
                sources.push((9 * block + 3 * row + column) as u32);
            };
            (column..3).for_each(|row| push(diagonal, diagonal, row));
            for &[block_row, block] in &below {
                (0..3).for_each(|row| push(block_row, block, row));
            }
            starts.push(rows.len() as u32);
        }
    }
    (SymbolicSparseColMat::new_checked(size, size, starts, None, rows), sources)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::assembly::Slicing;

    #[test]
    fn what_is_too_large_is_an_error() {
        assert!(has_numbers(1_000_000, 1_000_000) && !has_numbers(1_000_000, 60_000_000));
        assert!(zeros(usize::MAX / 4).is_none());
        let pattern = BlockPattern::new(1, &[0], Slicing::Any, core::iter::empty(), core::iter::empty());
        let mut a = BlockCsr::<f64>::zero(Arc::new(pattern));
        let (b, mut d) = ([Padded::zero()], [Padded::zero()]);
        let target = Target { absolute: 0.0, relative: 0.0 };
        assert_eq!(Cholesky(None).solve(&mut a, &b, &mut d, target), Err(SolveError::TooLarge));
    }
}
