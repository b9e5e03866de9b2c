//! The diagonal of A, from what is beside it.
//!
//! A uniform translation strains nothing, so the blocks of each row of the elastic part of A sum to zero, and the diagonal
//! need not be assembled: it is the inertia less the other blocks of its row. In f32 the sums of rows are then as close to
//! zero as they can be, which assembled diagonals miss by the rounding of each element.

use super::{BlockPattern, Group, Part};
use crate::physics::math::{Oct, ROWS, RowKernel, Scalar};

/// Fills the diagonal blocks of a part, which hold the inertia already.
pub(super) struct SubtractRows<'a, T: Scalar> {
    pub pattern: &'a BlockPattern,
    pub part: &'a Part,
    pub lower: &'a [Group<T>],
    /// By slice of the part.
    pub diagonal: &'a mut [Group<T>],
}

impl<T: Scalar> RowKernel<T> for SubtractRows<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        let Self { pattern, part, lower, diagonal } = self;
        let first_slice = part.slices.start;
        let zero = s.splat(T::zero());
        for row in part.rows.clone() {
            let own = pattern.diagonal(row);
            let mut sum = (zero, T::zero());
            for slot in pattern.row(row) {
                let (first, last) = lower[slot / ROWS].entries(s, slot % ROWS);
                sum = (s.sub(sum.0, first), sum.1 - last);
                let column = pattern.column(slot) as usize;
                if column >= part.rows.start {
                    let other = pattern.diagonal(column);
                    let transposed = s.transpose_block(s.sub(zero, first));
                    diagonal[other / ROWS - first_slice].accumulate(s, other % ROWS, transposed, -last);
                }
            }
            diagonal[own / ROWS - first_slice].accumulate(s, own % ROWS, sum.0, sum.1);
        }
        for crossing in &pattern.incoming()[part.incoming.clone()] {
            let (slot, other) = (crossing.slot as usize, pattern.diagonal(crossing.column as usize));
            let (first, last) = lower[slot / ROWS].entries(s, slot % ROWS);
            let transposed = s.transpose_block(s.sub(zero, first));
            diagonal[other / ROWS - first_slice].accumulate(s, other % ROWS, transposed, -last);
        }
    }
}
