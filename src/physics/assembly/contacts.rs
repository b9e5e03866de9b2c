//! Contact in A and b.

use bevy::math::{DMat3, DVec3};

use super::{BlockCsr, ImplicitStep};
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

/// Adds a term to A and b. Neither may be constrained or interleaved yet; the vertices must be coupled in the pattern.
pub(super) fn add<T: Scalar>(a: &mut BlockCsr<T>, b: &mut [Padded<T>], step: &ImplicitStep, term: &ContactTerm) {
    let square = step.gamma * step.gamma;
    // The solution is relative to the drift, which A does feel here.
    let force = square * (term.force - term.stiffness * step.drift);
    let [x, y, z] = [term.stiffness.x_axis, term.stiffness.y_axis, term.stiffness.z_axis].map(|c| square * c);
    let block = |weight: f64| M3([x, y, z].map(|row| (weight * row).to_array().map(T::from_f64)));
    for (i, &row) in term.vertices.iter().enumerate() {
        let weight = term.weights[i];
        if weight == 0.0 {
            continue;
        }
        let at = row as usize;
        let diagonal = a.diagonal(at);
        a.set_diagonal(at, diagonal + block(weight * weight));
        b[at] += Padded::from_f64((weight * force).to_array());
        for (j, &column) in term.vertices.iter().enumerate() {
            if column < row
                && term.weights[j] != 0.0
                && let Some(slot) = a.pattern().slot(row, column)
            {
                let slot = slot as usize;
                let sum = a.block(slot) + block(weight * term.weights[j]);
                a.set_block(slot, sum);
            }
        }
    }
}
