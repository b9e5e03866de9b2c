//! `N` single-precision numbers side by side.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use wide::f32x4;

use super::Real;

/// `N` f32 values on which every operation acts lane by lane.
///
/// Plain arrays and always-inlined loops: LLVM turns them into the vector instructions of whichever target the
/// calling function is compiled for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Lanes<const N: usize>(pub [f32; N]);

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut lanes = self.0;
        for (lane, other) in lanes.iter_mut().zip(other.0) {
            *lane = f(*lane, other);
        }
        Self(lanes)
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        let mut lanes = self.0;
        for lane in &mut lanes {
            *lane = f(*lane);
        }
        Self(lanes)
    }
}

macro_rules! lanewise {
    ($trait:ident, $method:ident, $assign:ident, $assign_method:ident) => {
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(
                    other,
                    #[inline(always)]
                    |a, b| $trait::$method(a, b),
                )
            }
        }
        impl<const N: usize> $assign for Lanes<N> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                *self = $trait::$method(*self, other);
            }
        }
    };
}

lanewise!(Add, add, AddAssign, add_assign);
lanewise!(Sub, sub, SubAssign, sub_assign);
lanewise!(Mul, mul, MulAssign, mul_assign);

impl<const N: usize> Div for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a / b,
        )
    }
}

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(
            #[inline(always)]
            |a| -a,
        )
    }
}

impl<const N: usize> Real for Lanes<N> {
    type Scalar = f32;
    type Quads = [f32x4; N];
    const LANES: usize = N;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value as f32; N])
    }
    #[inline(always)]
    fn from_lanes(mut f: impl FnMut(usize) -> f32) -> Self {
        let mut lanes = [0.0; N];
        for (i, lane) in lanes.iter_mut().enumerate() {
            *lane = f(i);
        }
        Self(lanes)
    }
    #[inline(always)]
    fn from_rows<const K: usize>(mut f: impl FnMut(usize) -> [f32; K]) -> [Self; K] {
        let mut rows = [Self([0.0; N]); K];
        for lane in 0..N {
            let values = f(lane);
            for k in 0..K {
                rows[k].0[lane] = values[k];
            }
        }
        rows
    }
    #[inline(always)]
    fn quads(four: [Self; 4]) -> Self::Quads {
        let mut quads = [f32x4::ZERO; N];
        // Four lanes at a time; what is left over, one by one.
        let whole = N / 4 * 4;
        for first in (0..whole).step_by(4) {
            let part = |i: usize| {
                f32x4::new([four[i].0[first], four[i].0[first + 1], four[i].0[first + 2], four[i].0[first + 3]])
            };
            let turned = f32x4::transpose([part(0), part(1), part(2), part(3)]);
            quads[first..first + 4].copy_from_slice(&turned);
        }
        for (lane, quad) in quads.iter_mut().enumerate().skip(whole) {
            *quad = f32x4::new([four[0].0[lane], four[1].0[lane], four[2].0[lane], four[3].0[lane]]);
        }
        quads
    }
    #[inline(always)]
    fn lane(self, i: usize) -> f32 {
        self.0[i]
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| if a > b { a } else { b },
        )
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| if a < b { a } else { b },
        )
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        self.zip(x, atan2)
    }
    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        let mut lanes = yes.0;
        for ((lane, no), x) in lanes.iter_mut().zip(no.0).zip(self.0) {
            *lane = if x > 0.0 { *lane } else { no };
        }
        Self(lanes)
    }
}

/// Branch-free atan2: a minimax polynomial of odd order 17 on [0, 1] (error below 3e-7 rad), then the octant.
/// The library's own is a call per lane, which keeps the loop around it from being vectorised.
#[inline(always)]
fn atan2(y: f32, x: f32) -> f32 {
    const C: [f32; 8] = [
        -0.333_331_45,
        0.199_935_5,
        -0.142_089,
        0.106_562_64,
        -0.075_289_64,
        0.042_909_61,
        -0.016_165_74,
        0.002_866_226,
    ];
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ax < ay { (ax, ay) } else { (ay, ax) };
    let t = small / if large > 0.0 { large } else { 1.0 };
    let t2 = t * t;
    let mut p = C[7];
    for c in C[..7].iter().rev() {
        p = p * t2 + c;
    }
    let a = t + t * t2 * p;
    let a = if ay > ax { core::f32::consts::FRAC_PI_2 - a } else { a };
    let a = if x < 0.0 { core::f32::consts::PI - a } else { a };
    if y < 0.0 { -a } else { a }
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
                let ours = Lanes([y; 4]).atan2(Lanes([x; 4])).lane(3);
                let error = (ours as f64 - (y as f64).atan2(x as f64)).abs();
                assert!(error < 6e-7, "atan2({y}, {x}) = {ours}, off by {error}");
            }
        }
        assert_eq!(Lanes([0.0; 2]).atan2(Lanes([0.0; 2])), Lanes([0.0; 2]));
    }
}
