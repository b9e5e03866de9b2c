//! The number trait of the energies.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use wide::{f32x4, f64x4};

use super::Quad;
use super::oct::{RowKernel, dispatch_f32, dispatch_f64};

/// A real number, or several side by side (one per element of a batch).
///
/// Branches on values are written with [`Real::if_positive`], so that the same source serves one lane and many.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// The type of one lane.
    type Scalar: Scalar;
    /// One quad per lane.
    type Quads: AsRef<[<Self::Scalar as Scalar>::Quad]>;
    /// Number of lanes.
    const LANES: usize;

    /// The same value in every lane.
    fn splat(value: f64) -> Self;
    /// Lane `i` is `f(i)`.
    fn from_lanes(f: impl FnMut(usize) -> Self::Scalar) -> Self;
    /// Number k of lane `i` is `f(i)[k]`.
    fn from_rows<const K: usize>(f: impl FnMut(usize) -> [Self::Scalar; K]) -> [Self; K];
    /// What the four have in each lane.
    fn quads(four: [Self; 4]) -> Self::Quads;
    /// Value of lane `i`.
    fn lane(self, i: usize) -> Self::Scalar;
    /// Square root.
    fn sqrt(self) -> Self;
    /// The larger of two.
    fn max(self, other: Self) -> Self;
    /// The smaller of two.
    fn min(self, other: Self) -> Self;
    /// Angle of the vector (`x`, `self`) in radians, in (−π, π].
    fn atan2(self, x: Self) -> Self;
    /// `yes` where `self` > 0, `no` elsewhere (and where `self` is NaN).
    fn if_positive(self, yes: Self, no: Self) -> Self;

    /// Zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// Sum of the lanes, in f64.
    #[inline(always)]
    fn sum_lanes(self) -> f64 {
        let mut sum = 0.0;
        for i in 0..Self::LANES {
            sum += self.lane(i).to_f64();
        }
        sum
    }
}

/// A [`Real`] of one lane: the entries of the matrix and of the vectors.
pub trait Scalar: Real<Scalar = Self> + PartialOrd {
    /// Four of them side by side.
    type Quad: Quad<Self>;
    /// Rounds to this precision.
    fn from_f64(value: f64) -> Self;
    /// Widens to f64.
    fn to_f64(self) -> f64;
    /// Runs a kernel in its version for this machine.
    fn dispatch<K: RowKernel<Self>>(kernel: K) -> K::Output;
}

macro_rules! impl_scalar {
    ($t:ty, $quad:ty, $dispatch:path) => {
        impl Real for $t {
            type Scalar = $t;
            type Quads = [$quad; 1];
            const LANES: usize = 1;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn from_lanes(mut f: impl FnMut(usize) -> $t) -> Self {
                f(0)
            }
            #[inline(always)]
            fn from_rows<const K: usize>(mut f: impl FnMut(usize) -> [$t; K]) -> [Self; K] {
                f(0)
            }
            #[inline(always)]
            fn quads(four: [Self; 4]) -> Self::Quads {
                [<$quad>::new(four)]
            }
            #[inline(always)]
            fn lane(self, _: usize) -> $t {
                self
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$t>::sqrt(self)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                <$t>::atan2(self, x)
            }
            #[inline(always)]
            fn if_positive(self, yes: Self, no: Self) -> Self {
                if self > 0.0 { yes } else { no }
            }
        }

        impl Scalar for $t {
            type Quad = $quad;

            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn dispatch<K: RowKernel<Self>>(kernel: K) -> K::Output {
                $dispatch(kernel)
            }
        }
    };
}

impl_scalar!(f32, f32x4, dispatch_f32);
impl_scalar!(f64, f64x4, dispatch_f64);
