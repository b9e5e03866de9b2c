//! Block incomplete Cholesky factorisation without fill (Meijerink & van der Vorst 1977), as `P = U D Uᵀ` with a unit
//! lower triangle U of 3×3 blocks on the pattern of A.

use core::ops::Range;
use std::sync::Arc;

use super::Preconditioner;
use super::preconditioner::{inverse_above, positive_inverse};
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{M3, Scalar, V3};

/// Diagonal shifts, relative to the diagonal (Manteuffel 1980): the factorisation of a positive definite matrix may
/// fail without one.
const SHIFTS: [f64; 8] = [0.0, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0];

/// Matrices of one shift before a smaller one is tried again: one matrix is much like the next, and a failure costs up
/// to a factorisation.
const PATIENCE: u32 = 8;

/// Smallest pivot accepted, relative to the diagonal block it came from.
const MIN_PIVOT: f64 = 1e-4;

/// See the [module](self). Falls back to the inverses of the diagonal blocks, which cannot fail, should every shift
/// fail.
#[derive(Clone, Debug)]
pub struct IncompleteCholesky<T> {
    pattern: Arc<BlockPattern>,
    /// Start of each row in the lower triangle, diagonal excluded.
    row_starts: Vec<u32>,
    /// Start of each entry's part of `updates`.
    update_starts: Vec<u32>,
    /// For the entry (i, j) all pairs of entries (i, k), (j, k) with k < j.
    updates: Vec<[u32; 2]>,
    /// U.
    lower: Vec<M3<T>>,
    /// U D, while a row is being factorised.
    scaled: Vec<M3<T>>,
    inverse_pivots: Vec<M3<T>>,
    /// Which of [`SHIFTS`] the last matrix needed.
    shift: usize,
    /// How many matrices in a row got along with it.
    streak: u32,
}

impl<T: Scalar> IncompleteCholesky<T> {
    /// Analyses a pattern.
    pub fn new(pattern: &Arc<BlockPattern>) -> Self {
        let rows = pattern.row_count();
        let lower_columns = |row: usize| &pattern.columns()[lower_slots(pattern, row)];
        let mut row_starts = vec![0];
        for row in 0..rows {
            row_starts.push(row_starts[row] + lower_columns(row).len() as u32);
        }
        let (mut update_starts, mut updates) = (vec![0], Vec::new());
        for row in 0..rows {
            let columns = lower_columns(row);
            for (entry, &column) in columns.iter().enumerate() {
                let other = lower_columns(column as usize);
                for (i, k) in columns[..entry].iter().enumerate() {
                    if let Ok(j) = other.binary_search(k) {
                        updates.push([row_starts[row] + i as u32, row_starts[column as usize] + j as u32]);
                    }
                }
                update_starts.push(updates.len() as u32);
            }
        }
        let entries = row_starts[rows] as usize;
        Self {
            pattern: Arc::clone(pattern),
            row_starts,
            update_starts,
            updates,
            lower: vec![M3::zero(); entries],
            scaled: vec![M3::zero(); entries],
            inverse_pivots: vec![M3::zero(); rows],
            shift: 0,
            streak: 0,
        }
    }

    #[inline(always)]
    fn row(&self, row: usize) -> Range<usize> {
        self.row_starts[row] as usize..self.row_starts[row + 1] as usize
    }

    /// Factorises `A + shift diag(A)`; false if a pivot is not positive.
    fn factorise(&mut self, a: &BlockCsr<T>, shift: f64) -> bool {
        let shift = T::from_f64(shift);
        let pattern = Arc::clone(&self.pattern);
        for row in 0..pattern.row_count() {
            let diagonal = a.diagonal(row);
            let mut pivot = diagonal;
            for i in 0..3 {
                pivot.0[i][i] += shift * diagonal.0[i][i];
            }
            for (entry, slot) in self.row(row).zip(lower_slots(&pattern, row)) {
                let updates = self.update_starts[entry] as usize..self.update_starts[entry + 1] as usize;
                let mut block = a.blocks[slot];
                for &[ik, jk] in &self.updates[updates] {
                    block = block - self.scaled[ik as usize] * self.lower[jk as usize].transpose();
                }
                let unit = block * self.inverse_pivots[pattern.columns()[slot] as usize];
                pivot = pivot - block * unit.transpose();
                self.scaled[entry] = block;
                self.lower[entry] = unit;
            }
            match inverse_above(&pivot, [0, 1, 2].map(|i| T::from_f64(MIN_PIVOT) * diagonal.0[i][i])) {
                Some(inverse) => self.inverse_pivots[row] = inverse,
                None => return false,
            }
        }
        true
    }
}

impl<T: Scalar> Preconditioner<T> for IncompleteCholesky<T> {
    fn update(&mut self, a: &BlockCsr<T>) {
        let first = if self.streak < PATIENCE { self.shift } else { self.shift.saturating_sub(1) };
        let found = (first..SHIFTS.len()).find(|&shift| self.factorise(a, SHIFTS[shift]));
        self.streak = if found == Some(self.shift) && first == self.shift { self.streak + 1 } else { 0 };
        self.shift = found.unwrap_or(0);
        if found.is_none() {
            // Block Jacobi.
            self.lower.fill(M3::zero());
            for (row, inverse) in self.inverse_pivots.iter_mut().enumerate() {
                *inverse = positive_inverse(&a.diagonal(row));
            }
        }
    }

    fn apply(&mut self, r: &[V3<T>], z: &mut [V3<T>]) {
        let columns = |row| &self.pattern.columns()[lower_slots(&self.pattern, row)];
        for row in 0..r.len() {
            let mut sum = r[row];
            for (block, &column) in self.lower[self.row(row)].iter().zip(columns(row)) {
                sum -= block.mul_vector(z[column as usize]);
            }
            z[row] = sum;
        }
        for (z, inverse) in z.iter_mut().zip(&self.inverse_pivots) {
            *z = inverse.mul_vector(*z);
        }
        for row in (0..r.len()).rev() {
            let solved = z[row];
            for (block, &column) in self.lower[self.row(row)].iter().zip(columns(row)) {
                z[column as usize] -= block.transpose().mul_vector(solved);
            }
        }
    }
}

/// Slots of the blocks left of the diagonal.
#[inline(always)]
fn lower_slots(pattern: &BlockPattern, row: usize) -> Range<usize> {
    pattern.row(row).start..pattern.diagonals()[row] as usize
}
