//! The symmetric 2×2 stress of a membrane element, its positive part and its absolute value.

use core::ops::{Add, Mul};

use crate::physics::math::Real;

/// `[[s00, s01], [s01, s11]]`, N/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stress<T> {
    /// Along the warp.
    pub s00: T,
    /// Shear.
    pub s01: T,
    /// Along the weft.
    pub s11: T,
}

impl<T: Real> Stress<T> {
    /// The nearest positive semi-definite stress: eigenvalues λ become max(λ, 0).
    #[inline(always)]
    pub fn positive_part(self) -> Self {
        self.map_eigenvalues(
            #[inline(always)]
            |lambda| lambda.max(lambda.splat(0.0)),
        )
    }

    /// The absolute value: eigenvalues λ become |λ|.
    #[inline(always)]
    pub fn absolute(self) -> Self {
        self.map_eigenvalues(
            #[inline(always)]
            |lambda| lambda.max(-lambda),
        )
    }

    /// New eigenvalues for the same eigenvectors, in closed form.
    ///
    /// With mean `m = (s00+s11)/2`, half difference `h = (s00−s11)/2` and `r = √(h² + s01²)` the eigenvalues are m ± r, and
    /// the eigenvectors are those of the deviator `[[h, s01], [s01, −h]]/r`: new eigenvalues λ₊, λ₋ give
    /// `(λ₊+λ₋)/2 I + (λ₊−λ₋)/2 · deviator/r`.
    #[inline(always)]
    fn map_eigenvalues(self, f: impl Fn(T) -> T) -> Self {
        let half = self.s00.splat(0.5);
        let (mean, h) = (half * (self.s00 + self.s11), half * (self.s00 - self.s11));
        let r = (h * h + self.s01 * self.s01).sqrt();
        let (upper, lower) = (f(mean + r), f(mean - r));
        let new_mean = half * (upper + lower);
        // Where r = 0 the deviator is zero too, and the ratio is not needed.
        let ratio = half * (upper - lower) / r.if_positive(r, r.splat(1.0));
        Self { s00: new_mean + ratio * h, s01: ratio * self.s01, s11: new_mean - ratio * h }
    }
}

impl<T: Real> Add for Stress<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { s00: self.s00 + o.s00, s01: self.s01 + o.s01, s11: self.s11 + o.s11 }
    }
}

impl<T: Real> Mul<T> for Stress<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: T) -> Self {
        Self { s00: self.s00 * s, s01: self.s01 * s, s11: self.s11 * s }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix2;

    use super::*;

    #[test]
    fn eigenvalues_are_clamped_or_made_positive() {
        let cases: [[f64; 3]; 7] = [
            [3.0, 1.0, 2.0],
            [-3.0, 1.0, -2.0],
            [1.0, 2.0, -1.0],
            [-1.0, 0.0, 4.0],
            [5.0, 0.0, 5.0],
            [-5.0, 0.0, -5.0],
            [0.0, 0.0, 0.0],
        ];
        for [s00, s01, s11] in cases {
            let check = |ours: Stress<f64>, f: fn(f64) -> f64| {
                let mut eigen = Matrix2::new(s00, s01, s01, s11).symmetric_eigen();
                eigen.eigenvalues.apply(|l| *l = f(*l));
                let error = (Matrix2::new(ours.s00, ours.s01, ours.s01, ours.s11) - eigen.recompose()).norm();
                assert!(error < 1e-14, "{s00} {s01} {s11}: {error}");
            };
            let stress = Stress { s00, s01, s11 };
            check(stress.positive_part(), |l| l.max(0.0));
            check(stress.absolute(), f64::abs);
        }
    }
}
