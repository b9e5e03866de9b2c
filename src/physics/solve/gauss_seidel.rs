//! Sweeps of block Gauss–Seidel (Saad 2003, section 4.1), side by side in the parts of a matrix.
//!
//! `A = D + L + Lᵀ + C`, where L couples rows of one part and C rows of different parts: C enters as of before the sweep
//! (block Jacobi over parts, Gauss–Seidel within). A part of the norms of its blocks comes on top of the diagonal, R, so that
//! the sweeps still reduce the error (Baker, Falgout, Kolev & Yang 2011, section 4.1): half of them would do whatever C is, a
//! quarter does if D is no less than half of C, and costs fewer iterations.

use super::preconditioner::invert;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{DotSum, Kernel, M3, Padded, RowSums, Scalar, dispatch};

/// Forward and backward sweeps. A forward sweep from zero, any symmetric positive semidefinite correction, and a
/// backward sweep are a symmetric preconditioner.
#[derive(Clone, Debug)]
pub(super) struct GaussSeidel<T: Scalar> {
    /// (D + R)⁻¹.
    inverses: Vec<M3<T>>,
    /// R, a multiple of the identity for each row.
    raised: Vec<T>,
    /// A residual, or sums for rows not reached yet.
    sums: Vec<Padded<T>>,
}

impl<T: Scalar> GaussSeidel<T> {
    /// For matrices of a pattern.
    pub fn new(pattern: &BlockPattern) -> Self {
        let rows = pattern.row_count();
        Self { inverses: vec![M3::zero(); rows], raised: vec![T::zero(); rows], sums: vec![Padded::zero(); rows] }
    }

    /// Adapts to a new matrix.
    pub fn update(&mut self, a: &BlockCsr<T>) {
        let Self { inverses, raised, .. } = self;
        for_parts(a.pattern().parts(), (&mut inverses[..], &mut raised[..]), &|part: &Part, (diagonal, raised)| {
            diagonal.copy_from_slice(&a.diagonal[part.rows.clone()]);
            if a.pattern().parts().len() > 1 {
                coupling_across(a, part, raised);
                for (diagonal, raised) in diagonal.iter_mut().zip(raised) {
                    *diagonal = diagonal.add_diagonal(*raised);
                }
            }
            invert(diagonal);
        });
    }

    /// Solves `(D + R + L) z = r`, a forward sweep from zero, and returns the residual that it leaves,
    /// `r − A z = (R − Lᵀ − C) z`.
    pub fn forward(&mut self, a: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> &[Padded<T>] {
        let Self { inverses, raised, sums } = self;
        let parts = a.pattern().parts();
        for_parts(parts, &mut *z, &|part: &Part, z| dispatch(Forward { a, inverses, part, r, z }));
        let z = &*z;
        for_parts(parts, &mut sums[..], &|part: &Part, out| dispatch(Rest { a, raised, part, z, out, inner: true }));
        sums
    }

    /// Solves `(D + R + Lᵀ) z' = r + (R − L − C) z`, a backward sweep from z; returns rᵀ z'.
    pub fn backward(&mut self, a: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> f64 {
        let Self { inverses, raised, sums } = self;
        let (parts, old) = (a.pattern().parts(), &*z);
        for_parts(parts, &mut sums[..], &|part: &Part, out| {
            dispatch(Rest { a, raised, part, z: old, out, inner: false });
        });
        for_parts(parts, (z, &mut sums[..]), &|part: &Part, (z, sums)| {
            dispatch(Backward { a, inverses, part, r, z, sums })
        })
    }
}

/// A quarter of the norms of the blocks by which the rows of a part are coupled with others.
fn coupling_across<T: Scalar>(a: &BlockCsr<T>, part: &Part, sums: &mut [T]) {
    let (pattern, first, share) = (a.pattern(), part.rows.start, T::splat(0.25));
    for (sum, row) in sums.iter_mut().zip(part.rows.clone()) {
        *sum = T::zero();
        for slot in pattern.row_in_parts(row).0 {
            *sum += share * norm(&a.lower[slot]);
        }
    }
    for crossing in &pattern.incoming()[part.incoming.clone()] {
        sums[crossing.column as usize - first] += share * norm(&a.lower[crossing.slot as usize]);
    }
}

/// Frobenius norm.
fn norm<T: Scalar>(block: &M3<T>) -> T {
    let [a, b, c] = block.rows();
    (a.norm_squared() + b.norm_squared() + c.norm_squared()).sqrt()
}

struct Forward<'a, T: Scalar> {
    a: &'a BlockCsr<T>,
    inverses: &'a [M3<T>],
    part: &'a Part,
    r: &'a [Padded<T>],
    z: &'a mut [Padded<T>],
}

impl<T: Scalar> Kernel for Forward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { a, inverses, part, r, z } = self;
        for row in part.rows.clone() {
            z[row - part.rows.start] = solve_diagonal(&inverses[row], left(a, part, row, r, z));
        }
    }
}

/// `(R − Lᵀ − C) z`, or without the inner couplings `(R − C) z`.
struct Rest<'a, T: Scalar> {
    a: &'a BlockCsr<T>,
    raised: &'a [T],
    part: &'a Part,
    z: &'a [Padded<T>],
    out: &'a mut [Padded<T>],
    inner: bool,
}

impl<T: Scalar> Kernel for Rest<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { a, raised, part, z, out, inner } = self;
        let (pattern, first) = (a.pattern(), part.rows.start);
        let columns = pattern.columns();
        let alone = pattern.parts().len() == 1;
        if alone && !inner {
            out.fill(Padded::zero());
            return;
        }
        for row in part.rows.clone() {
            let (crossing, own) = pattern.row_in_parts(row);
            let mut sums = RowSums::zero();
            for (block, &column) in a.lower[crossing.clone()].iter().zip(&columns[crossing]) {
                sums.add(block, z[column as usize]);
            }
            out[row - first] = if alone { Padded::zero() } else { z[row] * raised[row] - sums.total() };
            if inner {
                let z = -z[row];
                for (block, &column) in a.lower[own.clone()].iter().zip(&columns[own]) {
                    out[column as usize - first] += block.transposed_times(z);
                }
            }
        }
        for crossing in &pattern.incoming()[part.incoming.clone()] {
            let product = a.lower[crossing.slot as usize].transposed_times(z[crossing.row as usize]);
            out[crossing.column as usize - first] -= product;
        }
        for out in out {
            *out = out.truncated();
        }
    }
}

/// `r − L z` in a row.
#[inline(always)]
fn left<T: Scalar>(a: &BlockCsr<T>, part: &Part, row: usize, r: &[Padded<T>], z: &[Padded<T>]) -> Padded<T> {
    let inner = a.pattern().row_in_parts(row).1;
    let mut sums = RowSums::zero();
    for (block, &column) in a.lower[inner.clone()].iter().zip(&a.pattern().columns()[inner]) {
        sums.add(block, z[column as usize - part.rows.start]);
    }
    r[row] - sums.total()
}

/// The inverse is symmetric, and its transpose multiplies faster.
#[inline(always)]
fn solve_diagonal<T: Scalar>(inverse: &M3<T>, x: Padded<T>) -> Padded<T> {
    inverse.transposed_times(x).truncated()
}

struct Backward<'a, T: Scalar> {
    a: &'a BlockCsr<T>,
    inverses: &'a [M3<T>],
    part: &'a Part,
    r: &'a [Padded<T>],
    z: &'a mut [Padded<T>],
    /// (R − C) z, to which −Lᵀ z' comes row by row.
    sums: &'a mut [Padded<T>],
}

impl<T: Scalar> Kernel for Backward<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { a, inverses, part, r, z, sums } = self;
        let (pattern, first) = (a.pattern(), part.rows.start);
        let columns = pattern.columns();
        let mut product = DotSum::zero();
        let mut next = part.rows.clone().next_back().map(|row| left(a, part, row, r, z));
        for row in part.rows.clone().rev() {
            let Some(rest) = next else { break };
            let solved = solve_diagonal(&inverses[row], rest + sums[row - first]);
            z[row - first] = solved;
            product.add(r[row], solved);
            // What the next row takes from before the sweep does not depend on this one: the processor may begin with it.
            next = (row > first).then(|| left(a, part, row - 1, r, z));
            let inner = pattern.row_in_parts(row).1;
            let negative = -solved;
            for (block, &column) in a.lower[inner.clone()].iter().zip(&columns[inner]) {
                sums[column as usize - first] += block.transposed_times(negative);
            }
        }
        product.total()
    }
}
