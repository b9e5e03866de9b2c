//! 3-vectors of [`Real`]s.

use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::{M3, Real, Scalar};

/// A 3-vector.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct V3<T>(pub [T; 3]);

impl<T: Real> V3<T> {
    /// Dot product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    /// Cross product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        let ([ax, ay, az], [bx, by, bz]) = (self.0, other.0);
        Self([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    }

    /// Squared length.
    #[inline(always)]
    pub fn norm_squared(self) -> T {
        self.dot(self)
    }

    /// `self otherᵀ`.
    #[inline(always)]
    pub fn outer(self, other: Self) -> M3<T> {
        let [x, y, z] = self.0;
        M3([(other * x).0, (other * y).0, (other * z).0])
    }
}

impl<T: Scalar> V3<T> {
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([T::zero(); 3])
    }

    /// Rounds to this precision.
    #[inline(always)]
    pub fn from_f64(v: [f64; 3]) -> Self {
        Self([T::from_f64(v[0]), T::from_f64(v[1]), T::from_f64(v[2])])
    }

    /// Widens to f64.
    #[inline(always)]
    pub fn to_f64(self) -> [f64; 3] {
        [self.0[0].to_f64(), self.0[1].to_f64(), self.0[2].to_f64()]
    }

    /// Dot product accumulated in f64.
    #[inline(always)]
    pub fn dot_f64(self, other: Self) -> f64 {
        let (a, b) = (self.to_f64(), other.to_f64());
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }
}

impl<T: Real> Add for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self([self.0[0] + o.0[0], self.0[1] + o.0[1], self.0[2] + o.0[2]])
    }
}

impl<T: Real> Sub for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self([self.0[0] - o.0[0], self.0[1] - o.0[1], self.0[2] - o.0[2]])
    }
}

impl<T: Real> Neg for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1], -self.0[2]])
    }
}

impl<T: Real> Mul<T> for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: T) -> Self {
        Self([self.0[0] * s, self.0[1] * s, self.0[2] * s])
    }
}

impl<T: Real> AddAssign for V3<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<T: Real> SubAssign for V3<T> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
