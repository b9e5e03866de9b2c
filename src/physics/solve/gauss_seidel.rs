//! Sweeps of block Gauss–Seidel (Saad 2003, section 4.1), side by side in the parts of a matrix.
//!
//! `A = D + L + Lᵀ + C`, where L couples rows of one part and C rows of different parts: C enters as of before the sweep
//! (block Jacobi over parts, Gauss–Seidel within). A part of the norms of its blocks comes on top of the diagonal, R, so that
//! the sweeps still reduce the error (Baker, Falgout, Kolev & Yang 2011, section 4.1): `D + 2 R − C` has to be positive
//! definite. Half of the norms would do whatever C is; a tenth does where C is no more than most of D, as in a cloth, of which a
//! vertex on a boundary has half of its neighbours on its own side, and costs fewer iterations.
//!
//! The rows of a slice are not coupled, so a sweep takes them at once.

use super::preconditioner::invert;
use crate::physics::assembly::parts::{BySlice, Part, for_parts};
use crate::physics::assembly::slice::{self, Slice, Sum};
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{M3, Oct, Padded, ROWS, RowKernel, Scalar};

/// Forward and backward sweeps. A forward sweep from zero, any symmetric positive semidefinite correction, and a
/// backward sweep are a symmetric preconditioner.
#[derive(Clone, Debug)]
pub(super) struct GaussSeidel<T: Scalar> {
    pivots: Vec<Pivots<T>>,
    /// A residual, or sums for rows not reached yet.
    sums: Vec<Padded<T>>,
}

/// What the rows of a slice are divided by.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
struct Pivots<T> {
    /// (D + R)⁻¹, which is symmetric: entries 00, 01, 02, 11, 12, 22. Zero beyond the last row.
    inverse: [[T; ROWS]; 6],
    /// R, a multiple of the identity for each row.
    raised: [T; ROWS],
}

impl<T: Scalar> Pivots<T> {
    fn zero() -> Self {
        Self { inverse: [[T::zero(); ROWS]; 6], raised: [T::zero(); ROWS] }
    }

    #[inline(always)]
    fn divide<S: Oct<T>>(&self, s: S, [x, y, z]: [S::V; 3]) -> [S::V; 3] {
        let [a, b, c, d, e, f] = &self.inverse;
        let (a, b, c, d, e, f) = (s.load(a), s.load(b), s.load(c), s.load(d), s.load(e), s.load(f));
        [
            s.mul_add(c, z, s.mul_add(b, y, s.mul(a, x))),
            s.mul_add(e, z, s.mul_add(d, y, s.mul(b, x))),
            s.mul_add(f, z, s.mul_add(e, y, s.mul(c, x))),
        ]
    }
}

impl<T: Scalar> GaussSeidel<T> {
    /// For matrices of a pattern, of which the rows of a slice are independent.
    pub fn new(pattern: &BlockPattern) -> Self {
        Self { pivots: vec![Pivots::zero(); pattern.slices().len()], sums: vec![Padded::zero(); pattern.row_count()] }
    }

    /// Adapts to a new matrix, not yet interleaved.
    pub fn update(&mut self, a: &BlockCsr<T>) {
        let pattern = &**a.pattern();
        for_parts(pattern.parts(), BySlice(&mut self.pivots), &|part: &Part, BySlice(pivots)| {
            for (pivots, slice) in pivots.iter_mut().zip(&pattern.slices()[part.slices.clone()]) {
                let mut blocks = [M3::zero(); ROWS];
                let blocks = &mut blocks[..slice.rows as usize];
                for (lane, block) in blocks.iter_mut().enumerate() {
                    let row = slice.first_row as usize + lane;
                    *block = a.diagonal(row);
                    if pattern.parts().len() > 1 {
                        pivots.raised[lane] = coupling_across(a, part, row);
                        *block = block.add_diagonal(pivots.raised[lane]);
                    }
                }
                invert(blocks);
                for (lane, block) in blocks.iter().enumerate() {
                    let [[a, b, c], [_, d, e], [_, _, f]] = block.0;
                    for (entry, value) in pivots.inverse.iter_mut().zip([a, b, c, d, e, f]) {
                        entry[lane] = value;
                    }
                }
            }
        });
    }

    /// Solves `(D + R + L) z = r`, a forward sweep from zero, and returns the residual that it leaves,
    /// `r − A z = (R − Lᵀ − C) z`.
    pub fn forward(&mut self, a: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> &[Padded<T>] {
        let Self { pivots, sums } = self;
        let parts = a.pattern().parts();
        for_parts(parts, (&mut *z, &mut sums[..]), &|part: &Part, (z, rest)| {
            T::dispatch(Forward { a, pivots, part, r, z, rest });
        });
        let z = &*z;
        if parts.len() > 1 {
            for_parts(parts, &mut sums[..], &|part: &Part, out| T::dispatch(Across { a, pivots, part, z, out }));
        }
        sums
    }

    /// Solves `(D + R + Lᵀ) z' = r + (R − L − C) z`, a backward sweep from z; returns rᵀ z'.
    pub fn backward(&mut self, a: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> f64 {
        let Self { pivots, sums } = self;
        let (parts, old) = (a.pattern().parts(), &*z);
        for_parts(parts, &mut sums[..], &|part: &Part, out| {
            out.fill(Padded::zero());
            if parts.len() > 1 {
                T::dispatch(Across { a, pivots, part, z: old, out });
            }
        });
        for_parts(parts, (z, &mut sums[..]), &|part: &Part, (z, sums)| {
            T::dispatch(Backward { a, pivots, part, r, z, sums })
        })
    }
}

/// A tenth of the norms of the blocks by which a row of a part is coupled with others.
fn coupling_across<T: Scalar>(a: &BlockCsr<T>, part: &Part, row: usize) -> T {
    let (pattern, share) = (a.pattern(), T::from_f64(0.1));
    let mut sum = T::zero();
    for slot in pattern.row(row).take_while(|&slot| (pattern.column(slot) as usize) < part.rows.start) {
        sum += share * norm(&a.block(slot));
    }
    let incoming = &pattern.incoming()[part.incoming.clone()];
    let first = incoming.partition_point(|crossing| (crossing.column as usize) < row);
    for crossing in incoming[first..].iter().take_while(|crossing| crossing.column as usize == row) {
        sum += share * norm(&a.block(crossing.slot as usize));
    }
    sum
}

/// Frobenius norm.
fn norm<T: Scalar>(block: &M3<T>) -> T {
    let [a, b, c] = block.rows();
    (a.norm_squared() + b.norm_squared() + c.norm_squared()).sqrt()
}

struct Forward<'a, T: Scalar> {
    a: &'a BlockCsr<T>,
    pivots: &'a [Pivots<T>],
    part: &'a Part,
    r: &'a [Padded<T>],
    z: &'a mut [Padded<T>],
    /// −Lᵀ z.
    rest: &'a mut [Padded<T>],
}

impl<T: Scalar> RowKernel<T> for Forward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        let Self { a, pivots, part, r, z, rest } = self;
        let (pattern, first) = (&**a.pattern(), part.rows.start);
        rest.fill(Padded::zero());
        let slices = part.slices.clone();
        for (slice, pivots) in pattern.slices()[slices.clone()].iter().zip(&pivots[slices]) {
            let sums = left(s, a, first, slice, slice::load(s, slice, 0, r), z);
            let solved = pivots.divide(s, sums);
            slice::store(s, slice, first, solved, z);
            scatter_left(s, a, first, slice, solved, rest);
        }
    }
}

/// Adds `(R − C) z`.
struct Across<'a, T: Scalar> {
    a: &'a BlockCsr<T>,
    pivots: &'a [Pivots<T>],
    part: &'a Part,
    z: &'a [Padded<T>],
    out: &'a mut [Padded<T>],
}

impl<T: Scalar> RowKernel<T> for Across<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        let Self { a, pivots, part, z, out } = self;
        let (pattern, first) = (&**a.pattern(), part.rows.start);
        let slices = part.slices.clone();
        for (slice, pivots) in pattern.slices()[slices.clone()].iter().zip(&pivots[slices]) {
            let (raised, [x, y, w]) = (s.load(&pivots.raised), slice::load(s, slice, 0, z));
            let [a0, a1, a2] = slice::load(s, slice, first, out);
            let mut sums = [s.mul_add(raised, x, a0), s.mul_add(raised, y, a1), s.mul_add(raised, w, a2)];
            for group in slice.crossing as usize..slice.inner as usize {
                let right = slice::gather(s, pattern.columns(group), 0, z);
                sums = a.group(group).mul_sub(s, right, sums);
            }
            slice::store(s, slice, first, sums, out);
        }
        for crossing in &pattern.incoming()[part.incoming.clone()] {
            let slot = crossing.slot as usize;
            let block = a.group(slot / ROWS).interleaved_block(slot % ROWS);
            let product = block.transposed_times(z[crossing.row as usize]);
            out[crossing.column as usize - first] -= product;
        }
    }
}

struct Backward<'a, T: Scalar> {
    a: &'a BlockCsr<T>,
    pivots: &'a [Pivots<T>],
    part: &'a Part,
    r: &'a [Padded<T>],
    z: &'a mut [Padded<T>],
    /// (R − C) z, to which −Lᵀ z' comes slice by slice.
    sums: &'a mut [Padded<T>],
}

impl<T: Scalar> RowKernel<T> for Backward<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) -> f64 {
        let Self { a, pivots, part, r, z, sums } = self;
        let (pattern, first) = (&**a.pattern(), part.rows.start);
        let slices = part.slices.clone();
        let mut product = Sum::zero();
        for (slice, pivots) in pattern.slices()[slices.clone()].iter().zip(&pivots[slices]).rev() {
            let own = slice::load(s, slice, 0, r);
            let ([x, y, w], [a0, a1, a2]) = (own, slice::load(s, slice, first, sums));
            let rest = left(s, a, first, slice, [s.add(x, a0), s.add(y, a1), s.add(w, a2)], z);
            let solved = pivots.divide(s, rest);
            product.add(s, own, solved);
            slice::store(s, slice, first, solved, z);
            scatter_left(s, a, first, slice, solved, sums);
        }
        product.total()
    }
}

/// `sums − L z` in a slice.
#[inline(always)]
fn left<T: Scalar, S: Oct<T>>(
    s: S,
    a: &BlockCsr<T>,
    first: usize,
    slice: &Slice,
    mut sums: [S::V; 3],
    z: &[Padded<T>],
) -> [S::V; 3] {
    for group in slice.inner as usize..slice.end as usize {
        let right = slice::gather(s, a.pattern().columns(group), first, z);
        sums = a.group(group).mul_sub(s, right, sums);
    }
    sums
}

/// Takes `Lᵀ z` of the rows of a slice from the rows left of them.
#[inline(always)]
fn scatter_left<T: Scalar, S: Oct<T>>(
    s: S,
    a: &BlockCsr<T>,
    first: usize,
    slice: &Slice,
    solved: [S::V; 3],
    out: &mut [Padded<T>],
) {
    let zero = s.splat(T::zero());
    let negative = [s.sub(zero, solved[0]), s.sub(zero, solved[1]), s.sub(zero, solved[2])];
    for group in slice.inner as usize..slice.end as usize {
        let product = a.group(group).transposed_mul(s, negative);
        slice::scatter_add(s, a.pattern().columns(group), first, product, out);
    }
}
