//! The linear system that a step of a cloth solves.

use bevy::math::DVec3;
use bevy_cloth::physics::Cloth;
use bevy_cloth::physics::assembly::{BlockCsr, ImplicitStep, Ordering, System, constrain};
use bevy_cloth::physics::math::{M3, Padded, RowSums};
use pulp::{Simd, WithSimd};

use crate::scenes::DT;

/// A d = b of a backward Euler step of one frame from the state of a cloth, in single precision, its pins taken out.
pub struct StepSystem {
    /// A and b, in an order that suits the solver.
    pub system: System<f32>,
    /// World positions in that order, m.
    pub positions: Vec<DVec3>,
    inertial: Vec<DVec3>,
    masses: Vec<f64>,
}

impl StepSystem {
    /// Of a cloth as it stands.
    pub fn new(cloth: &Cloth) -> Self {
        let ordering = Ordering::new(cloth.shape());
        let inner = |values: &dyn Fn(usize) -> DVec3| ordering.outer.iter().map(|&v| values(v as usize)).collect();
        let mut step = Self {
            system: System::new(cloth.shape(), cloth.fabric(), &ordering),
            positions: inner(&|v| cloth.positions()[v]),
            inertial: inner(&|v| cloth.positions()[v] + DT * cloth.velocities()[v]),
            masses: ordering.outer.iter().map(|&v| cloth.masses()[v as usize]).collect(),
        };
        step.assemble(cloth.gravity());
        let mut held = vec![false; cloth.masses().len()];
        for (vertex, _) in cloth.pinned() {
            held[ordering.inner[vertex as usize] as usize] = true;
        }
        constrain(&mut step.system.matrix, &mut step.system.rhs, &held, |_| Padded::zero());
        step
    }

    /// Fills A and b again for the same state, pinned vertices included.
    pub fn assemble(&mut self, gravity: DVec3) {
        let step = ImplicitStep::backward_euler(&self.positions, &self.inertial, DT, gravity);
        self.system.assemble(&step, &self.masses);
    }
}

/// A matrix with both its halves stored, row by row: block compressed sparse rows as everybody has them.
pub struct FullMatrix {
    row_starts: Vec<u32>,
    columns: Vec<u32>,
    blocks: Vec<M3<f32>>,
}

impl FullMatrix {
    /// The same matrix, with the blocks above the diagonal too.
    pub fn new(a: &BlockCsr<f32>) -> Self {
        let count = a.pattern().row_count();
        let mut rows: Vec<Vec<(u32, M3<f32>)>> = (0..count).map(|row| vec![(row as u32, a.diagonal(row))]).collect();
        for row in 0..count {
            for (column, block) in a.lower_row(row) {
                rows[row].push((column, block));
                rows[column as usize].push((row as u32, block.transpose()));
            }
        }
        let mut full = Self { row_starts: vec![0], columns: Vec::new(), blocks: Vec::new() };
        for mut row in rows {
            row.sort_unstable_by_key(|&(column, _)| column);
            full.columns.extend(row.iter().map(|&(column, _)| column));
            full.blocks.extend(row.iter().map(|&(_, block)| block));
            full.row_starts.push(full.columns.len() as u32);
        }
        full
    }

    /// `y = A x`, in the best instruction set of the machine.
    pub fn multiply(&self, x: &[Padded<f32>], y: &mut [Padded<f32>]) {
        pulp::Arch::new().dispatch(Multiply { a: self, x, y });
    }
}

struct Multiply<'a> {
    a: &'a FullMatrix,
    x: &'a [Padded<f32>],
    y: &'a mut [Padded<f32>],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { a, x, y } = self;
        for (row, y) in y.iter_mut().enumerate() {
            let range = a.row_starts[row] as usize..a.row_starts[row + 1] as usize;
            let mut sums = RowSums::zero();
            for (block, &column) in a.blocks[range.clone()].iter().zip(&a.columns[range]) {
                sums.add(block, x[column as usize]);
            }
            *y = sums.total();
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy_cloth::physics::SolverSettings;

    use super::*;
    use crate::scenes::{Meshing, Sheet};

    #[test]
    fn both_ways_of_storing_a_matrix_multiply_alike() {
        let mut cloth = Sheet::new(50, Meshing::Irregular).hang(SolverSettings::default());
        for _ in 0..3 {
            cloth.step(DT);
        }
        let mut step = StepSystem::new(&cloth);
        let x: Vec<_> = step.positions.iter().map(|x| Padded::from_f64(x.to_array())).collect();
        let (mut half, mut full) = (vec![Padded::zero(); x.len()], vec![Padded::zero(); x.len()]);
        FullMatrix::new(&step.system.matrix).multiply(&x, &mut full);
        step.system.matrix.interleave();
        step.system.matrix.multiply(&x, &mut half);
        let norm = |v: &[Padded<f32>]| v.iter().map(|v| v.dot_f64(*v)).sum::<f64>().sqrt();
        let difference: Vec<_> = half.iter().zip(&full).map(|(&a, &b)| a - b).collect();
        assert!(norm(&difference) < 1e-5 * norm(&full), "{:e} of {:e}", norm(&difference), norm(&full));
    }
}
