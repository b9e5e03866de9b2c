//! Matrices of cloths as dense ones.

use bevy_cloth::physics::assembly::BlockEll;
use bevy_cloth::physics::math::{M3, Scalar};
use nalgebra::DMatrix;

/// All of a matrix that is not interleaved: blocks and scalars.
pub fn dense<T: Scalar>(matrix: &BlockEll<T>) -> DMatrix<f64> {
    let (rows, far) = (matrix.pattern().row_count(), matrix.pattern().far());
    let mut a = DMatrix::zeros(3 * rows, 3 * rows);
    let mut add = |row: usize, column: usize, block: M3<T>| {
        for (r, entries) in block.0.iter().enumerate() {
            for (c, entry) in entries.iter().enumerate() {
                a[(3 * row + r, 3 * column + c)] += entry.to_f64();
            }
        }
    };
    for row in 0..rows {
        add(row, row, matrix.diagonal(row));
        for (column, block) in matrix.lower_row(row) {
            add(row, column as usize, block);
            add(column as usize, row, block.transpose());
        }
        for entry in far.row(row) {
            let scalar = M3::scaled_identity(matrix.far()[entry]);
            add(row, far.column(entry) as usize, scalar);
            add(row, row, -scalar);
        }
    }
    a
}
