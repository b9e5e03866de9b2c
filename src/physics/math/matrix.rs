//! 3×3 blocks of [`Real`]s.

use core::ops::{Add, AddAssign, Mul, Neg, Sub};

use super::{Real, Scalar, V3};

/// A 3×3 matrix, by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct M3<T>(pub [[T; 3]; 3]);

impl<T: Real> M3<T> {
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

    /// `self + s I`.
    #[inline(always)]
    pub fn add_diagonal(mut self, s: T) -> Self {
        for i in 0..3 {
            self.0[i][i] += s;
        }
        self
    }

    /// One lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> M3<T::Scalar> {
        M3(core::array::from_fn(|r| core::array::from_fn(|c| self.0[r][c].lane(i))))
    }

    /// The rows.
    #[inline(always)]
    pub fn rows(self) -> [V3<T>; 3] {
        [V3(self.0[0]), V3(self.0[1]), V3(self.0[2])]
    }

    /// The transpose.
    #[inline(always)]
    pub fn transpose(self) -> Self {
        Self(core::array::from_fn(|r| core::array::from_fn(|c| self.0[c][r])))
    }

    /// Matrix times vector.
    #[inline(always)]
    pub fn mul_vector(&self, v: V3<T>) -> V3<T> {
        V3(core::array::from_fn(|r| self.0[r][0] * v.0[0] + self.0[r][1] * v.0[1] + self.0[r][2] * v.0[2]))
    }

    /// Inverse, by cofactors.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let [a, b, c] = self.rows();
        let (bc, ca, ab) = (b.cross(c), c.cross(a), a.cross(b));
        let scale = T::splat(1.0) / a.dot(bc);
        Self([bc.0, ca.0, ab.0]).transpose() * scale
    }
}

impl<T: Scalar> M3<T> {
    /// Inverse of a symmetric positive definite matrix of any magnitude: the determinant of a block of grams would vanish in
    /// f32, so the magnitude is taken out first.
    #[inline(always)]
    pub fn scaled_inverse(&self) -> Self {
        let scale = T::splat(1.0) / self.0[0][0].max(self.0[1][1]).max(self.0[2][2]);
        (*self * scale).inverse() * scale
    }
}

impl<T: Real> Add for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(core::array::from_fn(|r| core::array::from_fn(|c| self.0[r][c] + o.0[r][c])))
    }
}

impl<T: Real> Sub for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(core::array::from_fn(|r| core::array::from_fn(|c| self.0[r][c] - o.0[r][c])))
    }
}

impl<T: Real> Neg for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(core::array::from_fn(|r| core::array::from_fn(|c| -self.0[r][c])))
    }
}

impl<T: Real> Mul<T> for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: T) -> Self {
        Self(core::array::from_fn(|r| core::array::from_fn(|c| self.0[r][c] * s)))
    }
}

impl<T: Real> Mul<M3<T>> for M3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let [a, b, c] = o.rows();
        Self(core::array::from_fn(|r| (a * self.0[r][0] + b * self.0[r][1] + c * self.0[r][2]).0))
    }
}

impl<T: Real> AddAssign for M3<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
