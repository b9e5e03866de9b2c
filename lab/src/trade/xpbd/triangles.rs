//! Stretch and shear as constraints: the Green strain of a triangle, C = (ε00, ε11, ε01).
//!
//! The energy `A [½ k0 ε00² + k1 ε00 ε11 + ½ k2 ε11² + k3 ε01²]` is `½ Cᵀ α⁻¹ C` with α⁻¹ = A K, K = [[k0, k1, 0], [k1, k2, 0],
//! [0, 0, 2 k3]]. The three multipliers of a triangle are solved for together; in terms of the stress `σ = λ/(A Δt²)`, eq. 26 of
//! Macklin et al. 2016 is
//!
//! ```text
//! (K⁻¹ + (1 + γ) Δt² A G) σ = −(ε + γ ∇ε·(x − xₙ)),   G = ∇ε M⁻¹ ∇εᵀ,   Δx = Δt² A M⁻¹ ∇εᵀ σ,
//! ```
//!
//! in which with ∇ᵢε00 = uᵢ w_u, ∇ᵢε11 = vᵢ w_v, ∇ᵢε01 = ½ (uᵢ w_v + vᵢ w_u) for the weights u, v of
//! [`membrane`], and P, Q, R = A Σ uᵢ²/mᵢ, A Σ vᵢ²/mᵢ, A Σ uᵢ vᵢ/mᵢ,
//!
//! ```text
//! A G00 = P |w_u|²,   A G01 = R w_u·w_v,   A G02 = ½ (P w_u·w_v + R |w_u|²),
//! A G11 = Q |w_v|²,   A G12 = ½ (R |w_v|² + Q w_u·w_v),   A G22 = ¼ (P |w_v|² + Q |w_u|² + 2 R w_u·w_v).
//! ```

use bevy_cloth::physics::energy::membrane::{self, Deformation, Gram, Orthotropic, Strain};
use bevy_cloth::physics::energy::stress::Stress;
use bevy_cloth::physics::math::{Oct, Pack, Real, Scalar, V3};
use bevy_cloth::physics::{Fabric, RestShape};

use super::batch::{Batches, pack};
use super::twin::Twin;
use super::{Pass, Point};

/// All triangles.
pub(super) struct Triangles<T> {
    batches: Batches<3>,
    rest: Vec<Rest<[Pack<T>; 2]>>,
    compliance: Orthotropic<f64>,
}

/// What is known of a triangle at rest.
#[derive(Clone, Copy)]
struct Rest<R> {
    dm_inverse: [[R; 2]; 2],
    gram: Gram<R>,
    /// A/mᵢ, m²/kg: 0 where it is held.
    weights: [R; 3],
    /// P, Q, R.
    sums: [R; 3],
}

/// K⁻¹.
fn compliance(fabric: &Fabric) -> Orthotropic<f64> {
    let [k0, k1, k2, k3] =
        [fabric.warp_stiffness, fabric.coupling, fabric.weft_stiffness, fabric.shear_stiffness].map(f64::from);
    let determinant = k0 * k2 - k1 * k1;
    assert!(determinant > 0.0 && k3 > 0.0, "a constraint needs a stiffness");
    Orthotropic { k0: k2 / determinant, k1: -k1 / determinant, k2: k0 / determinant, k3: 0.5 / k3 }
}

impl<T: Scalar> Triangles<T> {
    /// Vertices as `inner` numbers them.
    pub fn new(shape: &RestShape, fabric: &Fabric, inner: &[u32], inverse_masses: &[f64]) -> Self {
        let vertices: Vec<_> = shape.triangles.iter().map(|t| t.vertices.map(|v| inner[v as usize])).collect();
        let (batches, sources) = Batches::new(&vertices, inner.len());
        let weight = |i: usize, which: usize| shape.triangles[i].area * inverse_masses[vertices[i][which] as usize];
        let sum = |i: usize, [a, b]: [usize; 2]| {
            let [d1, d2] = shape.triangles[i].dm_inverse;
            let rows = [[-(d1[0] + d2[0]), -(d1[1] + d2[1])], d1, d2];
            (0..3).map(|vertex| weight(i, vertex) * rows[vertex][a] * rows[vertex][b]).sum::<f64>()
        };
        let column = |value: &dyn Fn(usize) -> f64| pack::<T>(&sources, 0.0, value);
        let dm = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[r, c]| column(&|i| shape.triangles[i].dm_inverse[r][c]));
        let gram = [0, 1, 2].map(|entry| column(&|i| shape.triangles[i].rest_gram[entry]));
        let weights = [0, 1, 2].map(|which| column(&|i| weight(i, which)));
        let sums = [[0, 0], [1, 1], [0, 1]].map(|axes| column(&|i| sum(i, axes)));
        let rest = (0..batches.len()).map(|batch| Rest {
            dm_inverse: [[dm[0][batch], dm[1][batch]], [dm[2][batch], dm[3][batch]]],
            gram: gram.each_ref().map(|values| values[batch]),
            weights: weights.each_ref().map(|values| values[batch]),
            sums: sums.each_ref().map(|values| values[batch]),
        });
        Self { rest: rest.collect(), batches, compliance: compliance(fabric) }
    }

    /// Solves each once.
    #[inline(always)]
    pub fn solve<S: Oct<T>>(&self, s: S, pass: &Pass, points: &mut [Point<T>]) {
        for (batch, rest) in self.rest.iter().enumerate() {
            let Rest { dm_inverse: [[u1, v1], [u2, v2]], gram: [g11, g22, g12], weights, sums } = rest;
            let rest = Rest {
                dm_inverse: [[Twin::load(s, u1), Twin::load(s, v1)], [Twin::load(s, u2), Twin::load(s, v2)]],
                gram: [Twin::load(s, g11), Twin::load(s, g22), Twin::load(s, g12)],
                weights: [Twin::load(s, &weights[0]), Twin::load(s, &weights[1]), Twin::load(s, &weights[2])],
                sums: [Twin::load(s, &sums[0]), Twin::load(s, &sums[1]), Twin::load(s, &sums[2])],
            };
            let edges = if pass.value > 0.0 {
                self.batches.edges(s, batch, points)
            } else {
                self.batches.edges_before(s, batch, points)
            };
            let (triangle, w) = rest.deformed(edges);
            let zero = triangle.area.splat(0.0);
            let mut off = Strain { e00: zero, e11: zero, e01: zero };
            if pass.value > 0.0 {
                off = triangle.green_strain(membrane::half_gram_change(edges, rest.gram));
            }
            if pass.rate > 0.0 {
                let moves = triangle.deformation(self.batches.edge_moves(s, batch, points));
                let (change, gamma) = (w.strain_rate(&moves), zero.splat(pass.rate));
                off.e00 += gamma * change.e00;
                off.e11 += gamma * change.e11;
                off.e01 += gamma * change.e01;
            }
            let [m0, m1, m2] = rest.moves(&self.compliance, pass, &triangle, &w, &off);
            self.batches.shift(s, batch, 0, m0, points);
            self.batches.shift(s, batch, 1, m1, points);
            self.batches.shift(s, batch, 2, m2, points);
        }
    }
}

impl<R: Real> Rest<R> {
    /// The triangle, with the area taken to be 1, as the weights have it already, and how it is deformed.
    #[inline(always)]
    fn deformed(&self, edges: [V3<R>; 2]) -> (membrane::Rest<R>, Deformation<R>) {
        let triangle = membrane::Rest { dm_inverse: self.dm_inverse, area: self.gram[0].splat(1.0) };
        (triangle, triangle.deformation(edges))
    }

    /// Δx of the three vertices.
    #[inline(always)]
    fn moves(
        &self,
        compliance: &Orthotropic<f64>,
        pass: &Pass,
        triangle: &membrane::Rest<R>,
        w: &Deformation<R>,
        off: &Strain<R>,
    ) -> [V3<R>; 3] {
        let stress = solved(self.mobility(compliance, pass, w), off);
        let [g1, g2] = membrane::gradient(triangle, &stress, w);
        let scale = self.gram[0].splat(-pass.dt2);
        let [w0, w1, w2] = self.weights;
        [-(g1 + g2) * (w0 * scale), g1 * (w1 * scale), g2 * (w2 * scale)]
    }

    /// K⁻¹ + (1 + γ) Δt² A G, as its entries 00, 11, 22, 01, 02, 12.
    #[inline(always)]
    fn mobility(&self, compliance: &Orthotropic<f64>, pass: &Pass, w: &Deformation<R>) -> [R; 6] {
        let scale = self.gram[0].splat(pass.dt2 * pass.mobility);
        let (uu, vv, uv) = (w.w_u.norm_squared() * scale, w.w_v.norm_squared() * scale, w.w_u.dot(w.w_v) * scale);
        let [p, q, r] = self.sums;
        let half = scale.splat(0.5);
        let Orthotropic { k0, k1, k2, k3 } = *compliance;
        let c = pass.compliance;
        [
            half.splat(c * k0) + p * uu,
            half.splat(c * k2) + q * vv,
            half.splat(c * k3) + half * (r * uv + half * (p * vv + q * uu)),
            half.splat(c * k1) + r * uv,
            half * (p * uv + r * uu),
            half * (r * vv + q * uv),
        ]
    }
}

/// The stress σ that the matrix of these entries (00, 11, 22, 01, 02, 12) turns into this strain.
#[inline(always)]
fn solved<R: Real>([a00, a11, a22, a01, a02, a12]: [R; 6], strain: &Strain<R>) -> Stress<R> {
    let (c00, c01, c02) = (a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11);
    let (c11, c12, c22) = (a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01);
    let inverse = a00.splat(1.0) / (a00 * c00 + a01 * c01 + a02 * c02);
    let Strain { e00, e11, e01 } = *strain;
    // The multiplier of ε01 is that of both off-diagonal entries of the stress.
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

    #[test]
    fn a_stress_is_solved_for() {
        let matrix = [4.0, 3.0, 5.0, 1.0, -0.5, 0.25];
        let Stress { s00, s11, s01 } = solved(matrix, &Strain { e00: 1.0, e11: -2.0, e01: 0.5 });
        let [a00, a11, a22, a01, a02, a12] = matrix;
        let (x, y, z) = (s00, s11, 2.0 * s01);
        let product: [f64; 3] = [a00 * x + a01 * y + a02 * z, a01 * x + a11 * y + a12 * z, a02 * x + a12 * y + a22 * z];
        for (value, expected) in product.into_iter().zip([1.0, -2.0, 0.5]) {
            assert!((value - expected).abs() < 1e-14, "{product:?}");
        }
    }

    #[test]
    fn compliance_is_the_inverse_of_stiffness() {
        let fabric = Fabric { coupling: 300.0, ..Fabric::cotton() };
        let Orthotropic { k0, k1, k2, k3 } = compliance(&fabric);
        let (warp, weft) = (f64::from(fabric.warp_stiffness), f64::from(fabric.weft_stiffness));
        assert!((warp * k0 + 300.0 * k1 - 1.0).abs() < 1e-12 && (warp * k1 + 300.0 * k2).abs() < 1e-12);
        assert!((300.0 * k1 + weft * k2 - 1.0).abs() < 1e-12);
        assert!((2.0 * k3 * f64::from(fabric.shear_stiffness) - 1.0).abs() < 1e-12);
    }
}
