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
use crate::physics::assembly::{BlockCsr, BlockPattern, Slicing, colour};
use crate::physics::math::{Padded, Scalar};

/// Levels of so few nodes are not coarsened further.
const COARSEST: usize = 12;
/// Nor are those which coarsening would leave with more than this part of their nodes: loose pieces, say.
const STALLED: f64 = 0.7;

/// Rows of a part of a coarse level, at least, on average: below that a level is one part.
const PART: usize = 64;
/// Rows of a piece of a coarse level that is filled by a thread of its own, at least, on average.
const PIECE: usize = 64;

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
        let mut pieces: Vec<_> = pattern.parts().iter().map(|part| part.rows.start as u32).collect();
        let mut levels = Vec::new();
        while graph.len() > COARSEST {
            let (aggregate_of, count) = graph.aggregates();
            if count as f64 > STALLED * graph.len() as f64 {
                break;
            }
            if count < PIECE * pieces.len() {
                pieces.truncate(1);
            }
            let (aggregate_of, starts) = in_order(&pattern, &graph, aggregate_of, count, &pieces);
            let prolongation = Prolongation::new(&graph, &aggregate_of, count);
            let slicing = if count > COARSEST { Slicing::Independent } else { Slicing::Any };
            // Parts cost iterations, so levels of which each part would be small have none.
            let in_parts = pattern.parts().len() > 1 && count >= PART * starts.len();
            let part_starts = if in_parts { &starts[..] } else { &[0] };
            let (galerkin, coarse_pattern) =
                Galerkin::new(&pattern, &prolongation, count, &starts, part_starts, slicing);
            pieces = starts;
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

/// The aggregates numbered anew, by piece and colour, and the first of each piece. Pieces follow those of the finer level, which
/// begin at these rows.
fn in_order(
    fine: &BlockPattern,
    graph: &Graph,
    aggregate_of: Vec<u32>,
    count: usize,
    fine_pieces: &[u32],
) -> (Vec<u32>, Vec<u32>) {
    let prolongation = Prolongation::<f32>::new(graph, &aggregate_of, count);
    let mut neighbours = vec![Vec::new(); count];
    for [a, b] in galerkin::couplings(fine, &prolongation).filter(|[a, b]| a != b) {
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(a);
    }
    let colours = colour(&neighbours, 0..count as u32);

    let mut piece_of = vec![0; count];
    for (node, &aggregate) in aggregate_of.iter().enumerate().rev() {
        piece_of[aggregate as usize] = fine_pieces.partition_point(|&start| start as usize <= node);
    }
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_by_key(|&aggregate| (piece_of[aggregate as usize], colours[aggregate as usize]));
    let mut number = vec![0; count];
    for (i, &aggregate) in order.iter().enumerate() {
        number[aggregate as usize] = i as u32;
    }
    let begins = |&i: &usize| i == 0 || piece_of[order[i] as usize] != piece_of[order[i - 1] as usize];
    let starts = (0..count).filter(begins).map(|i| i as u32).collect();
    (aggregate_of.into_iter().map(|aggregate| number[aggregate as usize]).collect(), starts)
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
        for Level { coarse, .. } in &mut self.levels {
            coarse.interleave();
        }
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
