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
use crate::physics::math::{Padded, Scalar};

/// Levels of so few nodes are not coarsened further.
const COARSEST: usize = 32;
/// Nor are those which coarsening would leave with more than this part of their nodes: loose pieces, say.
const STALLED: f64 = 0.7;

/// Rows of a part of a coarse level, at least, on average: below that a level is one part.
const PART: usize = 256;

/// One V-cycle; see the [module](self).
#[derive(Clone, Debug)]
pub struct Multigrid<T: Scalar> {
    /// From the finest down, without the coarsest.
    levels: Vec<Level<T>>,
    factor: IncompleteCholesky<T>,
}

/// A level that has another below it.
#[derive(Clone, Debug)]
struct Level<T: Scalar> {
    smoother: GaussSeidel<T>,
    prolongation: Prolongation<T>,
    galerkin: Galerkin<T>,
    /// Matrix, right-hand side and solution of the level below.
    coarse: BlockCsr<T>,
    coarse_r: Vec<Padded<T>>,
    coarse_z: Vec<Padded<T>>,
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
            let prolongation = Prolongation::new(&graph, &aggregate_of, count);
            let starts = coarse_part_starts(&pattern, &aggregate_of, count);
            let (galerkin, coarse_pattern) = Galerkin::new(&pattern, &prolongation, count, &starts);
            levels.push(Level {
                smoother: GaussSeidel::new(&pattern),
                prolongation,
                galerkin,
                coarse: BlockCsr::zero(Arc::clone(&coarse_pattern)),
                coarse_r: vec![Padded::zero(); count],
                coarse_z: vec![Padded::zero(); count],
            });
            graph = graph.quotient(&aggregate_of, count);
            pattern = coarse_pattern;
        }
        Self { levels, factor: IncompleteCholesky::new(&pattern) }
    }
}

/// First aggregates of the parts of a level, which follow those of the finer level: aggregates are numbered in the order of
/// their nodes.
fn coarse_part_starts(fine: &BlockPattern, aggregate_of: &[u32], aggregates: usize) -> Vec<u32> {
    if aggregates < PART * fine.parts().len() {
        return vec![0];
    }
    let mut first_nodes = vec![usize::MAX; aggregates];
    for (node, &aggregate) in aggregate_of.iter().enumerate() {
        let first = &mut first_nodes[aggregate as usize];
        *first = node.min(*first);
    }
    let before = |row: usize| first_nodes.iter().filter(|&&first| first < row).count() as u32;
    let mut starts: Vec<u32> = fine.parts().iter().map(|part| before(part.rows.start)).collect();
    starts.dedup();
    starts.retain(|&start| (start as usize) < aggregates);
    starts
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

    fn apply(&mut self, a: &BlockCsr<T>, r: &[Padded<T>], z: &mut [Padded<T>]) -> f64 {
        cycle(&mut self.levels, &mut self.factor, a, r, z)
    }
}

fn cycle<T: Scalar>(
    levels: &mut [Level<T>],
    factor: &mut IncompleteCholesky<T>,
    a: &BlockCsr<T>,
    r: &[Padded<T>],
    z: &mut [Padded<T>],
) -> f64 {
    let Some((level, below)) = levels.split_first_mut() else {
        return factor.apply(a, r, z);
    };
    let Level { smoother, prolongation, coarse, coarse_r, coarse_z, .. } = level;
    let residual = smoother.forward(a, r, z);
    prolongation.restrict(coarse.pattern(), residual, coarse_r);
    cycle(below, factor, coarse, coarse_r, coarse_z);
    prolongation.prolong(a.pattern(), &a.fixed, coarse_z, z);
    smoother.backward(a, r, z)
}
