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
use crate::physics::math::{Padded, Scalar};

/// Supernodal Cholesky with approximate-minimum-degree ordering, always in f64. The symbolic analysis is made once per
/// pattern; every buffer is reused.
pub struct Cholesky {
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
    /// Analyses a pattern.
    ///
    /// # Panics
    /// If memory runs out, or the factor has 2³² entries or more.
    pub fn new(pattern: &Arc<BlockPattern>) -> Self {
        let (lower, sources) = scalar_lower_triangle(pattern);
        let params = CholeskySymbolicParams {
            // The simplicial variant is much slower on the wide fronts of a surface mesh.
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(lower.as_ref(), Side::Lower, SymmetricOrdering::Amd, params)
            .expect("the matrix of a cloth fits into memory");
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        Self {
            values: vec![0.0; sources.len()],
            factor: vec![0.0; symbolic.len_val()],
            solution: vec![0.0; 3 * pattern.row_count()],
            memory: MemBuffer::new(scratch),
            lower,
            sources,
            symbolic,
        }
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
        for (value, &source) in self.values.iter_mut().zip(&self.sources) {
            let (block, row, column) = (source as usize / 9, source as usize / 3 % 3, source as usize % 3);
            let block = if block < b.len() { a.diagonal(block) } else { a.block(block - b.len()) };
            *value = block.0[row][column].to_f64();
        }
        for (entries, b) in self.solution.chunks_exact_mut(3).zip(b) {
            entries.copy_from_slice(&b.to_f64());
        }
        if !self.values.iter().chain(&self.solution).all(|v| v.is_finite()) {
            return Err(SolveError::NotFinite);
        }
        let llt = self
            .symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                SparseColMatRef::new(self.lower.as_ref(), &self.values),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Spec::default(),
            )
            .map_err(|_| SolveError::NotPositiveDefinite)?;
        let preparation = start.elapsed();
        let rows = self.solution.len();
        llt.solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut self.solution, rows, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
        for (d, entries) in d.iter_mut().zip(self.solution.chunks_exact(3)) {
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
