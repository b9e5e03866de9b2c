//! [`ROWS`] numbers side by side as a [`Real`].

use core::fmt::{self, Debug};
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::{Oct, ROWS, Real, Scalar, V3};

/// Eight numbers in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Pack<T>(pub [T; ROWS]);

impl<T: Scalar> Pack<T> {
    /// Their sum, in f64.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        let mut sum = 0.0;
        for value in self.0 {
            sum += value.to_f64();
        }
        sum
    }
}

/// Eight numbers at work, in the instruction set of S: every operation acts on them one by one.
#[derive(Clone, Copy)]
pub struct Lanes<T: Scalar, S: Oct<T>> {
    s: S,
    /// The numbers.
    pub v: S::V,
}

impl<T: Scalar, S: Oct<T>> Lanes<T, S> {
    /// From what the instructions act on.
    #[inline(always)]
    pub fn new(s: S, v: S::V) -> Self {
        Self { s, v }
    }

    /// From memory.
    #[inline(always)]
    pub fn load(s: S, pack: &Pack<T>) -> Self {
        Self { s, v: s.load(&pack.0) }
    }

    /// From memory, in the instruction set of `self`.
    #[inline(always)]
    pub fn like(self, pack: &Pack<T>) -> Self {
        Self::load(self.s, pack)
    }

    /// To memory.
    #[inline(always)]
    pub fn store(self) -> Pack<T> {
        Pack(self.s.store(self.v))
    }

    /// Rounds to this precision.
    #[inline(always)]
    pub fn narrow(s: S, wide: Lanes<f64, S::Wide>) -> Self {
        Self { s, v: s.narrow(wide.v) }
    }
}

impl<T: Scalar, S: Oct<T>> V3<Lanes<T, S>> {
    /// From eight x, eight y and eight z.
    #[inline(always)]
    pub fn of(s: S, [x, y, z]: [S::V; 3]) -> Self {
        Self([Lanes::new(s, x), Lanes::new(s, y), Lanes::new(s, z)])
    }

    /// Rounds to this precision.
    #[inline(always)]
    pub fn narrow(s: S, wide: V3<Lanes<f64, S::Wide>>) -> Self {
        let [x, y, z] = wide.0;
        Self([Lanes::narrow(s, x), Lanes::narrow(s, y), Lanes::narrow(s, z)])
    }
}

impl<T: Scalar, S: Oct<T>> Debug for Lanes<T, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.store().fmt(f)
    }
}

macro_rules! lanewise {
    ($trait:ident, $method:ident) => {
        impl<T: Scalar, S: Oct<T>> $trait for Lanes<T, S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { v: self.s.$method(self.v, other.v), ..self }
            }
        }
    };
    ($trait:ident, $method:ident, $assign:ident, $assign_method:ident) => {
        lanewise!($trait, $method);
        impl<T: Scalar, S: Oct<T>> $assign for Lanes<T, S> {
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
lanewise!(Div, div);

impl<T: Scalar, S: Oct<T>> Neg for Lanes<T, S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.splat(0.0) - self
    }
}

impl<T: Scalar, S: Oct<T>> Real for Lanes<T, S> {
    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self { v: self.s.splat(T::from_f64(value)), ..self }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self { v: self.s.sqrt(self.v), ..self }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self { v: self.s.if_greater(self.v, other.v, self.v, other.v), ..self }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self { v: self.s.if_greater(other.v, self.v, self.v, other.v), ..self }
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        T::atan2_of_lanes(self, x)
    }
    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        Self { v: self.s.if_greater(self.v, self.s.splat(T::zero()), yes.v, no.v), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::math::RowKernel;

    const A: [f64; ROWS] = [1.0, -2.0, 0.5, 4.0, -0.1, 8.0, 0.0, 3.0];
    const B: f64 = 0.75;

    fn formulas<R: Real>(a: R, b: R) -> [R; 5] {
        [a + b * a - a / b, -a.max(b).sqrt(), a.min(b).atan2(a), a.if_positive(b, a), a.splat(2.5)]
    }

    struct Formulas;

    impl<T: Scalar> RowKernel<T> for Formulas {
        type Output = [Pack<T>; 5];

        #[inline(always)]
        fn run<S: Oct<T>>(self, s: S) -> Self::Output {
            let a = Lanes::load(s, &Pack(A.map(T::from_f64)));
            formulas(a, a.splat(B)).map(Lanes::store)
        }
    }

    #[test]
    fn every_lane_is_computed_as_a_number_alone() {
        fn check<T: Scalar>() {
            let results = T::dispatch(Formulas);
            for (lane, a) in A.into_iter().enumerate() {
                for (result, expected) in results.iter().zip(formulas(T::from_f64(a), T::from_f64(B))) {
                    assert!((result.0[lane] - expected).to_f64().abs() < 1e-6, "{result:?} {expected:?}");
                }
            }
        }
        check::<f32>();
        check::<f64>();
        assert_eq!(Pack(A).sum(), 14.4);
    }
}
