//! How the rows of a [`Slice`] are read from vectors and written to them.

pub(crate) use super::pattern::Slice;
use crate::physics::math::{Oct, Padded, ROWS, Scalar};

/// The rows of a slice in a vector that begins at row `first`. Beyond the last row of the slice it is that row again.
#[inline(always)]
pub(crate) fn load<T: Scalar, S: Oct<T>>(s: S, slice: &Slice, first: usize, x: &[Padded<T>]) -> [S::V; 3] {
    let x = &x[slice.first_row as usize - first..];
    let last = slice.rows as usize - 1;
    match x.first_chunk() {
        Some(rows) if last == ROWS - 1 => s.turn(*rows),
        _ => {
            let mut rows = [x[last]; ROWS];
            rows[..last].copy_from_slice(&x[..last]);
            s.turn(rows)
        }
    }
}

/// Overwrites the rows of a slice.
#[inline(always)]
pub(crate) fn store<T: Scalar, S: Oct<T>>(s: S, slice: &Slice, first: usize, xyz: [S::V; 3], y: &mut [Padded<T>]) {
    let y = &mut y[slice.first_row as usize - first..];
    let rows = s.turn_back(xyz);
    match y.first_chunk_mut() {
        Some(y) if slice.rows as usize == ROWS => *y = rows,
        _ => y.iter_mut().zip(rows).take(slice.rows as usize).for_each(|(y, row)| *y = row),
    }
}

/// The rows of these columns.
#[inline(always)]
pub(crate) fn gather<T: Scalar, S: Oct<T>>(s: S, columns: &[u32; ROWS], first: usize, x: &[Padded<T>]) -> [S::V; 3] {
    let mut rows = [Padded::zero(); ROWS];
    for (row, &column) in rows.iter_mut().zip(columns) {
        *row = x[column as usize - first];
    }
    s.turn(rows)
}

/// Adds to the rows of these columns.
#[inline(always)]
pub(crate) fn scatter_add<T: Scalar, S: Oct<T>>(
    s: S,
    columns: &[u32; ROWS],
    first: usize,
    xyz: [S::V; 3],
    y: &mut [Padded<T>],
) {
    for (&column, row) in columns.iter().zip(s.turn_back(xyz)) {
        y[column as usize - first] += row;
    }
}

/// `Σ xᵀ y` under way, in f64.
pub(crate) struct Sum([f64; ROWS]);

impl Sum {
    /// Nothing yet.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([0.0; ROWS])
    }

    /// Adds the products of [`ROWS`] rows.
    #[inline(always)]
    pub fn add<T: Scalar, S: Oct<T>>(&mut self, s: S, x: [S::V; 3], y: [S::V; 3]) {
        let products = s.mul_add(x[2], y[2], s.mul_add(x[1], y[1], s.mul(x[0], y[0])));
        for (sum, product) in self.0.iter_mut().zip(s.store(products)) {
            *sum += product.to_f64();
        }
    }

    /// The sum.
    #[inline(always)]
    pub fn total(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }
}
