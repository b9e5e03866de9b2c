//! The number trait of the energies.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use wide::{f32x4, f64x4};

use super::oct::{Oct, RowKernel, dispatch_f32, dispatch_f64};
use super::{Lanes, Quad};

/// A real number, or several side by side (one per element of a batch).
///
/// Branches on values are written with [`Real::if_positive`], so that the same source serves one number and many.
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
    /// The same value everywhere, of as many numbers as `self`.
    fn splat(self, value: f64) -> Self;
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
}

/// A single [`Real`]: the entries of the matrix and of the vectors.
pub trait Scalar: Real + PartialOrd {
    /// Four of them side by side.
    type Quad: Quad<Self>;
    /// From 1 to the next number.
    const EPSILON: f64;
    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }
    /// Rounds to this precision.
    fn from_f64(value: f64) -> Self;
    /// Widens to f64.
    fn to_f64(self) -> f64;
    /// [`Real::atan2`] of eight.
    fn atan2_of_lanes<S: Oct<Self>>(y: Lanes<Self, S>, x: Lanes<Self, S>) -> Lanes<Self, S>;
    /// Runs a kernel in its version for this machine.
    fn dispatch<K: RowKernel<Self>>(kernel: K) -> K::Output;
}

macro_rules! impl_scalar {
    ($t:ty, $quad:ty, $dispatch:path, $atan2:path, $atan2_of_lanes:path) => {
        impl Real for $t {
            #[inline(always)]
            fn splat(self, value: f64) -> Self {
                value as $t
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
                $atan2(self, x)
            }
            #[inline(always)]
            fn if_positive(self, yes: Self, no: Self) -> Self {
                if self > 0.0 { yes } else { no }
            }
        }

        impl Scalar for $t {
            const EPSILON: f64 = <$t>::EPSILON as f64;
            type Quad = $quad;

            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn atan2_of_lanes<S: Oct<Self>>(y: Lanes<Self, S>, x: Lanes<Self, S>) -> Lanes<Self, S> {
                $atan2_of_lanes(y, x)
            }
            fn dispatch<K: RowKernel<Self>>(kernel: K) -> K::Output {
                $dispatch(kernel)
            }
        }
    };
}

impl_scalar!(f32, f32x4, dispatch_f32, atan2, atan2);
impl_scalar!(f64, f64x4, dispatch_f64, f64::atan2, each_atan2);

/// Branch-free atan2 for single precision: a minimax polynomial of odd order 17 on [0, 1] (error below 3e-7 rad), then the
/// octant. The library's own is a call for each number.
#[inline(always)]
fn atan2<T: Real>(y: T, x: T) -> T {
    const C: [f64; 8] = [
        -0.333_331_45,
        0.199_935_5,
        -0.142_089,
        0.106_562_64,
        -0.075_289_64,
        0.042_909_61,
        -0.016_165_74,
        0.002_866_226,
    ];
    let (ax, ay) = (x.max(-x), y.max(-y));
    let (small, large) = (ax.min(ay), ax.max(ay));
    let t = small / large.if_positive(large, x.splat(1.0));
    let t2 = t * t;
    let mut p = x.splat(C[7]);
    for &c in C[..7].iter().rev() {
        p = p * t2 + x.splat(c);
    }
    let a = t + t * t2 * p;
    let a = (ay - ax).if_positive(x.splat(core::f64::consts::FRAC_PI_2) - a, a);
    let a = (-x).if_positive(x.splat(core::f64::consts::PI) - a, a);
    (-y).if_positive(-a, a)
}

/// The library's atan2, one by one.
#[inline(always)]
fn each_atan2<S: Oct<f64>>(y: Lanes<f64, S>, x: Lanes<f64, S>) -> Lanes<f64, S> {
    let (mut angles, x_lanes) = (y.store(), x.store());
    for (y, x) in angles.0.iter_mut().zip(x_lanes.0) {
        *y = y.atan2(x);
    }
    x.like(&angles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn atan2_agrees_with_the_library_in_every_octant() {
        for i in 0..=720 {
            let angle = (i as f64 - 360.0) * core::f64::consts::PI / 360.0;
            for radius in [1e-20, 0.3, 1.0, 1e15] {
                let (y, x) = ((radius * angle.sin()) as f32, (radius * angle.cos()) as f32);
                let ours = Real::atan2(y, x);
                let error = (f64::from(ours) - f64::from(y).atan2(x.into())).abs();
                assert!(error < 6e-7, "atan2({y}, {x}) = {ours}, off by {error}");
            }
        }
        assert_eq!(Real::atan2(0.0_f32, 0.0), 0.0);
    }
}
