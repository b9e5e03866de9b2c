//! Smoothed-aggregation algebraic multigrid (Vaněk, Mandel & Brezina 1996).
//!
//! Each level is solved by a sweep of Gauss–Seidel, which removes what varies from vertex to vertex; what remains is
//! smooth enough to be solved for on a level of fewer unknowns, one per aggregate of vertices:
//!
//! ```text
//! z ← forward sweep from 0      e ← the same on the level below, for Pᵀ (r − A z)
//! z ← z + P e                   z ← backward sweep from z
//! ```
//!
//! The prolongation P depends on the pattern alone. So the coarse matrices Pᵀ A P have fixed patterns, found once, and
//! only their values follow A. The coarsest level is factorised.

mod galerkin;
mod graph;
mod prolongation;

use std::sync::Arc;

use self::galerkin::Galerkin;
use self::graph::Graph;
use self::prolongation::Prolongation;
use super::gauss_seidel::GaussSeidel;
use super::{IncompleteCholesky, Preconditioner};
use crate::physics::assembly::{BlockCsr, BlockPattern};
use crate::physics::math::{Scalar, V3};

/// Levels of so few nodes are not coarsened further.
const COARSEST: usize = 32;
/// Nor are those which coarsening would leave with more than this part of their nodes: loose pieces, say.
const STALLED: f64 = 0.7;

/// One V-cycle; see the [module](self).
#[derive(Clone, Debug)]
pub struct Multigrid<T> {
    /// From the finest down, without the coarsest.
    levels: Vec<Level<T>>,
    factor: IncompleteCholesky<T>,
}

/// A level that has another below it.
#[derive(Clone, Debug)]
struct Level<T> {
    smoother: GaussSeidel<T>,
    prolongation: Prolongation<T>,
    galerkin: Galerkin<T>,
    /// Matrix, right-hand side and solution of the level below.
    coarse: BlockCsr<T>,
    coarse_r: Vec<V3<T>>,
    coarse_z: Vec<V3<T>>,
}

impl<T: Scalar> Multigrid<T> {
    /// Prepares the levels for matrices of a pattern.
    pub fn new(pattern: &Arc<BlockPattern>) -> Self {
        let mut pattern = Arc::clone(pattern);
        let mut graph = Graph::of_pattern(&pattern);
        let mut levels = Vec::new();
        while graph.len() > COARSEST {
            let (aggregate_of, count) = graph.aggregates();
            if count as f64 > STALLED * graph.len() as f64 {
                break;
            }
            let prolongation = Prolongation::new(&graph, &aggregate_of);
            let (galerkin, coarse_pattern) = Galerkin::new(&pattern, &prolongation, count);
            levels.push(Level {
                smoother: GaussSeidel::new(&pattern),
                prolongation,
                galerkin,
                coarse: BlockCsr::zero(Arc::clone(&coarse_pattern)),
                coarse_r: vec![V3::zero(); count],
                coarse_z: vec![V3::zero(); count],
            });
            graph = graph.quotient(&aggregate_of, count);
            pattern = coarse_pattern;
        }
        Self { levels, factor: IncompleteCholesky::new(&pattern) }
    }
}

impl<T: Scalar> Preconditioner<T> for Multigrid<T> {
    fn update(&mut self, a: &BlockCsr<T>) {
        let mut fine = a;
        for Level { smoother, prolongation, galerkin, coarse, .. } in &mut self.levels {
            smoother.update(fine);
            galerkin.multiply(fine, prolongation, coarse);
            fine = coarse;
        }
        self.factor.update(fine);
    }

    fn apply(&mut self, r: &[V3<T>], z: &mut [V3<T>]) {
        cycle(&mut self.levels, &mut self.factor, r, z);
    }
}

fn cycle<T: Scalar>(levels: &mut [Level<T>], factor: &mut IncompleteCholesky<T>, r: &[V3<T>], z: &mut [V3<T>]) {
    let Some((level, below)) = levels.split_first_mut() else {
        return factor.apply(r, z);
    };
    let Level { smoother, prolongation, coarse_r, coarse_z, .. } = level;
    smoother.forward(r, z);
    coarse_r.fill(V3::zero());
    smoother.residual_after_forward(z, |row, residual| prolongation.restrict_row(row, residual, coarse_r));
    cycle(below, factor, coarse_r, coarse_z);
    prolongation.prolong(coarse_z, z);
    smoother.backward(r, z);
}
