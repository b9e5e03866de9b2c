//! From the unknowns of a level to those of the next finer one.

use super::graph::Graph;
use crate::physics::assembly::BlockPattern;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::math::{Padded, Scalar};

/// Weight of the neighbours in the smoothed prolongation. Hung sheets take a fifth more iterations at 0.6.
const OMEGA: f64 = 0.9;

/// P, the same weights for the three translations. Each row sums to 1, so that translations are kept.
#[derive(Clone, Debug)]
pub(super) struct Prolongation<T> {
    rows: Weights<T>,
    /// Pᵀ.
    columns: Weights<T>,
}

/// A sparse matrix of numbers, by rows.
#[derive(Clone, Debug)]
struct Weights<T> {
    starts: Vec<u32>,
    entries: Vec<Entry<T>>,
}

/// A weight and its column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<T> {
    pub column: u32,
    pub weight: T,
}

impl<T: Scalar> Weights<T> {
    fn new(rows: impl Iterator<Item = Vec<Entry<T>>>) -> Self {
        let mut weights = Self { starts: vec![0], entries: Vec::new() };
        for row in rows {
            weights.entries.extend(row);
            weights.starts.push(weights.entries.len() as u32);
        }
        weights.entries.shrink_to_fit();
        weights
    }

    #[inline(always)]
    fn row(&self, row: usize) -> &[Entry<T>] {
        &self.entries[self.starts[row] as usize..self.starts[row + 1] as usize]
    }

    #[inline(always)]
    fn row_times(&self, row: usize, x: &[Padded<T>]) -> Padded<T> {
        let mut sum = Padded::zero();
        for entry in self.row(row) {
            sum += x[entry.column as usize] * entry.weight;
        }
        sum
    }
}

impl<T: Scalar> Prolongation<T> {
    /// `P = (I − ω D⁻¹ L) P₀` with P₀ = 1 from each node to its aggregate, L the graph Laplacian and D its diagonal.
    pub fn new(graph: &Graph, aggregate_of: &[u32], aggregates: usize) -> Self {
        let rows = Weights::new(aggregate_of.iter().enumerate().map(|(node, &own)| {
            let neighbours = graph.neighbours(node);
            let share = OMEGA / neighbours.len().max(1) as f64;
            let mut row = vec![(own, 1.0 - share * neighbours.len() as f64)];
            row.extend(neighbours.iter().map(|&n| (aggregate_of[n as usize], share)));
            row.sort_unstable_by_key(|&(column, _)| column);
            row.dedup_by(|next, kept| {
                let same = next.0 == kept.0;
                if same {
                    kept.1 += next.1;
                }
                same
            });
            row.into_iter().map(|(column, weight)| Entry { column, weight: T::from_f64(weight) }).collect()
        }));
        let mut columns = vec![Vec::new(); aggregates];
        for node in 0..aggregate_of.len() {
            for &Entry { column, weight } in rows.row(node) {
                columns[column as usize].push(Entry { column: node as u32, weight });
            }
        }
        Self { rows, columns: Weights::new(columns.into_iter()) }
    }

    /// The entries of a row, columns ascending.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[Entry<T>] {
        self.rows.row(row)
    }

    /// `coarse = Pᵀ r`.
    pub fn restrict(&self, coarse_pattern: &BlockPattern, r: &[Padded<T>], coarse: &mut [Padded<T>]) {
        for_parts(coarse_pattern.parts(), coarse, &|part: &Part, coarse| {
            for (row, sum) in part.rows.clone().zip(coarse) {
                *sum = self.columns.row_times(row, r);
            }
        });
    }

    /// `z += P e` but for the rows that are `fixed`.
    pub fn prolong(&self, pattern: &BlockPattern, fixed: &[bool], e: &[Padded<T>], z: &mut [Padded<T>]) {
        for_parts(pattern.parts(), z, &|part: &Part, z| {
            for (row, z) in part.rows.clone().zip(z) {
                if !fixed[row] {
                    *z += self.rows.row_times(row, e);
                }
            }
        });
    }
}
