//! Preconditioned conjugate gradients (Hestenes & Stiefel 1952; Saad 2003, algorithm 9.1).

use bevy::platform::time::Instant;

use super::{BlockJacobi, LinearSolver, Preconditioner, SolveError, Solved, Target};
use crate::physics::assembly::BlockCsr;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::math::{Padded, Scalar};

/// Conjugate gradients with a preconditioner. Inner products are accumulated in f64. Should the preconditioner turn out not
/// to be positive definite, the diagonal blocks take its place, which cannot fail.
#[derive(Clone, Debug)]
pub struct ConjugateGradient<T: Scalar, P> {
    preconditioner: P,
    max_iterations: u32,
    residual: Vec<Padded<T>>,
    preconditioned: Vec<Padded<T>>,
    direction: Vec<Padded<T>>,
    product: Vec<Padded<T>>,
}

impl<T: Scalar, P: Preconditioner<T>> ConjugateGradient<T, P> {
    /// For matrices of `rows` block rows; stops after `max_iterations` whether or not it got there.
    pub fn new(rows: usize, preconditioner: P, max_iterations: u32) -> Self {
        let zeros = vec![Padded::zero(); rows];
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
    fn solve(
        &mut self,
        a: &mut BlockCsr<T>,
        b: &[Padded<T>],
        d: &mut [Padded<T>],
        target: Target,
    ) -> Result<Solved, SolveError> {
        let Self { preconditioner, max_iterations, residual, preconditioned, direction, product } = self;
        let mut vectors = Vectors { r: residual, z: preconditioned, p: direction, ap: product };
        let start = Instant::now();
        preconditioner.update(a);
        a.interleave();
        let preparation = start.elapsed();
        let a = &*a;
        let solved = match vectors.iterate(a, b, d, target, preconditioner, *max_iterations) {
            Err(Breakdown::Preconditioner { iterations }) => {
                let mut jacobi = BlockJacobi::new(b.len());
                jacobi.update(a);
                let solved = vectors.iterate(a, b, d, target, &mut jacobi, *max_iterations - iterations);
                solved.map(|solved| Solved { iterations: solved.iterations + iterations, ..solved })
            }
            result => result,
        };
        match solved {
            Ok(solved) => Ok(Solved { preparation, ..solved }),
            Err(Breakdown::NotFinite) => Err(SolveError::NotFinite),
            Err(Breakdown::Matrix | Breakdown::Preconditioner { .. }) => Err(SolveError::NotPositiveDefinite),
        }
    }
}

/// Why conjugate gradients cannot go on. `d` is the best found so far, but where something is not finite.
enum Breakdown {
    NotFinite,
    /// A is not positive definite.
    Matrix,
    /// P is not.
    Preconditioner {
        iterations: u32,
    },
}

struct Vectors<'a, T: Scalar> {
    r: &'a mut [Padded<T>],
    z: &'a mut [Padded<T>],
    p: &'a mut [Padded<T>],
    ap: &'a mut [Padded<T>],
}

impl<T: Scalar> Vectors<'_, T> {
    fn iterate(
        &mut self,
        a: &BlockCsr<T>,
        b: &[Padded<T>],
        d: &mut [Padded<T>],
        target: Target,
        preconditioner: &mut impl Preconditioner<T>,
        max_iterations: u32,
    ) -> Result<Solved, Breakdown> {
        let Self { r, z, p, ap } = self;
        let parts = a.pattern().parts();
        // Most guesses are no more than where the pins go, and nothing is coupled with these.
        let still = d.iter().zip(&a.fixed).all(|(&d, &fixed)| fixed || d == Padded::zero());
        if still {
            ap.copy_from_slice(d);
        } else {
            a.multiply(d, ap);
        }
        for_parts(parts, (&mut **r, &mut **ap), &|part: &Part, (r, ap)| {
            for ((r, &b), ap) in r.iter_mut().zip(&b[part.rows.clone()]).zip(ap) {
                *r = b - *ap;
            }
        });
        let mut rz = preconditioner.apply(a, r, z);
        let target = target.absolute.max(target.relative * rz.max(0.0).sqrt());
        let target = target * target;
        p.copy_from_slice(z);
        let mut iterations = 0;
        loop {
            if !rz.is_finite() {
                return Err(Breakdown::NotFinite);
            } else if rz < 0.0 {
                return Err(Breakdown::Preconditioner { iterations });
            }
            if rz <= target || iterations == max_iterations {
                return Ok(Solved { iterations, converged: rz <= target, ..Default::default() });
            }
            let curvature = a.multiply(p, ap);
            if !curvature.is_finite() {
                return Err(Breakdown::NotFinite);
            } else if curvature < 0.0 && iterations == 0 {
                return Err(Breakdown::Matrix);
            } else if curvature <= 0.0 {
                // The direction underflowed, or is one that A is too ill-conditioned for in this precision: what was found so
                // far is as good as it gets.
                return Ok(Solved { iterations, ..Default::default() });
            }
            let step = T::from_f64(rz / curvature);
            let (direction, product) = (&**p, &**ap);
            for_parts(parts, (&mut *d, &mut **r), &|part: &Part, (d, r)| {
                let known = direction[part.rows.clone()].iter().zip(&product[part.rows.clone()]);
                for ((d, r), (&p, &ap)) in d.iter_mut().zip(r).zip(known) {
                    *d += p * step;
                    *r -= ap * step;
                }
            });
            let previous = rz;
            rz = preconditioner.apply(a, r, z);
            let beta = T::from_f64(rz / previous);
            let preconditioned = &**z;
            for_parts(parts, &mut **p, &|part: &Part, p| {
                for (p, &z) in p.iter_mut().zip(&preconditioned[part.rows.clone()]) {
                    *p = z + *p * beta;
                }
            });
            iterations += 1;
        }
    }
}
