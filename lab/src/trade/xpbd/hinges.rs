//! Bending as constraints: C = θ − θ̄ of a hinge.
//!
//! The energy `k_b ‖ē‖/h̄ C²` is `½ α⁻¹ C²` with α⁻¹ = 2 k_b ‖ē‖/h̄. With the stiffness κ = Δt² α⁻¹ in the place of α̃⁻¹, eq. 26 of
//! Macklin et al. 2016 is `Δλ = −κ (C + γ ∇C·(x − xₙ)) / (1 + (1 + γ) κ Σ |∇ᵢC|²/mᵢ)`, which no bending at all does not break.

use bevy_cloth::physics::energy::hinge::{self, Gradient, Rest};
use bevy_cloth::physics::math::{Oct, Pack, Real, Scalar, V3};
use bevy_cloth::physics::{Fabric, RestShape};

use super::batch::{Batches, pack};
use super::twin::Twin;
use super::{Pass, Point};

/// All hinges.
pub(super) struct Hinges<T> {
    batches: Batches<4>,
    rest: Vec<RestBatch<T>>,
}

/// What is known of a batch at rest.
struct RestBatch<T> {
    hinge: Rest<[Pack<T>; 2]>,
    inverse_masses: [[Pack<T>; 2]; 4],
}

impl<T: Scalar> Hinges<T> {
    /// Vertices as `inner` numbers them.
    pub fn new(shape: &RestShape, fabric: &Fabric, inner: &[u32], inverse_masses: &[f64]) -> Self {
        let vertices: Vec<_> = shape.hinges.iter().map(|h| h.vertices.map(|v| inner[v as usize])).collect();
        let (batches, sources) = Batches::new(&vertices, inner.len());
        let rest = |i: usize| {
            let h = &shape.hinges[i];
            Rest::new(fabric.bending_along(h.direction), h.length, h.height, h.double_areas, h.rest_angle)
        };
        let stiffness = pack::<T>(&sources, 0.0, |i| rest(i).stiffness);
        let rest_angle = pack::<T>(&sources, 0.0, |i| rest(i).rest_angle);
        let normal_floor = pack::<T>(&sources, 1.0, |i| rest(i).normal_floor);
        let masses =
            [0, 1, 2, 3].map(|which| pack::<T>(&sources, 0.0, |i| inverse_masses[vertices[i][which] as usize]));
        let rest = (0..batches.len()).map(|batch| RestBatch {
            hinge: Rest {
                stiffness: stiffness[batch],
                rest_angle: rest_angle[batch],
                normal_floor: normal_floor[batch],
            },
            inverse_masses: masses.each_ref().map(|values| values[batch]),
        });
        Self { rest: rest.collect(), batches }
    }

    /// Solves each once.
    #[inline(always)]
    pub fn solve<S: Oct<T>>(&self, s: S, pass: &Pass, points: &mut [Point<T>]) {
        for (batch, RestBatch { hinge, inverse_masses: [m0, m1, m2, m3] }) in self.rest.iter().enumerate() {
            let rest = Rest {
                stiffness: Twin::load(s, &hinge.stiffness),
                rest_angle: Twin::load(s, &hinge.rest_angle),
                normal_floor: Twin::load(s, &hinge.normal_floor),
            };
            let edges = if pass.value > 0.0 {
                self.batches.edges(s, batch, points)
            } else {
                self.batches.edges_before(s, batch, points)
            };
            let gradient = hinge::gradient(edges, rest.normal_floor);
            let mut off = rest.stiffness.splat(0.0);
            if pass.value > 0.0 {
                off = hinge::deviation(hinge::theta(edges), rest.rest_angle);
            }
            if pass.rate > 0.0 {
                off += off.splat(pass.rate) * gradient.change(self.batches.edge_moves(s, batch, points));
            }
            let masses = [Twin::load(s, m0), Twin::load(s, m1), Twin::load(s, m2), Twin::load(s, m3)];
            let [m0, m1, m2, m3] = moves(&rest, masses, pass, gradient, off);
            self.batches.shift(s, batch, 0, m0, points);
            self.batches.shift(s, batch, 1, m1, points);
            self.batches.shift(s, batch, 2, m2, points);
            self.batches.shift(s, batch, 3, m3, points);
        }
    }
}

/// Δx of the four vertices.
#[inline(always)]
fn moves<R: Real>(
    rest: &Rest<R>,
    [m0, m1, m2, m3]: [R; 4],
    pass: &Pass,
    Gradient([g0, g1, g2, g3]): Gradient<R>,
    off: R,
) -> [V3<R>; 4] {
    let mobility = m0 * g0.norm_squared() + m1 * g1.norm_squared() + m2 * g2.norm_squared() + m3 * g3.norm_squared();
    let kappa = hinge::rigidity(rest) * off.splat(pass.dt2 / pass.compliance);
    let multiplier = -(kappa * off) / (off.splat(1.0) + off.splat(pass.mobility) * kappa * mobility);
    [g0 * (m0 * multiplier), g1 * (m1 * multiplier), g2 * (m2 * multiplier), g3 * (m3 * multiplier)]
}
