//! Preconditioned conjugate gradients (Hestenes & Stiefel 1952; Saad 2003, algorithm 9.1).

use super::{LinearSolver, Preconditioner, SolveError, Solved};
use crate::physics::assembly::BlockCsr;
use crate::physics::math::{Scalar, V3};

/// Conjugate gradients with a preconditioner. Inner products are accumulated in f64.
#[derive(Clone, Debug)]
pub struct ConjugateGradient<T, P> {
    preconditioner: P,
    max_iterations: u32,
    residual: Vec<V3<T>>,
    preconditioned: Vec<V3<T>>,
    direction: Vec<V3<T>>,
    product: Vec<V3<T>>,
}

impl<T: Scalar, P: Preconditioner<T>> ConjugateGradient<T, P> {
    /// For matrices of `rows` block rows; stops after `max_iterations` whether or not it got there.
    pub fn new(rows: usize, preconditioner: P, max_iterations: u32) -> Self {
        let zeros = vec![V3::zero(); rows];
        Self {
            preconditioner,
            max_iterations,
            residual: zeros.clone(),
            preconditioned: zeros.clone(),
            direction: zeros.clone(),
            product: zeros,
        }
    }
}

impl<T: Scalar, P: Preconditioner<T>> LinearSolver<T> for ConjugateGradient<T, P> {
    fn solve(&mut self, a: &BlockCsr<T>, b: &[V3<T>], d: &mut [V3<T>], target: f64) -> Result<Solved, SolveError> {
        let Self { preconditioner, max_iterations, residual: r, preconditioned: z, direction: p, product: ap } = self;
        preconditioner.update(a);
        a.multiply(d, ap);
        for ((r, &b), &ap) in r.iter_mut().zip(b).zip(&*ap) {
            *r = b - ap;
        }
        preconditioner.apply(r, z);
        p.copy_from_slice(z);
        let mut rz = dot(r, z);
        let target = target * target;

        check_sign(rz)?;
        let mut iterations = 0;
        while rz > target && iterations < *max_iterations {
            a.multiply(p, ap);
            let curvature = dot(p, ap);
            check_sign(curvature)?;
            // Zero only if the direction underflowed: nothing left to gain.
            if curvature == 0.0 {
                break;
            }
            let step = T::from_f64(rz / curvature);
            for ((d, r), (&p, &ap)) in d.iter_mut().zip(&mut *r).zip(p.iter().zip(&*ap)) {
                *d += p * step;
                *r -= ap * step;
            }
            preconditioner.apply(r, z);
            let previous = rz;
            rz = dot(r, z);
            check_sign(rz)?;
            let beta = T::from_f64(rz / previous);
            for (p, &z) in p.iter_mut().zip(&*z) {
                *p = z + *p * beta;
            }
            iterations += 1;
        }
        Ok(Solved { iterations, converged: rz <= target })
    }
}

/// rᵀP⁻¹r and pᵀAp are never negative if A and P are positive definite.
fn check_sign(product: f64) -> Result<(), SolveError> {
    if !product.is_finite() {
        Err(SolveError::NotFinite)
    } else if product < 0.0 {
        Err(SolveError::NotPositiveDefinite)
    } else {
        Ok(())
    }
}

fn dot<T: Scalar>(a: &[V3<T>], b: &[V3<T>]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| a.dot_f64(b)).sum()
}
