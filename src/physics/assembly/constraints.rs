//! Pins, exactly: a pinned vertex is no unknown.

use super::BlockCsr;
use crate::physics::math::{M3, Scalar, V3};

/// Turns `A d = b` into the system of the free vertices, with `d` given at the pinned ones: their columns move to the
/// right-hand side, their rows become `I d = prescribed`. The matrix stays symmetric positive definite, so every solver and
/// preconditioner works on it unchanged, and the answer at a pin is the prescribed one to the last bit.
pub fn constrain<T: Scalar>(
    a: &mut BlockCsr<T>,
    b: &mut [V3<T>],
    pinned: &[bool],
    prescribed: impl Fn(usize) -> V3<T>,
) {
    for row in 0..b.len() {
        if pinned[row] {
            for (_, block) in a.row_mut(row) {
                *block = M3::zero();
            }
            *a.diagonal_mut(row) = M3::scaled_identity(T::splat(1.0));
            b[row] = prescribed(row);
        } else {
            for (column, block) in a.row_mut(row) {
                let column = column as usize;
                if pinned[column] {
                    b[row] -= block.mul_vector(prescribed(column));
                    *block = M3::zero();
                }
            }
        }
    }
}
