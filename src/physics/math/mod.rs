//! The number type every energy is written over, and 3-vectors and 3×3 blocks of it.
//!
//! An energy is one function over [`Real`]: `f64` gives the reference, [`Lanes`] the fast path, of eight
//! elements at once. nalgebra is not used here because its operators are `#[inline]` only: they must be inlined for certain
//! into functions compiled for a wider instruction set.

mod lanes;
mod matrix;
mod oct;
mod quad;
mod real;
mod simd;
mod vector;

pub use lanes::{Lanes, Pack};
pub use matrix::M3;
pub use oct::{Oct, ROWS, RowKernel};
pub use quad::{Padded, Quad, RowSums};
pub use real::{Real, Scalar};
pub(crate) use simd::{Kernel, dispatch};
pub use vector::V3;
