//! Approximate inverses of A.

use crate::physics::assembly::BlockCsr;
use crate::physics::math::{M3, Scalar, V3};

/// A symmetric positive definite approximation P⁻¹ of A⁻¹.
pub trait Preconditioner<T: Scalar>: Send + Sync {
    /// Adapts to a new matrix of the same pattern.
    fn update(&mut self, a: &BlockCsr<T>);
    /// `z = P⁻¹ r`.
    fn apply(&mut self, r: &[V3<T>], z: &mut [V3<T>]);
}

impl<T: Scalar> Preconditioner<T> for Box<dyn Preconditioner<T>> {
    fn update(&mut self, a: &BlockCsr<T>) {
        (**self).update(a);
    }

    fn apply(&mut self, r: &[V3<T>], z: &mut [V3<T>]) {
        (**self).apply(r, z);
    }
}

/// The inverses of the diagonal blocks.
#[derive(Clone, Debug)]
pub struct BlockJacobi<T> {
    inverses: Vec<M3<T>>,
}

impl<T: Scalar> BlockJacobi<T> {
    /// For matrices of `rows` block rows.
    pub fn new(rows: usize) -> Self {
        Self { inverses: vec![M3::zero(); rows] }
    }
}

impl<T: Scalar> Preconditioner<T> for BlockJacobi<T> {
    fn update(&mut self, a: &BlockCsr<T>) {
        for (row, inverse) in self.inverses.iter_mut().enumerate() {
            *inverse = positive_inverse(&a.diagonal(row));
        }
    }

    fn apply(&mut self, r: &[V3<T>], z: &mut [V3<T>]) {
        for ((z, inverse), &r) in z.iter_mut().zip(&self.inverses).zip(r) {
            *z = inverse.mul_vector(r);
        }
    }
}

/// Smallest pivot of a diagonal block taken as it is, relative to the diagonal entry: a few roundings of f32.
const MIN_PIVOT: f64 = 1e-6;

/// The inverse of a symmetric block that is positive definite but for rounding: if it is not, its diagonal is raised
/// until it is. In f64, as the block may be close to singular in f32.
pub(super) fn positive_inverse<T: Scalar>(block: &M3<T>) -> M3<T> {
    let block = M3(block.0.map(|row| row.map(T::to_f64)));
    let scale = block.0[0][0].max(block.0[1][1]).max(block.0[2][2]);
    // The off-diagonal entries of a block that has to be raised further than this count for nothing.
    let inverse = [0.0, 1e-5, 1e-3]
        .into_iter()
        .find_map(|shift| {
            let raised = block.add_diagonal(shift * scale);
            inverse_above(&raised, [0, 1, 2].map(|i| MIN_PIVOT * raised.0[i][i]))
        })
        .unwrap_or(M3::scaled_identity(1.0 / scale.abs()));
    M3(inverse.0.map(|row| row.map(T::from_f64)))
}

/// The inverse of a symmetric block, if the pivots of its LDLᵀ are above these and positive.
#[inline(always)]
pub(super) fn inverse_above<T: Scalar>(block: &M3<T>, floors: [T; 3]) -> Option<M3<T>> {
    let [[a, b, c], [_, d, e], [_, _, f]] = block.0;
    let (l1, l2) = (b / a, c / a);
    let d1 = d - l1 * b;
    let l3 = (e - l1 * c) / d1;
    let d2 = f - l2 * c - l3 * (e - l1 * c);
    let positive = |pivot: T, floor: T| pivot > floor.max(T::zero());
    (positive(a, floors[0]) && positive(d1, floors[1]) && positive(d2, floors[2])).then(|| block.scaled_inverse())
}
