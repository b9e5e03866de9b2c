//! A sparse symmetric matrix of 3×3 blocks.

use std::sync::Arc;

use super::BlockPattern;
use crate::physics::math::{Kernel, M3, Scalar, V3, dispatch};

/// Block compressed sparse rows, both halves stored: at cloth's 13 or so blocks a row this multiplies faster than one half.
#[derive(Clone, Debug)]
pub struct BlockCsr<T> {
    pattern: Arc<BlockPattern>,
    /// The blocks, by slot.
    pub blocks: Vec<M3<T>>,
}

impl<T: Scalar> BlockCsr<T> {
    /// The zero matrix of a pattern.
    pub fn zero(pattern: Arc<BlockPattern>) -> Self {
        let blocks = vec![M3::zero(); pattern.block_count()];
        Self { pattern, blocks }
    }

    /// The pattern.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// Sets every block to zero.
    pub fn clear(&mut self) {
        self.blocks.fill(M3::zero());
    }

    /// The diagonal block of a row.
    #[inline]
    pub fn diagonal(&self, row: usize) -> M3<T> {
        self.blocks[self.pattern.diagonals()[row] as usize]
    }

    /// The diagonal block of a row.
    #[inline]
    pub fn diagonal_mut(&mut self, row: usize) -> &mut M3<T> {
        &mut self.blocks[self.pattern.diagonals()[row] as usize]
    }

    /// Columns and blocks of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> impl Iterator<Item = (u32, &M3<T>)> {
        let range = self.pattern.row(row);
        self.pattern.columns()[range.clone()].iter().copied().zip(&self.blocks[range])
    }

    /// Columns and blocks of a row.
    #[inline]
    pub fn row_mut(&mut self, row: usize) -> impl Iterator<Item = (u32, &mut M3<T>)> {
        let range = self.pattern.row(row);
        self.pattern.columns()[range.clone()].iter().copied().zip(&mut self.blocks[range])
    }

    /// `y = A x`.
    pub fn multiply(&self, x: &[V3<T>], y: &mut [V3<T>]) {
        dispatch(Multiply { a: self, x, y });
    }
}

struct Multiply<'a, T> {
    a: &'a BlockCsr<T>,
    x: &'a [V3<T>],
    y: &'a mut [V3<T>],
}

impl<T: Scalar> Kernel for Multiply<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (row, y) in self.y.iter_mut().enumerate() {
            let mut sum = V3::zero();
            for (column, block) in self.a.row(row) {
                sum += block.mul_vector(self.x[column as usize]);
            }
            *y = sum;
        }
    }
}
