//! From the unknowns of a level to those of the next finer one.

use super::graph::Graph;
use crate::physics::assembly::BlockPattern;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::math::{Kernel, Padded, Scalar, dispatch};

/// Weight of the neighbours in the smoothed prolongation. Hung sheets take a fifth more iterations at 0.6.
const OMEGA: f64 = 0.9;

/// Entries of a row. Few rows have more: these keep the largest.
pub(super) const ENTRIES: usize = 3;

/// P, the same weights for the three translations. Each row sums to 1, so that translations are kept.
#[derive(Clone, Debug)]
pub(super) struct Prolongation<T> {
    rows: Vec<Row<T>>,
    /// Pᵀ: starts of its rows, and their entries, of a row of P and a weight.
    column_starts: Vec<u32>,
    column_entries: Vec<(u32, T)>,
}

/// A row of P. One with fewer entries repeats a column, with the weight 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<T> {
    pub columns: [u32; ENTRIES],
    pub weights: [T; ENTRIES],
}

impl<T: Scalar> Prolongation<T> {
    /// `P = (I − ω D⁻¹ L) P₀` with P₀ = 1 from each node to its aggregate, L the graph Laplacian and D its diagonal.
    pub fn new(graph: &Graph, aggregate_of: &[u32], aggregates: usize) -> Self {
        let weights = |node: usize| {
            let neighbours = graph.neighbours(node);
            let share = OMEGA / neighbours.len().max(1) as f64;
            let mut row = vec![(aggregate_of[node], 1.0 - share * neighbours.len() as f64)];
            for &neighbour in neighbours {
                let aggregate = aggregate_of[neighbour as usize];
                match row.iter_mut().find(|(column, _)| *column == aggregate) {
                    Some((_, weight)) => *weight += share,
                    None => row.push((aggregate, share)),
                }
            }
            row.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            row.truncate(ENTRIES);
            let sum: f64 = row.iter().map(|(_, weight)| weight).sum();
            let entry = |e: usize| row.get(e).map_or((row[0].0, 0.0), |&(column, weight)| (column, weight / sum));
            let entries: [_; ENTRIES] = core::array::from_fn(entry);
            Row { columns: entries.map(|entry| entry.0), weights: entries.map(|entry| T::from_f64(entry.1)) }
        };
        let rows: Vec<_> = (0..graph.len()).map(weights).collect();

        let mut columns = vec![Vec::new(); aggregates];
        for (node, row) in rows.iter().enumerate() {
            for (&column, &weight) in row.columns.iter().zip(&row.weights) {
                if weight != T::zero() {
                    columns[column as usize].push((node as u32, weight));
                }
            }
        }
        let mut column_starts = vec![0];
        for column in &columns {
            column_starts.push(column_starts[column_starts.len() - 1] + column.len() as u32);
        }
        Self { rows, column_starts, column_entries: columns.concat() }
    }

    /// A row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &Row<T> {
        &self.rows[row]
    }

    /// `coarse = Pᵀ r`.
    pub fn restrict(&self, coarse_pattern: &BlockPattern, r: &[Padded<T>], coarse: &mut [Padded<T>]) {
        for_parts(coarse_pattern.parts(), coarse, &|part: &Part, coarse| {
            dispatch(Restrict { p: self, part, r, coarse });
        });
    }

    /// `z += P e` but for the rows that are `fixed`.
    pub fn prolong(&self, pattern: &BlockPattern, fixed: &[bool], e: &[Padded<T>], z: &mut [Padded<T>]) {
        for_parts(pattern.parts(), z, &|part: &Part, z| dispatch(Prolong { p: self, part, fixed, e, z }));
    }
}

struct Restrict<'a, T: Scalar> {
    p: &'a Prolongation<T>,
    part: &'a Part,
    r: &'a [Padded<T>],
    coarse: &'a mut [Padded<T>],
}

impl<T: Scalar> Kernel for Restrict<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { p, part, r, coarse } = self;
        for (column, sum) in part.rows.clone().zip(coarse) {
            *sum = Padded::zero();
            for &(row, weight) in
                &p.column_entries[p.column_starts[column] as usize..p.column_starts[column + 1] as usize]
            {
                *sum += r[row as usize] * weight;
            }
        }
    }
}

struct Prolong<'a, T: Scalar> {
    p: &'a Prolongation<T>,
    part: &'a Part,
    fixed: &'a [bool],
    e: &'a [Padded<T>],
    z: &'a mut [Padded<T>],
}

impl<T: Scalar> Kernel for Prolong<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { p, part, fixed, e, z } = self;
        let rows = part.rows.clone();
        for ((z, row), &fixed) in z.iter_mut().zip(&p.rows[rows.clone()]).zip(&fixed[rows]) {
            let mut correction = e[row.columns[0] as usize] * row.weights[0];
            for entry in 1..ENTRIES {
                correction += e[row.columns[entry] as usize] * row.weights[entry];
            }
            *z = if fixed { *z } else { *z + correction };
        }
    }
}
