//! Pins, exactly: a pinned vertex is no unknown.

use super::pattern::Crossing;
use super::{BlockCsr, BlockPattern};
use crate::physics::math::{M3, Padded, Scalar};

/// Which vertices are pinned, and what in the matrix couples them.
#[derive(Clone, Debug, Default)]
pub struct Constraints {
    pinned: Vec<bool>,
    rows: Vec<u32>,
    couplings: Vec<Crossing>,
}

impl Constraints {
    /// Pins these vertices and no others. What they are coupled with is looked up only if they are others than before.
    pub fn set(&mut self, pattern: &BlockPattern, pinned: &[bool]) {
        if self.pinned == pinned {
            return;
        }
        self.pinned.clear();
        self.pinned.extend_from_slice(pinned);
        self.rows.clear();
        self.couplings.clear();
        for row in 0..pinned.len() {
            if pinned[row] {
                self.rows.push(row as u32);
            }
            for slot in pattern.row(row) {
                let column = pattern.column(slot);
                if pinned[row] || pinned[column as usize] {
                    self.couplings.push(Crossing { column, row: row as u32, slot: slot as u32 });
                }
            }
        }
    }

    /// Turns `A d = b` into the system of the free vertices, with `d` given at the pinned ones: their columns move to the
    /// right-hand side, their rows become `I d = prescribed`. The matrix stays symmetric positive definite, so every solver
    /// and preconditioner works on it unchanged, and the answer at a pin is the prescribed one to the last bit.
    pub fn apply<T: Scalar>(&self, a: &mut BlockCsr<T>, b: &mut [Padded<T>], prescribed: impl Fn(usize) -> Padded<T>) {
        for &Crossing { column, row, slot } in &self.couplings {
            let (row, column) = (row as usize, column as usize);
            let block = a.block(slot as usize);
            a.set_block(slot as usize, M3::zero());
            if !self.pinned[row] {
                b[row] -= block.times(prescribed(column));
            } else if !self.pinned[column] {
                b[column] -= block.transposed_times(prescribed(row));
            }
        }
        for row in self.rows.iter().map(|&row| row as usize) {
            a.fixed[row] = true;
            a.set_diagonal(row, M3::scaled_identity(T::from_f64(1.0)));
            b[row] = prescribed(row);
        }
    }
}

/// [`Constraints::apply`], once.
pub fn constrain<T: Scalar>(
    a: &mut BlockCsr<T>,
    b: &mut [Padded<T>],
    pinned: &[bool],
    prescribed: impl Fn(usize) -> Padded<T>,
) {
    let mut constraints = Constraints::default();
    constraints.set(a.pattern(), pinned);
    constraints.apply(a, b, prescribed);
}
