//! 3×3 blocks of [`Real`]s.

use core::ops::{Add, AddAssign, Mul, Neg, Sub};

use super::{Real, Scalar, V3};

/// A 3×3 matrix, by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct M3<T>(pub [[T; 3]; 3]);

impl<T: Scalar> M3<T> {
    /// The zero matrix.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([[T::zero(); 3]; 3])
    }

    /// `s I`.
    #[inline(always)]
    pub fn scaled_identity(s: T) -> Self {
        Self::zero().add_diagonal(s)
    }
}

impl<T: Real> M3<T> {
    /// `self + s I`.
    #[inline(always)]
    pub fn add_diagonal(mut self, s: T) -> Self {
        for i in 0..3 {
            self.0[i][i] += s;
        }
        self
    }

    /// The rows.
    #[inline(always)]
    pub fn rows(self) -> [V3<T>; 3] {
        [V3(self.0[0]), V3(self.0[1]), V3(self.0[2])]
    }

    /// The transpose.
    #[inline(always)]
    pub fn transpose(self) -> Self {
        let [[a, b, c], [d, e, f], [g, h, i]] = self.0;
        Self([[a, d, g], [b, e, h], [c, f, i]])
    }

    /// Matrix times vector.
    #[inline(always)]
    pub fn mul_vector(&self, v: V3<T>) -> V3<T> {
        let [a, b, c] = self.rows();
        V3([a.dot(v), b.dot(v), c.dot(v)])
    }
}

impl<T: Real> Add for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let [a, b, c] = self.rows();
        let [d, e, f] = o.rows();
        Self([(a + d).0, (b + e).0, (c + f).0])
    }
}

impl<T: Real> Sub for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        let [a, b, c] = self.rows();
        let [d, e, f] = o.rows();
        Self([(a - d).0, (b - e).0, (c - f).0])
    }
}

impl<T: Real> Neg for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let [a, b, c] = self.rows();
        Self([(-a).0, (-b).0, (-c).0])
    }
}

impl<T: Real> Mul<T> for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: T) -> Self {
        let [a, b, c] = self.rows();
        Self([(a * s).0, (b * s).0, (c * s).0])
    }
}

impl<T: Real> Mul<M3<T>> for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let [a, b, c] = o.rows();
        let [p, q, r] = self.0;
        let row = |x: [T; 3]| (a * x[0] + b * x[1] + c * x[2]).0;
        Self([row(p), row(q), row(r)])
    }
}

impl<T: Real> AddAssign for M3<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
