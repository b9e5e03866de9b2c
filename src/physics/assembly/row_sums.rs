//! The diagonal of A, from what is beside it.
//!
//! A uniform translation strains nothing, so the blocks of each row of the elastic part of A sum to zero, and the diagonal
//! need not be assembled: it is the inertia less the other blocks of its row. In f32 the sums of rows are then as close to
//! zero as they can be, which assembled diagonals miss by the rounding of each element.

use super::{BlockPattern, Group, Part};
use crate::physics::math::{Flat, Kernel, ROWS, Scalar};

/// Fills the diagonal blocks of a part, which hold the inertia already.
pub(super) struct SubtractRows<'a, T: Scalar> {
    pub pattern: &'a BlockPattern,
    pub part: &'a Part,
    pub lower: &'a [Group<T>],
    /// By slice of the part.
    pub diagonal: &'a mut [Group<T>],
}

impl<T: Scalar> Kernel for SubtractRows<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pattern, part, lower, diagonal } = self;
        let first = part.slices.start;
        for row in part.rows.clone() {
            let own = pattern.diagonal(row);
            let mut sum = Flat::zero();
            for slot in pattern.row(row) {
                let block = lower[slot / ROWS].block(slot % ROWS).flat();
                sum = sum - block;
                let column = pattern.column(slot) as usize;
                if column >= part.rows.start {
                    let other = pattern.diagonal(column);
                    diagonal[other / ROWS - first].add(other % ROWS, -block.transpose());
                }
            }
            diagonal[own / ROWS - first].add(own % ROWS, sum);
        }
        for crossing in &pattern.incoming()[part.incoming.clone()] {
            let (slot, other) = (crossing.slot as usize, pattern.diagonal(crossing.column as usize));
            let block = lower[slot / ROWS].block(slot % ROWS).flat();
            diagonal[other / ROWS - first].add(other % ROWS, -block.transpose());
        }
    }
}
