//! A sparse symmetric matrix of 3×3 blocks.

use std::sync::Arc;

use super::parts::{ByGroup, BySlice, Part, for_parts};
use super::slice;
use super::{BlockPattern, Group};
use crate::physics::math::{Kernel, M3, Oct, Padded, ROWS, RowKernel, Scalar, dispatch};

/// A = L + D + Lᵀ: the diagonal, and the lower half. One pass over L serves both halves.
///
/// Blocks are added to the matrix one by one, but it is multiplied [`ROWS`] rows at once. So there are two stages: while it is
/// filled each block stands on its own, after [`BlockCsr::interleave`] the entries of a group stand side by side.
#[derive(Clone, Debug)]
pub struct BlockCsr<T> {
    pattern: Arc<BlockPattern>,
    /// D, by slice.
    diagonal: Vec<Group<T>>,
    /// L, by group.
    lower: Vec<Group<T>>,
    interleaved: bool,
    /// Rows that are coupled with no others: those of pins, once taken out.
    pub fixed: Vec<bool>,
}

impl<T: Scalar> BlockCsr<T> {
    /// The zero matrix of a pattern.
    pub fn zero(pattern: Arc<BlockPattern>) -> Self {
        let diagonal = vec![Group::zero(); pattern.slices().len()];
        let lower = vec![Group::zero(); pattern.group_count()];
        let fixed = vec![false; pattern.row_count()];
        Self { pattern, diagonal, lower, interleaved: false, fixed }
    }

    /// The pattern.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// Begins anew: D and L, to be filled part by part. They are not zero yet.
    pub(crate) fn clear(&mut self) -> (BySlice<'_, Group<T>>, ByGroup<'_, Group<T>>) {
        self.interleaved = false;
        self.fixed.fill(false);
        (BySlice(&mut self.diagonal), ByGroup(&mut self.lower))
    }

    /// D, which is changed part by part, and L as it is.
    pub(crate) fn diagonal_and_lower(&mut self) -> (BySlice<'_, Group<T>>, &[Group<T>]) {
        debug_assert!(!self.interleaved);
        (BySlice(&mut self.diagonal), &self.lower)
    }

    /// The block of a slot. Not of an interleaved matrix.
    #[inline(always)]
    pub fn block(&self, slot: usize) -> M3<T> {
        debug_assert!(!self.interleaved);
        self.lower[slot / ROWS].block(slot % ROWS)
    }

    /// The first eight entries of the block of a slot, and the last. Not of an interleaved matrix.
    #[inline(always)]
    pub(crate) fn entries<S: Oct<T>>(&self, s: S, slot: usize) -> (S::V, T) {
        debug_assert!(!self.interleaved);
        self.lower[slot / ROWS].entries(s, slot % ROWS)
    }

    /// The same of the block of a row on the diagonal.
    #[inline(always)]
    pub(crate) fn diagonal_entries<S: Oct<T>>(&self, s: S, row: usize) -> (S::V, T) {
        debug_assert!(!self.interleaved);
        let slot = self.pattern.diagonal(row);
        self.diagonal[slot / ROWS].entries(s, slot % ROWS)
    }

    /// Changes the block of a slot. Not of an interleaved matrix.
    #[inline(always)]
    pub fn set_block(&mut self, slot: usize, block: M3<T>) {
        debug_assert!(!self.interleaved);
        self.lower[slot / ROWS].set_block(slot % ROWS, block);
    }

    /// The block of a row on the diagonal.
    #[inline(always)]
    pub fn diagonal(&self, row: usize) -> M3<T> {
        let slot = self.pattern.diagonal(row);
        let group = &self.diagonal[slot / ROWS];
        if self.interleaved { group.interleaved_block(slot % ROWS) } else { group.block(slot % ROWS) }
    }

    /// Changes the block of a row on the diagonal. Not of an interleaved matrix.
    pub fn set_diagonal(&mut self, row: usize, block: M3<T>) {
        debug_assert!(!self.interleaved);
        let slot = self.pattern.diagonal(row);
        self.diagonal[slot / ROWS].set_block(slot % ROWS, block);
    }

    /// Columns and blocks of a row left of the diagonal. Not of an interleaved matrix.
    pub fn lower_row(&self, row: usize) -> impl Iterator<Item = (u32, M3<T>)> {
        self.pattern.row(row).map(|slot| (self.pattern.column(slot), self.block(slot)))
    }

    /// A group of blocks below the diagonal.
    #[inline(always)]
    pub(crate) fn group(&self, group: usize) -> &Group<T> {
        &self.lower[group]
    }

    /// Brings the entries of each group side by side, if they are not yet.
    pub fn interleave(&mut self) {
        if !self.interleaved {
            let groups = (BySlice(&mut self.diagonal), ByGroup(&mut self.lower));
            for_parts(self.pattern.parts(), groups, &|_: &Part, (BySlice(diagonal), ByGroup(lower))| {
                dispatch(Interleave { groups: diagonal });
                dispatch(Interleave { groups: lower });
            });
            self.interleaved = true;
        }
    }

    /// `y = A x`; returns xᵀ A x.
    ///
    /// # Panics
    /// If the matrix is not interleaved.
    pub fn multiply(&self, x: &[Padded<T>], y: &mut [Padded<T>]) -> f64 {
        assert!(self.interleaved, "the matrix is still being filled");
        for_parts(self.pattern.parts(), y, &|part: &Part, y| T::dispatch(Multiply { a: self, part, x, y }))
    }
}

struct Interleave<'a, T> {
    groups: &'a mut [Group<T>],
}

impl<T: Scalar> Kernel for Interleave<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for group in self.groups {
            group.interleave();
        }
    }
}

struct Multiply<'a, T: Scalar> {
    a: &'a BlockCsr<T>,
    part: &'a Part,
    x: &'a [Padded<T>],
    y: &'a mut [Padded<T>],
}

impl<T: Scalar> RowKernel<T> for Multiply<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) -> f64 {
        let Self { a, part, x, y } = self;
        let (pattern, first) = (&*a.pattern, part.rows.start);
        let two = s.splat(T::from_f64(2.0));
        let mut product = slice::Sum::zero();
        let slices = part.slices.clone();
        for (slice, diagonal) in pattern.slices()[slices.clone()].iter().zip(&a.diagonal[slices]) {
            let own = slice::load(s, slice, 0, x);
            let zero = [s.splat(T::zero()); 3];
            let diagonal = diagonal.mul_add(s, own, zero);
            let mut lower = zero;
            for group in slice.crossing as usize..slice.end as usize {
                let right = slice::gather(s, pattern.columns(group), 0, x);
                lower = a.group(group).mul_add(s, right, lower);
            }
            // xᵀ A x = xᵀ (D + 2 L) x.
            let ([l0, l1, l2], [d0, d1, d2]) = (lower, diagonal);
            let both = [s.mul_add(two, l0, d0), s.mul_add(two, l1, d1), s.mul_add(two, l2, d2)];
            product.add(s, own, both);
            slice::store(s, slice, first, [s.add(l0, d0), s.add(l1, d1), s.add(l2, d2)], y);
            for group in slice.inner as usize..slice.end as usize {
                let below = a.group(group).transposed_mul(s, own);
                slice::scatter_add(s, pattern.columns(group), first, below, y);
            }
        }
        for crossing in &pattern.incoming()[part.incoming.clone()] {
            let slot = crossing.slot as usize;
            let block = a.group(slot / ROWS).interleaved_block(slot % ROWS);
            y[crossing.column as usize - first] += block.transposed_times(x[crossing.row as usize]);
        }
        product.total()
    }
}
