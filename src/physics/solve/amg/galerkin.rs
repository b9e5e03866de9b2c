//! The coarse matrix Pᵀ A P.

use std::sync::Arc;

use super::prolongation::Prolongation;
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{M3, Scalar};

/// Coarse levels of so few nodes have a dense pattern, so that their factorisation without fill is complete.
const DENSE: usize = 48;

/// The product, prepared: row by row of A, the sums `S = A P` and where `Pᵀ S` adds them.
#[derive(Clone, Debug)]
pub(super) struct Galerkin<T> {
    arch: pulp::Arch,
    /// For each row of A the end of its part of `sums`.
    row_ends: Vec<u32>,
    sums: Vec<Sum>,
    terms: Vec<Term<T>>,
    /// Slots of the coarse matrix, one for each sum S(i, J) and each P(i, I) ≠ 0 with I ≤ J.
    targets: Vec<u32>,
    /// Slots of the coarse blocks right of the diagonal, and of their mirror images.
    mirrors: Vec<[u32; 2]>,
}

/// S(i, J): ends of its parts of `terms` and `targets`; they begin where those of the sum before end.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    terms: u32,
    targets: u32,
}

/// A(i, j) P(j, J).
#[derive(Clone, Copy, Debug)]
struct Term<T> {
    slot: u32,
    weight: T,
}

impl<T: Scalar> Galerkin<T> {
    /// The product for matrices of `pattern`, and the pattern of the result, of `coarse` nodes.
    pub fn new(pattern: &BlockPattern, p: &Prolongation<T>, coarse: usize) -> (Self, Arc<BlockPattern>) {
        let mut galerkin = Self {
            arch: pulp::Arch::new(),
            row_ends: Vec::new(),
            sums: Vec::new(),
            terms: Vec::new(),
            targets: Vec::new(),
            mirrors: Vec::new(),
        };
        // (J, term) of a row, and (I, J) of all targets.
        let mut products: Vec<(u32, Term<T>)> = Vec::new();
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for row in 0..pattern.row_count() {
            products.clear();
            for slot in pattern.row(row) {
                let entries = p.row(pattern.columns()[slot] as usize);
                products.extend(entries.iter().map(|e| (e.column, Term { slot: slot as u32, weight: e.weight })));
            }
            products.sort_by_key(|&(column, _)| column);
            for sum in products.chunk_by(|a, b| a.0 == b.0) {
                let column = sum[0].0;
                galerkin.terms.extend(sum.iter().map(|&(_, term)| term));
                pairs.extend(p.row(row).iter().take_while(|e| e.column <= column).map(|e| [e.column, column]));
                galerkin.sums.push(Sum { terms: galerkin.terms.len() as u32, targets: pairs.len() as u32 });
            }
            galerkin.row_ends.push(galerkin.sums.len() as u32);
        }
        let pattern = if coarse <= DENSE {
            let all: Vec<u32> = (0..coarse as u32).collect();
            BlockPattern::new(coarse, core::iter::once(&all[..]))
        } else {
            BlockPattern::new(coarse, pairs.iter().map(|pair| &pair[..]))
        };
        let slot = |row, column| pattern.slot(row, column).expect("every product is in the pattern");
        galerkin.targets = pairs.iter().map(|&[i, j]| slot(i, j)).collect();
        for row in 0..coarse as u32 {
            let upper = pattern.diagonals()[row as usize] as usize + 1..pattern.row(row as usize).end;
            galerkin.mirrors.extend(upper.map(|s| [s as u32, slot(pattern.columns()[s], row)]));
        }
        (galerkin, Arc::new(pattern))
    }

    /// `coarse = Pᵀ A P`. Rows of A that nothing couples to others (pins) stay out: smoothing alone solves them.
    pub fn multiply(&self, a: &BlockCsr<T>, p: &Prolongation<T>, coarse: &mut BlockCsr<T>) {
        coarse.clear();
        self.arch.dispatch(
            #[inline(always)]
            || self.add_upper_half(a, p, coarse),
        );
        for &[upper, lower] in &self.mirrors {
            coarse.blocks[lower as usize] = coarse.blocks[upper as usize].transpose();
        }
        // An aggregate of pins alone: nothing will ever be asked of it.
        for row in 0..coarse.pattern().row_count() {
            let diagonal = coarse.diagonal_mut(row);
            if *diagonal == M3::zero() {
                *diagonal = M3::scaled_identity(T::splat(1.0));
            }
        }
    }

    #[inline(always)]
    fn add_upper_half(&self, a: &BlockCsr<T>, p: &Prolongation<T>, coarse: &mut BlockCsr<T>) {
        let (mut first, mut start) = (0, Sum::default());
        for (row, &end) in self.row_ends.iter().enumerate() {
            let sums = &self.sums[first as usize..end as usize];
            if is_coupled(a, row) {
                let entries = p.row(row);
                let mut start = start;
                for &sum in sums {
                    let mut block = M3::zero();
                    for term in &self.terms[start.terms as usize..sum.terms as usize] {
                        block += a.blocks[term.slot as usize] * term.weight;
                    }
                    let targets = &self.targets[start.targets as usize..sum.targets as usize];
                    for (&target, entry) in targets.iter().zip(entries) {
                        coarse.blocks[target as usize] += block * entry.weight;
                    }
                    start = sum;
                }
            }
            first = end;
            start = sums.last().copied().unwrap_or(start);
        }
    }
}

#[inline(always)]
fn is_coupled<T: Scalar>(a: &BlockCsr<T>, row: usize) -> bool {
    a.row(row).any(|(column, block)| column as usize != row && *block != M3::zero())
}
