//! A sparse symmetric matrix of 3×3 blocks.

use std::sync::Arc;

use super::BlockPattern;
use super::parts::{Part, for_parts};
use crate::physics::math::{DotSum, Kernel, M3, Padded, RowSums, Scalar, dispatch};

/// Symmetric block compressed sparse rows, A = L + D + Lᵀ: the diagonal, and the lower half. One pass over L serves both
/// halves.
#[derive(Clone, Debug)]
pub struct BlockCsr<T> {
    pattern: Arc<BlockPattern>,
    /// D, by row.
    pub diagonal: Vec<M3<T>>,
    /// L, by slot.
    pub lower: Vec<M3<T>>,
    /// Rows that are coupled with no others: those of pins, once taken out.
    pub fixed: Vec<bool>,
}

impl<T: Scalar> BlockCsr<T> {
    /// The zero matrix of a pattern.
    pub fn zero(pattern: Arc<BlockPattern>) -> Self {
        let diagonal = vec![M3::zero(); pattern.row_count()];
        let lower = vec![M3::zero(); pattern.lower_count()];
        let fixed = vec![false; pattern.row_count()];
        Self { pattern, diagonal, lower, fixed }
    }

    /// The pattern.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// Columns and blocks of a row left of the diagonal.
    #[inline(always)]
    pub fn lower_row(&self, row: usize) -> impl Iterator<Item = (u32, &M3<T>)> {
        let range = self.pattern.row(row);
        self.pattern.columns()[range.clone()].iter().copied().zip(&self.lower[range])
    }

    /// `y = A x`; returns xᵀ A x.
    pub fn multiply(&self, x: &[Padded<T>], y: &mut [Padded<T>]) -> f64 {
        for_parts(self.pattern.parts(), y, &|part: &Part, y| dispatch(Multiply { a: self, part, x, y }))
    }
}

struct Multiply<'a, T: Scalar> {
    a: &'a BlockCsr<T>,
    part: &'a Part,
    x: &'a [Padded<T>],
    y: &'a mut [Padded<T>],
}

impl<T: Scalar> Kernel for Multiply<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { a, part, x, y } = self;
        let (pattern, first) = (&*a.pattern, part.rows.start);
        let columns = pattern.columns();
        for row in part.rows.clone() {
            let own = x[row];
            let (crossing, inner) = pattern.row_in_parts(row);
            let mut sums = RowSums::zero();
            sums.add(&a.diagonal[row], own);
            for (block, &column) in a.lower[crossing.clone()].iter().zip(&columns[crossing]) {
                sums.add(block, x[column as usize]);
            }
            for (block, &column) in a.lower[inner.clone()].iter().zip(&columns[inner]) {
                sums.add(block, x[column as usize]);
                y[column as usize - first] += block.transposed_times(own);
            }
            y[row - first] = sums.total();
        }
        for crossing in &pattern.incoming()[part.incoming.clone()] {
            let block = &a.lower[crossing.slot as usize];
            y[crossing.column as usize - first] += block.transposed_times(x[crossing.row as usize]);
        }
        let mut product = DotSum::zero();
        for (y, &x) in y.iter_mut().zip(&x[part.rows.clone()]) {
            *y = y.truncated();
            product.add(x, *y);
        }
        product.total()
    }
}
