//! The matrix of a coarser level, Pᵀ A P.
//!
//! With `A = D + L + Lᵀ` and `B = ½ D + L` it is `Pᵀ B P` and its transpose together. So for each row i of L the sums
//! `S(i, J) = Σⱼ B(i, j) P(j, J)` are made first, and `P(i, I) S(i, J)` then added at (I, J), or transposed at (J, I),
//! whichever is below the diagonal.

use std::sync::Arc;

use super::prolongation::Prolongation;
use crate::physics::assembly::parts::{ByPart, BySlot, Part, for_parts};
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{Flat, Kernel, M3, Scalar, dispatch};

/// A coarse matrix of so few rows has all blocks.
const DENSE: usize = 64;

/// What of the product depends on the patterns alone.
#[derive(Clone, Debug)]
pub(super) struct Galerkin<T: Scalar> {
    /// By row of A: starts of its parts of `sums`, of `terms` and of `targets`.
    starts: Vec<[u32; 3]>,
    /// The columns J of the sums of each row.
    sums: Vec<u32>,
    /// Which sum of its row each product of a block and a weight belongs to, block by block, the diagonal first.
    terms: Vec<u16>,
    /// Where each product of a sum and a weight goes, sum by sum: the slot of (I, J) or (J, I), or I for I = J.
    targets: Vec<u32>,
    /// The rows of A that each part of the coarse matrix has to do with.
    rows: Vec<Vec<u32>>,
    /// The sums of a row, by part.
    scratch: Vec<Vec<Flat<T>>>,
}

impl<T: Scalar> Galerkin<T> {
    /// The product for matrices of `pattern`, and the pattern of the result, whose parts begin at `part_starts`.
    pub fn new(
        pattern: &BlockPattern,
        p: &Prolongation<T>,
        coarse: usize,
        part_starts: &[u32],
    ) -> (Self, Arc<BlockPattern>) {
        let mut galerkin = Self {
            starts: vec![[0; 3]],
            sums: Vec::new(),
            terms: Vec::new(),
            targets: Vec::new(),
            rows: Vec::new(),
            scratch: Vec::new(),
        };
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        let (mut longest, mut columns) = (0, Vec::new());
        for row in 0..pattern.row_count() {
            // All columns J of the row, in the order of the terms.
            columns.clear();
            columns.extend(p.row(row).iter().map(|entry| entry.column));
            for slot in pattern.row(row) {
                columns.extend(p.row(pattern.columns()[slot] as usize).iter().map(|entry| entry.column));
            }
            let mut sums = columns.clone();
            sums.sort_unstable();
            sums.dedup();
            let place = |column| sums.binary_search(&column).expect("each column has a sum") as u16;
            galerkin.terms.extend(columns.iter().map(|&column| place(column)));
            for &column in &sums {
                pairs.extend(p.row(row).iter().map(|entry| [entry.column.max(column), entry.column.min(column)]));
            }
            longest = longest.max(sums.len());
            galerkin.sums.extend(sums);
            galerkin.starts.push([galerkin.sums.len(), galerkin.terms.len(), pairs.len()].map(|n| n as u32));
        }
        // Incomplete Cholesky is complete where every block exists.
        let all: Vec<u32> = (0..if coarse <= DENSE { coarse as u32 } else { 0 }).collect();
        let couplings = pairs.iter().map(|pair| &pair[..]).chain([&all[..]]);
        let pattern = BlockPattern::new(coarse, part_starts, couplings, core::iter::empty());
        galerkin.targets = pairs
            .iter()
            .map(|&[i, j]| if i == j { i } else { pattern.slot(i, j).expect("every product is in the pattern") })
            .collect();
        galerkin.sums.shrink_to_fit();
        galerkin.terms.shrink_to_fit();

        let part_of = |row: u32| pattern.parts().partition_point(|part| part.rows.end <= row as usize);
        galerkin.rows = vec![Vec::new(); pattern.parts().len()];
        for row in 0..galerkin.starts.len() - 1 {
            let products = galerkin.starts[row][2] as usize..galerkin.starts[row + 1][2] as usize;
            let mut parts: Vec<_> = pairs[products].iter().map(|pair| part_of(pair[0])).collect();
            parts.sort_unstable();
            parts.dedup();
            for part in parts {
                galerkin.rows[part].push(row as u32);
            }
        }
        let zero = M3::zero().flat();
        galerkin.scratch = vec![vec![zero; longest]; pattern.parts().len()];
        (galerkin, Arc::new(pattern))
    }

    /// `coarse = Pᵀ A P`. Rows of A that are coupled with no others (pins) stay out: smoothing alone solves them.
    pub fn multiply(&mut self, a: &BlockCsr<T>, p: &Prolongation<T>, coarse: &mut BlockCsr<T>) {
        let Self { starts, sums, terms, targets, rows, scratch } = self;
        let pattern = Arc::clone(coarse.pattern());
        let data = (&mut coarse.diagonal[..], BySlot(&mut coarse.lower), ByPart(scratch));
        for_parts(pattern.parts(), data, &|part: &Part, (diagonal, BySlot(lower), ByPart(scratch))| {
            diagonal.fill(M3::zero());
            lower.fill(M3::zero());
            for scratch in scratch {
                let rows = &rows[part.index];
                dispatch(Multiply { starts, sums, terms, targets, rows, a, p, part, diagonal, lower, scratch });
            }
            // An aggregate of pins alone: nothing will ever be asked of it.
            for diagonal in diagonal.iter_mut().filter(|diagonal| **diagonal == M3::zero()) {
                *diagonal = M3::scaled_identity(T::splat(1.0));
            }
        });
    }
}

struct Multiply<'a, T: Scalar> {
    starts: &'a [[u32; 3]],
    sums: &'a [u32],
    terms: &'a [u16],
    targets: &'a [u32],
    rows: &'a [u32],
    a: &'a BlockCsr<T>,
    p: &'a Prolongation<T>,
    part: &'a Part,
    diagonal: &'a mut [M3<T>],
    lower: &'a mut [M3<T>],
    scratch: &'a mut [Flat<T>],
}

impl<T: Scalar> Kernel for Multiply<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { starts, sums, terms, targets, rows, a, p, part, diagonal, lower, scratch } = self;
        let pattern = &**a.pattern();
        let (zero, half) = (M3::zero().flat(), T::splat(0.5));
        for &row in rows {
            let row = row as usize;
            if a.fixed[row] {
                continue;
            }
            let ([sum, term, target], [sum_end, _, _]) = (starts[row].map(|n| n as usize), starts[row + 1]);
            let sums = &sums[sum..sum_end as usize];
            let scratch = &mut scratch[..sums.len()];
            scratch.fill(zero);
            let mut terms = terms[term..].iter();
            let entries = p.row(row);
            let middle = a.diagonal[row].flat() * half;
            for (entry, &place) in entries.iter().zip(&mut terms) {
                scratch[usize::from(place)] = scratch[usize::from(place)] + middle * entry.weight;
            }
            let range = pattern.row(row);
            for (block, &column) in a.lower[range.clone()].iter().zip(&pattern.columns()[range]) {
                let (block, fixed) = (block.flat(), a.fixed[column as usize]);
                for (entry, &place) in p.row(column as usize).iter().zip(&mut terms) {
                    if !fixed {
                        scratch[usize::from(place)] = scratch[usize::from(place)] + block * entry.weight;
                    }
                }
            }
            let mut targets = targets[target..].iter();
            for (&column, &sum) in sums.iter().zip(&*scratch) {
                for (entry, &target) in entries.iter().zip(&mut targets) {
                    let product = sum * entry.weight;
                    if entry.column == column {
                        if let Some(block) = diagonal.get_mut((target as usize).wrapping_sub(part.rows.start)) {
                            block.accumulate(product + product.transpose());
                        }
                    } else if let Some(block) = lower.get_mut((target as usize).wrapping_sub(part.slots.start)) {
                        block.accumulate(if entry.column > column { product } else { product.transpose() });
                    }
                }
            }
        }
    }
}
