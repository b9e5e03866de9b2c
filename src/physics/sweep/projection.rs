//! What takes the change of its strain out of one triangle.
//!
//! With the change Δε of the Green strain since the step began, compliance K⁻¹, and `Gᵢ` the gradient of ε at vertex i, the stress σ
//! that a step of length γ would build up against that change, and the moves it causes, are
//!
//! ```text
//! (K⁻¹ + γ² A Σ GᵢGᵢᵀ/mᵢ) σ = −Δε        Δxᵢ = γ² A/mᵢ Gᵢᵀ σ
//! ```

use crate::physics::energy::membrane::{self, Deformation, Orthotropic, Strain};
use crate::physics::energy::stress::Stress;
use crate::physics::math::{Real, V3};

/// A triangle that is projected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projected<R> {
    /// D_m⁻¹ by rows, 1/m.
    pub dm_inverse: [[R; 2]; 2],
    /// A/mᵢ of each vertex, m²/kg; zero for what does not move.
    pub mobility: [R; 3],
}

impl<R: Real> Projected<R> {
    /// Moves of the vertices, m, for a triangle whose edges from vertex 0 were `edges` when the step began and have changed by
    /// `changes` since. `square` is γ².
    #[inline(always)]
    pub fn moves(
        &self,
        compliance: &Orthotropic<f64>,
        square: f64,
        edges: [V3<R>; 2],
        changes: [V3<R>; 2],
    ) -> [V3<R>; 3] {
        let [[e1, e2], [d1, d2]] = [edges, changes];
        let half = self.mobility[0].splat(0.5);
        let rest = membrane::Rest { dm_inverse: self.dm_inverse, area: half.splat(1.0) };
        // ½ of the change of the Gram matrix, from the moves: f32 keeps its digits.
        let off = rest.green_strain([
            e1.dot(d1) + half * d1.dot(d1),
            e2.dot(d2) + half * d2.dot(d2),
            half * (e1.dot(d2) + e2.dot(d1) + d1.dot(d2)),
        ]);
        let w = rest.deformation([e1 + d1, e2 + d2]);
        let stress = solve(self.matrix(compliance, square, &w), &off);
        let [g1, g2] = membrane::gradient(&rest, &stress, &w);
        let ([m0, m1, m2], scale) = (self.mobility, half.splat(-square));
        [-(g1 + g2) * (m0 * scale), g1 * (m1 * scale), g2 * (m2 * scale)]
    }

    /// K⁻¹ + γ² A Σ GᵢGᵢᵀ/mᵢ in (ε00, ε11, ε01), as its entries 00, 11, 22, 01, 02, 12.
    #[inline(always)]
    fn matrix(&self, compliance: &Orthotropic<f64>, square: f64, w: &Deformation<R>) -> [R; 6] {
        let [[u1, v1], [u2, v2]] = self.dm_inverse;
        let [m0, m1, m2] = self.mobility;
        let (u0, v0) = (u1 + u2, v1 + v2);
        let p = m0 * u0 * u0 + m1 * u1 * u1 + m2 * u2 * u2;
        let q = m0 * v0 * v0 + m1 * v1 * v1 + m2 * v2 * v2;
        let r = m0 * u0 * v0 + m1 * u1 * v1 + m2 * u2 * v2;
        let scale = p.splat(square);
        let (uu, vv, uv) = (w.w_u.norm_squared() * scale, w.w_v.norm_squared() * scale, w.w_u.dot(w.w_v) * scale);
        let half = p.splat(0.5);
        let Orthotropic { k0, k1, k2, k3 } = *compliance;
        [
            p.splat(k0) + p * uu,
            p.splat(k2) + q * vv,
            p.splat(k3) + half * (r * uv + half * (p * vv + q * uu)),
            p.splat(k1) + r * uv,
            half * (p * uv + r * uu),
            half * (r * vv + q * uv),
        ]
    }
}

/// The stress whose work-conjugate strain the matrix maps it to: the shear of a stress works twice.
#[inline(always)]
fn solve<R: Real>([a00, a11, a22, a01, a02, a12]: [R; 6], strain: &Strain<R>) -> Stress<R> {
    let (c00, c01, c02) = (a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11);
    let (c11, c12, c22) = (a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01);
    let inverse = a00.splat(1.0) / (a00 * c00 + a01 * c01 + a02 * c02);
    let Strain { e00, e11, e01 } = *strain;
    let half = inverse * inverse.splat(0.5);
    Stress {
        s00: (c00 * e00 + c01 * e11 + c02 * e01) * inverse,
        s11: (c01 * e00 + c11 * e11 + c12 * e01) * inverse,
        s01: (c02 * e00 + c12 * e11 + c22 * e01) * half,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> (Projected<f64>, [V3<f64>; 2]) {
        let triangle = Projected { dm_inverse: [[10.0, -3.0], [1.0, 8.0]], mobility: [0.5, 0.3, 0.8] };
        // D_m, in space.
        let det = 10.0 * 8.0 + 3.0;
        (triangle, [V3([8.0 / det, -1.0 / det, 0.0]), V3([3.0 / det, 10.0 / det, 0.0])])
    }

    fn strain(rest: &membrane::Rest<f64>, [a, b]: [V3<f64>; 2]) -> [f64; 3] {
        let Deformation { w_u, w_v } = rest.deformation([a, b]);
        [0.5 * (w_u.dot(w_u) - 1.0), 0.5 * (w_v.dot(w_v) - 1.0), 0.5 * w_u.dot(w_v)]
    }

    /// Of a fabric that does not give, a small change is taken out but for its square; a soft one keeps what its own matrix says.
    #[test]
    fn a_small_change_of_strain_is_taken_out() {
        let (triangle, edges) = triangle();
        let rest = membrane::Rest { dm_inverse: triangle.dm_inverse, area: 1.0 };
        let changes = [V3([1e-5, 2e-5, -1e-5]), V3([-2e-5, 1e-5, 3e-5])];
        let hard = Orthotropic { k0: 0.0, k1: 0.0, k2: 0.0, k3: 0.0 };
        let [m0, m1, m2] = triangle.moves(&hard, 1e-4, edges, changes);
        let moved = [edges[0] + changes[0] + m1 - m0, edges[1] + changes[1] + m2 - m0];
        let before = strain(&rest, [edges[0] + changes[0], edges[1] + changes[1]]);
        for (after, before) in strain(&rest, moved).into_iter().zip(before) {
            assert!(after.abs() < 1e-2 * before.abs(), "{after} of {before}");
        }
        // Nothing moves as a whole.
        let total = m0 * (1.0 / 0.5) + m1 * (1.0 / 0.3) + m2 * (1.0 / 0.8);
        assert!(total.dot(total).sqrt() < 1e-18);
        let soft = Orthotropic { k0: 1e9, k1: 0.0, k2: 1e9, k3: 1e9 };
        assert!(triangle.moves(&soft, 1e-4, edges, changes).iter().all(|m| m.dot(*m).sqrt() < 1e-12));
    }

    /// The matrix is that of strains which the forces of a stress cause, by central differences.
    #[test]
    fn the_matrix_is_what_a_stress_strains() {
        let (triangle, edges) = triangle();
        let rest = membrane::Rest { dm_inverse: triangle.dm_inverse, area: 1.0 };
        let edges = [edges[0] + V3([0.003, -0.002, 0.01]), edges[1] + V3([0.001, 0.004, -0.02])];
        let none = Orthotropic { k0: 0.0, k1: 0.0, k2: 0.0, k3: 0.0 };
        let w = rest.deformation(edges);
        let [a00, a11, a22, a01, a02, a12] = triangle.matrix(&none, 1.0, &w);
        let columns = [[a00, a01, a02], [a01, a11, a12], [a02, a12, a22]];
        // The shear of a stress works twice.
        let stresses =
            [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.5)].map(|(s00, s11, s01)| Stress { s00, s11, s01 });
        for (stress, column) in stresses.iter().zip(columns) {
            let [g1, g2] = membrane::gradient(&rest, stress, &w);
            let h = 1e-7;
            let at = |sign: f64| {
                let [m0, m1, m2] = triangle.mobility.map(|m| sign * h * m);
                let moved = -(g1 + g2) * m0;
                strain(&rest, [edges[0] + g1 * m1 - moved, edges[1] + g2 * m2 - moved])
            };
            for ((plus, minus), entry) in at(1.0).into_iter().zip(at(-1.0)).zip(column) {
                let difference = (plus - minus) / (2.0 * h);
                assert!((difference - entry).abs() < 1e-4 * a00, "{difference} {entry}");
            }
        }
    }
}
