//! Two numbers that go through a computation side by side, so that one does not wait for the other: what depends on nothing but
//! itself leaves a processor idle most of the time.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use bevy_cloth::physics::math::{Lanes, Oct, Pack, Real, Scalar, V3};

/// Two of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twin<R>(pub R, pub R);

impl<T: Scalar, S: Oct<T>> Twin<Lanes<T, S>> {
    /// From memory.
    #[inline(always)]
    pub fn load(s: S, [first, second]: &[Pack<T>; 2]) -> Self {
        Self(Lanes::load(s, first), Lanes::load(s, second))
    }
}

/// Two vectors as one.
#[inline(always)]
pub(super) fn pair<R: Real>(V3([ax, ay, az]): V3<R>, V3([bx, by, bz]): V3<R>) -> V3<Twin<R>> {
    V3([Twin(ax, bx), Twin(ay, by), Twin(az, bz)])
}

/// And back.
#[inline(always)]
pub(super) fn parted<R: Real>(V3([x, y, z]): V3<Twin<R>>) -> [V3<R>; 2] {
    [V3([x.0, y.0, z.0]), V3([x.1, y.1, z.1])]
}

macro_rules! each {
    ($trait:ident, $method:ident) => {
        impl<R: Real> $trait for Twin<R> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($trait::$method(self.0, other.0), $trait::$method(self.1, other.1))
            }
        }
    };
    ($trait:ident, $method:ident, $assign:ident, $assign_method:ident) => {
        each!($trait, $method);
        impl<R: Real> $assign for Twin<R> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                *self = $trait::$method(*self, other);
            }
        }
    };
}

each!(Add, add, AddAssign, add_assign);
each!(Sub, sub, SubAssign, sub_assign);
each!(Mul, mul, MulAssign, mul_assign);
each!(Div, div);

impl<R: Real> Neg for Twin<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<R: Real> Real for Twin<R> {
    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self(self.0.splat(value), self.1.splat(value))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        Self(self.0.atan2(x.0), self.1.atan2(x.1))
    }
    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        Self(self.0.if_positive(yes.0, no.0), self.1.if_positive(yes.1, no.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_computed_as_one_alone() {
        fn formula<R: Real>(a: R, b: R) -> R {
            let c = (a + b * a - a / b).max(-b).sqrt().atan2(a.min(b));
            c.if_positive(a, b) * a.splat(2.5)
        }
        let Twin(first, second) = formula(Twin(1.5, -0.3), Twin(0.75, 2.0));
        assert_eq!((first, second), (formula(1.5, 0.75), formula(-0.3, 2.0)));
    }
}
