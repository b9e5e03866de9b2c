//! Forces on points of the cloth in A and b: contacts, attachments, springs between two places.

use bevy::math::{DMat3, DVec3};

use super::{BlockEll, BlockPattern, ImplicitStep};
use crate::physics::math::{M3, Padded, Scalar};

/// A force that falls linearly as a combination of vertices moves.
///
/// With signed weights w the point is `p = Σ wᵢ xᵢ`: a place of a triangle where they sum to 1, the way between two places where
/// they sum to 0. Each vertex feels `wᵢ (f − K Σ wⱼ dⱼ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    /// Up to four vertices; those of no weight may be any.
    pub vertices: [u32; 4],
    /// w.
    pub weights: [f64; 4],
    /// f on the point where it is linearized, N.
    pub force: DVec3,
    /// K: what the force falls by per meter, N/m. Symmetric, positive semi-definite.
    pub stiffness: DMat3,
}

impl Stencil {
    /// On one vertex.
    pub fn of_vertex(vertex: u32, force: DVec3, stiffness: DMat3) -> Self {
        Self { vertices: [vertex; 4], weights: [1.0, 0.0, 0.0, 0.0], force, stiffness }
    }

    /// The vertices that have a weight.
    pub fn corners(&self) -> impl Iterator<Item = (usize, f64)> + Clone {
        let corners = self.vertices.into_iter().zip(self.weights);
        corners.filter(|&(_, weight)| weight != 0.0).map(|(vertex, weight)| (vertex as usize, weight))
    }

    /// Whether the pattern couples all of its vertices with each other.
    pub(super) fn fits(&self, pattern: &BlockPattern) -> bool {
        let coupled = |(a, b): (usize, usize)| a <= b || pattern.slot(a as u32, b as u32).is_some();
        self.corners().all(|(a, _)| self.corners().all(|(b, _)| coupled((a, b))))
    }
}

/// The block `weight · factor · K`.
pub(super) fn block<T: Scalar>(stiffness: &DMat3, factor: f64) -> M3<T> {
    let rows = [stiffness.x_axis, stiffness.y_axis, stiffness.z_axis];
    M3(rows.map(|row| (factor * row).to_array().map(T::from_f64)))
}

/// Adds the force of a stencil to b. The solution is relative to the drift, which the stencil feels by the sum of its weights.
pub(super) fn add_force<T: Scalar>(b: &mut [Padded<T>], step: &ImplicitStep, stencil: &Stencil) {
    let sum: f64 = stencil.weights.iter().sum();
    let force = step.gamma * step.gamma * (stencil.force - sum * (stencil.stiffness * step.drift));
    for (vertex, weight) in stencil.corners() {
        b[vertex] += Padded::from_f64((weight * force).to_array());
    }
}

/// Adds the stiffness of a stencil that [fits](Stencil::fits) to A, which may neither be constrained nor interleaved yet.
pub(super) fn add_stiffness<T: Scalar>(a: &mut BlockEll<T>, step: &ImplicitStep, stencil: &Stencil) {
    let square = step.gamma * step.gamma;
    for (row, weight) in stencil.corners() {
        let diagonal = a.diagonal(row);
        a.set_diagonal(row, diagonal + block(&stencil.stiffness, square * weight * weight));
        for (column, other) in stencil.corners().filter(|&(column, _)| column < row) {
            let slot = a.pattern().slot(row as u32, column as u32).expect("the stencil fits") as usize;
            let sum = a.block(slot) + block(&stencil.stiffness, square * weight * other);
            a.set_block(slot, sum);
        }
    }
}
