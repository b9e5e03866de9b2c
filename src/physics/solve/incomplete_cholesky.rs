//! Block incomplete Cholesky factorisation without fill (Meijerink & van der Vorst 1977), as `P = U D Uᵀ` with a unit
//! lower triangle U of 3×3 blocks on the pattern of A.

use std::sync::Arc;

use super::Preconditioner;
use super::preconditioner::{inverse_above, invert};
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{Kernel, M3, Padded, RowSums, Scalar, dispatch};

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
    /// By row: its first entry.
    starts: Vec<u32>,
    /// By entry: its column.
    columns: Vec<u32>,
    /// Start of each entry's part of `updates`.
    update_starts: Vec<u32>,
    /// For the entry (i, j) all k < j with entries (i, k) and (j, k): where each stands in its row.
    updates: Vec<[u16; 2]>,
    /// U, by entry.
    lower: Vec<M3<T>>,
    /// U D of the row that is being factorised.
    scaled: Vec<M3<T>>,
    inverse_pivots: Vec<M3<T>>,
    /// Which of [`SHIFTS`] the last matrix needed; beyond them if none was enough.
    shift: usize,
    /// How many matrices in a row got along with it.
    streak: u32,
}

impl<T: Scalar> IncompleteCholesky<T> {
    /// Analyses a pattern.
    pub fn new(pattern: &Arc<BlockPattern>) -> Self {
        let (mut starts, mut columns) = (vec![0], Vec::new());
        for row in 0..pattern.row_count() {
            columns.extend(pattern.row(row).map(|slot| pattern.column(slot)));
            starts.push(columns.len() as u32);
        }
        let columns_of = |row: usize| &columns[starts[row] as usize..starts[row + 1] as usize];
        let (mut update_starts, mut updates) = (vec![0], Vec::new());
        for row in 0..pattern.row_count() {
            let columns = columns_of(row);
            for (entry, &column) in columns.iter().enumerate() {
                let other = columns_of(column as usize);
                for (i, k) in columns[..entry].iter().enumerate() {
                    // Beyond 2¹⁶ entries in a row the factorisation is a little less complete.
                    if let Ok(j) = other.binary_search(k)
                        && let (Ok(i), Ok(j)) = (u16::try_from(i), u16::try_from(j))
                    {
                        updates.push([i, j]);
                    }
                }
                update_starts.push(updates.len() as u32);
            }
        }
        columns.shrink_to_fit();
        updates.shrink_to_fit();
        let longest = (0..pattern.row_count()).map(|row| pattern.row_length(row)).max().unwrap_or(0);
        Self {
            pattern: Arc::clone(pattern),
            lower: vec![M3::zero(); columns.len()],
            starts,
            columns,
            update_starts,
            updates,
            scaled: vec![M3::zero(); longest],
            inverse_pivots: vec![M3::zero(); pattern.row_count()],
            shift: 0,
            streak: 0,
        }
    }
}

/// Factorises `A + shift diag(A)`; false if a pivot is not positive.
struct Factorise<'a, T> {
    factor: &'a mut IncompleteCholesky<T>,
    a: &'a BlockCsr<T>,
    shift: T,
}

impl<T: Scalar> Kernel for Factorise<'_, T> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { factor, a, shift } = self;
        let IncompleteCholesky {
            pattern, starts, columns, update_starts, updates, lower, scaled, inverse_pivots, ..
        } = factor;
        for row in 0..pattern.row_count() {
            let diagonal = a.diagonal(row);
            let mut pivot = diagonal;
            for i in 0..3 {
                pivot.0[i][i] += shift * diagonal.0[i][i];
            }
            for ((place, slot), entry) in pattern.row(row).enumerate().zip(starts[row] as usize..) {
                let column = columns[entry] as usize;
                let other = starts[column] as usize;
                let mut block = a.block(slot);
                for &[ik, jk] in &updates[update_starts[entry] as usize..update_starts[entry + 1] as usize] {
                    block = block - scaled[usize::from(ik)] * lower[other + usize::from(jk)].transpose();
                }
                let unit = block * inverse_pivots[column];
                pivot = pivot - block * unit.transpose();
                scaled[place] = block;
                lower[entry] = unit;
            }
            match inverse_above(&pivot, [0, 1, 2].map(|i| T::from_f64(MIN_PIVOT) * diagonal.0[i][i])) {
                Some(inverse) => inverse_pivots[row] = inverse,
                None => return false,
            }
        }
        true
    }
}

impl<T: Scalar> Preconditioner<T> for IncompleteCholesky<T> {
    fn update(&mut self, a: &BlockCsr<T>) {
        let last = self.shift % SHIFTS.len();
        let first = if self.streak < PATIENCE { last } else { last.saturating_sub(1) };
        let found = (first..SHIFTS.len())
            .find(|&shift| dispatch(Factorise { factor: self, a, shift: T::from_f64(SHIFTS[shift]) }));
        self.streak = if found == Some(last) && first == last { self.streak + 1 } else { 0 };
        self.shift = found.unwrap_or(SHIFTS.len());
        if found.is_none() {
            // Block Jacobi.
            self.lower.fill(M3::zero());
            for (row, pivot) in self.inverse_pivots.iter_mut().enumerate() {
                *pivot = a.diagonal(row);
            }
            invert(&mut self.inverse_pivots);
        }
    }

    fn apply(&mut self, _: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> f64 {
        dispatch(Apply { factor: self, r, z })
    }
}

struct Apply<'a, T: Scalar> {
    factor: &'a IncompleteCholesky<T>,
    r: &'a [Padded<T>],
    z: &'a mut [Padded<T>],
}

impl<T: Scalar> Kernel for Apply<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { factor: IncompleteCholesky { starts, columns, lower, inverse_pivots, .. }, r, z } = self;
        for row in 0..r.len() {
            let range = starts[row] as usize..starts[row + 1] as usize;
            let mut sums = RowSums::zero();
            for (block, &column) in lower[range.clone()].iter().zip(&columns[range]) {
                sums.add(block, z[column as usize]);
            }
            z[row] = r[row] - sums.total();
        }
        for (z, inverse) in z.iter_mut().zip(inverse_pivots) {
            *z = inverse.times(*z);
        }
        let mut product = 0.0;
        for row in (0..r.len()).rev() {
            let range = starts[row] as usize..starts[row + 1] as usize;
            let solved = z[row];
            product += r[row].dot_f64(solved);
            for (block, &column) in lower[range.clone()].iter().zip(&columns[range]) {
                z[column as usize] -= block.transposed_times(solved);
            }
        }
        product
    }
}
