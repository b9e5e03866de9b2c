//! Drag of the air, `f = −α m (v − w)` with the wind w: what slows a cloth that hangs in still air.
//!
//! Linear in the velocity `v = (x' − q)/γ`, so it enters the step as it is: `γ α M` in A.

use bevy::math::DVec3;

use super::{Row, Substep, Term};
use crate::physics::assembly::ImplicitStep;
use crate::physics::material::Fabric;
use crate::physics::math::Scalar;

/// Drag in proportion to mass.
#[derive(Clone, Copy, Debug)]
pub struct AirDrag {
    /// α, 1/s.
    rate: f64,
}

impl AirDrag {
    /// As the fabric has it.
    pub fn new(fabric: &Fabric) -> Self {
        Self { rate: fabric.air_drag.into() }
    }
}

impl<T: Scalar> Term<T> for AirDrag {
    fn set_fabric(&mut self, fabric: &Fabric) {
        *self = Self::new(fabric);
    }

    fn add_rows(&self, at: &ImplicitStep, masses: &[f64], first: usize, rows: &mut [Row]) {
        if self.rate == 0.0 || !at.dissipates {
            return;
        }
        let rate = at.gamma * self.rate;
        let carried = at.gamma * at.wind;
        for (vertex, row) in (first..).zip(rows) {
            let drag = rate * masses[vertex];
            row.diagonal += drag;
            row.b -= drag * (at.x[vertex] - at.origin[vertex] - carried);
        }
    }

    /// What the wind pushes the cloth along by; what the air takes is not counted.
    fn work(&self, substep: &Substep, x: &[DVec3]) -> f64 {
        let Substep { x: start, held, masses, wind, dt, .. } = *substep;
        if self.rate == 0.0 || wind == DVec3::ZERO {
            return 0.0;
        }
        let pushed = |vertex: usize| {
            let way = x[vertex] - start[vertex];
            (self.rate * masses[vertex] * (wind - way / dt).dot(way)).max(0.0)
        };
        (0..x.len()).filter(|&vertex| !held[vertex]).map(pushed).sum()
    }
}
