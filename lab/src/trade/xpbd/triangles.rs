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
//! [`membrane`], and P, Q, R = Σ uᵢ²/mᵢ, Σ vᵢ²/mᵢ, Σ uᵢ vᵢ/mᵢ,
//!
//! ```text
//! G00 = P |w_u|²,   G11 = Q |w_v|²,   G01 = R w_u·w_v,   G02 = ½ (P w_u·w_v + R |w_u|²),   G12 = ½ (R |w_v|² + Q w_u·w_v),
//! G22 = ¼ (P |w_v|² + Q |w_u|² + 2 R w_u·w_v).
//! ```

use bevy_cloth::physics::energy::membrane::{self, Gram, Orthotropic, Rest, Strain};
use bevy_cloth::physics::energy::stress::Stress;
use bevy_cloth::physics::math::{Lanes, Oct, Pack, Real, Scalar, V3};
use bevy_cloth::physics::{Fabric, RestShape};

use super::batch::{Batches, pack};
use super::{Pass, Point};

/// All triangles.
pub(super) struct Triangles<T> {
    batches: Batches<3>,
    rest: Vec<RestBatch<T>>,
    compliance: Orthotropic<f64>,
}

/// What is known of a batch at rest.
struct RestBatch<T> {
    triangle: Rest<Pack<T>>,
    gram: Gram<Pack<T>>,
    inverse_masses: [Pack<T>; 3],
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
        let column = |value: &dyn Fn(usize) -> f64| pack::<T>(&sources, 0.0, value);
        let dm = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[r, c]| column(&|i| shape.triangles[i].dm_inverse[r][c]));
        let area = column(&|i| shape.triangles[i].area);
        let gram = [0, 1, 2].map(|entry| column(&|i| shape.triangles[i].rest_gram[entry]));
        let masses = [0, 1, 2].map(|which| column(&|i| inverse_masses[vertices[i][which] as usize]));
        let rest = (0..batches.len()).map(|batch| RestBatch {
            triangle: Rest {
                dm_inverse: [[dm[0][batch], dm[1][batch]], [dm[2][batch], dm[3][batch]]],
                area: area[batch],
            },
            gram: gram.each_ref().map(|values| values[batch]),
            inverse_masses: masses.each_ref().map(|values| values[batch]),
        });
        Self { rest: rest.collect(), batches, compliance: compliance(fabric) }
    }

    /// Solves each once.
    #[inline(always)]
    pub fn solve<S: Oct<T>>(&self, s: S, pass: &Pass, points: &mut [Point<T>]) {
        for (batch, rest) in self.rest.iter().enumerate() {
            let area = Lanes::load(s, &rest.triangle.area);
            let [[u1, v1], [u2, v2]] = &rest.triangle.dm_inverse;
            let triangle = Rest { dm_inverse: [[area.like(u1), area.like(v1)], [area.like(u2), area.like(v2)]], area };
            let edges = if pass.value > 0.0 {
                self.batches.edges(s, batch, points)
            } else {
                self.batches.settled_edges(s, batch, points)
            };
            let w = triangle.deformation(edges);

            let zero = area.splat(0.0);
            let mut off = Strain { e00: zero, e11: zero, e01: zero };
            if pass.value > 0.0 {
                let [g11, g22, g12] = &rest.gram;
                let gram = [area.like(g11), area.like(g22), area.like(g12)];
                off = triangle.green_strain(membrane::half_gram_change(edges, gram));
            }
            if pass.rate > 0.0 {
                let moves = triangle.deformation(self.batches.edge_moves(s, batch, points));
                let (change, gamma) = (w.strain_rate(&moves), area.splat(pass.rate));
                off.e00 += gamma * change.e00;
                off.e11 += gamma * change.e11;
                off.e01 += gamma * change.e01;
            }

            let [m0, m1, m2] = &rest.inverse_masses;
            let inverse_masses = [area.like(m0), area.like(m1), area.like(m2)];
            let mobility = self.mobility(&triangle, inverse_masses, &w, pass);
            let stress = solved(mobility, &off);

            let [g1, g2] = membrane::gradient(&triangle, &stress, &w);
            let scale = area.splat(-pass.dt2 * pass.relaxation);
            for (which, (gradient, mass)) in [-(g1 + g2), g1, g2].into_iter().zip(inverse_masses).enumerate() {
                let moved: V3<_> = gradient * (mass * scale);
                self.batches.shift(s, batch, which, moved, points);
            }
        }
    }

    /// K⁻¹ + (1 + γ) Δt² A G, as its entries 00, 11, 22, 01, 02, 12.
    #[inline(always)]
    fn mobility<S: Oct<T>>(
        &self,
        triangle: &Rest<Lanes<T, S>>,
        inverse_masses: [Lanes<T, S>; 3],
        w: &membrane::Deformation<Lanes<T, S>>,
        pass: &Pass,
    ) -> [Lanes<T, S>; 6] {
        let area = triangle.area;
        let [[u1, v1], [u2, v2]] = triangle.dm_inverse;
        let (u0, v0) = (-(u1 + u2), -(v1 + v2));
        let scale = area * area.splat(pass.dt2 * pass.mobility());
        let [m0, m1, m2] = [inverse_masses[0] * scale, inverse_masses[1] * scale, inverse_masses[2] * scale];
        let p = m0 * u0 * u0 + m1 * u1 * u1 + m2 * u2 * u2;
        let q = m0 * v0 * v0 + m1 * v1 * v1 + m2 * v2 * v2;
        let r = m0 * u0 * v0 + m1 * u1 * v1 + m2 * u2 * v2;
        let (uu, vv, uv) = (w.w_u.norm_squared(), w.w_v.norm_squared(), w.w_u.dot(w.w_v));
        let half = area.splat(0.5);
        let Orthotropic { k0, k1, k2, k3 } = self.compliance;
        let c = pass.compliance;
        [
            area.splat(c * k0) + p * uu,
            area.splat(c * k2) + q * vv,
            area.splat(c * k3) + half * (r * uv + half * (p * vv + q * uu)),
            area.splat(c * k1) + r * uv,
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
