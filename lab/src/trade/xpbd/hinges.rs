//! Bending as constraints: C = θ − θ̄ of a hinge.
//!
//! The energy `k_b ‖ē‖/h̄ C²` is `½ α⁻¹ C²` with α⁻¹ = 2 k_b ‖ē‖/h̄. With the stiffness κ = Δt² α⁻¹ in the place of α̃⁻¹, eq. 26 of
//! Macklin et al. 2016 is `Δλ = −κ (C + γ ∇C·(x − xₙ)) / (1 + (1 + γ) κ Σ |∇ᵢC|²/mᵢ)`, which no bending at all does not break.

use bevy_cloth::physics::energy::hinge::{self, Rest};
use bevy_cloth::physics::math::{Lanes, Oct, Pack, Real, Scalar};
use bevy_cloth::physics::{Fabric, RestShape};

use super::batch::{Batches, pack};
use super::{Pass, Point};

/// All hinges.
pub(super) struct Hinges<T> {
    batches: Batches<4>,
    rest: Vec<(Rest<Pack<T>>, [Pack<T>; 4])>,
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
        let rest = (0..batches.len()).map(|batch| {
            let rest =
                Rest { stiffness: stiffness[batch], rest_angle: rest_angle[batch], normal_floor: normal_floor[batch] };
            (rest, masses.each_ref().map(|values| values[batch]))
        });
        Self { rest: rest.collect(), batches }
    }

    /// Solves each once.
    #[inline(always)]
    pub fn solve<S: Oct<T>>(&self, s: S, pass: &Pass, points: &mut [Point<T>]) {
        for (batch, (Rest { stiffness, rest_angle, normal_floor }, [m0, m1, m2, m3])) in self.rest.iter().enumerate() {
            let rest = Rest {
                stiffness: Lanes::load(s, stiffness),
                rest_angle: Lanes::load(s, rest_angle),
                normal_floor: Lanes::load(s, normal_floor),
            };
            let kappa = hinge::rigidity(&rest);
            let edges = if pass.value > 0.0 {
                self.batches.edges(s, batch, points)
            } else {
                self.batches.settled_edges(s, batch, points)
            };
            let angle = hinge::angle(edges, rest.normal_floor);
            let mut off = kappa.splat(0.0);
            if pass.value > 0.0 {
                off = hinge::deviation(angle.theta, rest.rest_angle);
            }
            if pass.rate > 0.0 {
                off += kappa.splat(pass.rate) * angle.change(self.batches.edge_moves(s, batch, points));
            }

            let inverse_masses = [kappa.like(m0), kappa.like(m1), kappa.like(m2), kappa.like(m3)];
            let [g0, g1, g2, g3] = angle.gradient;
            let mobility = inverse_masses[0] * g0.norm_squared()
                + inverse_masses[1] * g1.norm_squared()
                + inverse_masses[2] * g2.norm_squared()
                + inverse_masses[3] * g3.norm_squared();
            let kappa = kappa * kappa.splat(pass.dt2 / pass.compliance);
            let weight = kappa.splat(1.0) + kappa.splat(pass.mobility()) * kappa * mobility;
            let multiplier = kappa * off / weight * kappa.splat(-pass.relaxation);
            for (which, (gradient, mass)) in [g0, g1, g2, g3].into_iter().zip(inverse_masses).enumerate() {
                self.batches.shift(s, batch, which, gradient * (mass * multiplier), points);
            }
        }
    }
}
