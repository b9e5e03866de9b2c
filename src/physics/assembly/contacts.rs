//! Contact in A and b.

use bevy::math::{DMat3, DVec3};

use super::BlockCsr;
use crate::physics::math::{M3, Padded, Scalar};

/// A force that falls linearly as a point of the cloth moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactTerm {
    /// The vertex that the point is, or those of a triangle that it is in.
    pub vertices: [u32; 3],
    /// Their weights, which sum to one: `[1, 0, 0]` for a vertex.
    pub weights: [f64; 3],
    /// Force on the cloth where it is linearised, N.
    pub force: DVec3,
    /// What the force falls by per metre, N/m. Symmetric, positive semi-definite.
    pub stiffness: DMat3,
}

/// What contact changed in A and b, to be taken out again.
#[derive(Debug)]
pub(super) struct Added<T: Scalar> {
    /// Rows with what was on the diagonal and in b.
    rows: Vec<(u32, M3<T>, Padded<T>)>,
    /// Slots with what was there.
    blocks: Vec<(u32, M3<T>)>,
}

impl<T: Scalar> Added<T> {
    pub fn none() -> Self {
        Self { rows: Vec::new(), blocks: Vec::new() }
    }

    /// A and b are others now.
    pub fn forget(&mut self) {
        self.rows.clear();
        self.blocks.clear();
    }

    /// Adds a term to A and b, which hold the constraints already; the vertices must be coupled in the pattern. The solution is
    /// relative to `drift` (m), which contact does feel.
    pub fn add(&mut self, a: &mut BlockCsr<T>, b: &mut [Padded<T>], gamma: f64, drift: DVec3, term: &ContactTerm) {
        let square = gamma * gamma;
        let force = square * (term.force - term.stiffness * drift);
        let [x, y, z] = [term.stiffness.x_axis, term.stiffness.y_axis, term.stiffness.z_axis].map(|c| square * c);
        let block = |weight: f64| M3([x, y, z].map(|row| (weight * row).to_array().map(T::from_f64)));
        let corners = || term.vertices.into_iter().zip(term.weights).filter(|&(_, weight)| weight != 0.0);
        for (row, weight) in corners() {
            let at = row as usize;
            if a.fixed[at] {
                continue;
            }
            let diagonal = a.diagonal(at);
            self.rows.push((row, diagonal, b[at]));
            a.set_diagonal(at, diagonal + block(weight * weight));
            b[at] += Padded::from_f64((weight * force).to_array());
            for (column, other) in corners().filter(|&(column, _)| column != row) {
                let coupling = block(weight * other);
                if a.fixed[column as usize] {
                    b[at] -= coupling.times(b[column as usize]);
                } else if column < row
                    && let Some(slot) = a.pattern().slot(row, column)
                {
                    self.blocks.push((slot, a.change_block(slot as usize, |block| block + coupling)));
                }
            }
        }
    }

    /// Takes all of it out of A and b again.
    pub fn take_out(&mut self, a: &mut BlockCsr<T>, b: &mut [Padded<T>]) {
        for (row, diagonal, rhs) in self.rows.drain(..).rev() {
            a.set_diagonal(row as usize, diagonal);
            b[row as usize] = rhs;
        }
        for (slot, block) in self.blocks.drain(..).rev() {
            a.change_block(slot as usize, |_| block);
        }
    }
}
