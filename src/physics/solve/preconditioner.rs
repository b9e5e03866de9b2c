//! Approximate inverses of A.

use crate::physics::assembly::BlockCsr;
use crate::physics::math::{Kernel, M3, Padded, Scalar, dispatch};

/// A symmetric positive definite approximation P⁻¹ of A⁻¹.
pub trait Preconditioner<T: Scalar>: Send + Sync {
    /// Adapts to a new matrix of the same pattern, not yet interleaved.
    fn update(&mut self, a: &BlockCsr<T>);
    /// `z = P⁻¹ r`, for the matrix that it was last adapted to, now interleaved; returns rᵀ z.
    fn apply(&mut self, a: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> f64;
}

impl<T: Scalar> Preconditioner<T> for Box<dyn Preconditioner<T>> {
    fn update(&mut self, a: &BlockCsr<T>) {
        (**self).update(a);
    }

    fn apply(&mut self, a: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> f64 {
        (**self).apply(a, r, z)
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
            *inverse = a.diagonal(row);
        }
        invert(&mut self.inverses);
    }

    fn apply(&mut self, _: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> f64 {
        let mut product = 0.0;
        for ((z, inverse), &r) in z.iter_mut().zip(&self.inverses).zip(r) {
            *z = inverse.times(r);
            product += r.dot_f64(*z);
        }
        product
    }
}

/// Replaces symmetric positive definite blocks by their inverses.
pub(super) fn invert<T: Scalar>(blocks: &mut [M3<T>]) {
    dispatch(Invert { blocks });
}

struct Invert<'a, T> {
    blocks: &'a mut [M3<T>],
}

impl<T: Scalar> Kernel for Invert<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for block in self.blocks {
            let floors = [0, 1, 2].map(|i| T::from_f64(SAFE_PIVOT) * block.0[i][i]);
            *block = inverse_above(block, floors).unwrap_or_else(|| positive_inverse(block));
        }
    }
}

/// Smallest pivot of a diagonal block, relative to the diagonal entry, with which its inverse is right in f32.
const SAFE_PIVOT: f64 = 1e-3;

/// Smallest pivot of a diagonal block taken as it is, relative to the diagonal entry: a few roundings of f32.
const MIN_PIVOT: f64 = 1e-6;

/// The inverse of a symmetric block that is positive definite but for rounding: if it is not, its diagonal is raised
/// until it is. In f64, as the block may be close to singular in f32.
#[cold]
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
    // The determinant of a block of grams would vanish in f32, so the magnitude is taken out first.
    let scale = T::from_f64(1.0) / block.0[0][0].max(block.0[1][1]).max(block.0[2][2]);
    let [[a, b, c], [_, d, e], [_, _, f]] = (*block * scale).0;
    let [p, q, r] = floors.map(|floor| (floor * scale).max(T::zero()));
    // Cofactors; the pivots are a, minor/a and determinant/minor.
    let (ca, cb, cc) = (d * f - e * e, c * e - b * f, b * e - c * d);
    let minor = a * d - b * b;
    let determinant = a * ca + b * cb + c * cc;
    let positive = a > p && minor > q * a && determinant > r * minor && minor > T::zero() && determinant > T::zero();
    let inverse = scale / determinant;
    let (cd, ce) = (a * f - c * c, b * c - a * e);
    positive.then(|| M3([[ca, cb, cc], [cb, cd, ce], [cc, ce, minor]]) * inverse)
}
