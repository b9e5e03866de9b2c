//! The energy safeguard: no step is taken that is not finite, or gains energy that nothing gave it.
//!
//! A step from xₙ is accepted if the incremental potential of backward Euler (Gast et al. 2014, eq. 3),
//! `Φ(x) = ½ |x − xₙ − Δt vₙ|²_M / Δt² + E(x) − g·M (x − xₙ)`, is no higher where it ends than at xₙ with the pins at their
//! new places, up to a tolerance: the work of pins and gravity is then part of the comparison. Otherwise Φ is lowered from xₙ
//! by Newton steps with a line search, which bounds the energy whatever the time step and the state; and should even that
//! leave too much of it, velocities are scaled down.

use bevy::math::DVec3;

use super::engine::Step;
use super::implicit::{Guess, Implicit, Linear};
use super::{ClothFault, State, StepReport};
use crate::physics::assembly::Projection;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::math::Scalar;

/// Share of kinetic, elastic and gravity's energy that a step may gain: rounding, truncated solves, second-order steps.
const TOLERANCE: f64 = 0.05;
/// Newton steps of the fallback.
const NEWTON_STEPS: u32 = 3;
/// Halvings of a Newton step.
const HALVINGS: u32 = 12;
/// Sufficient decrease (Armijo), as a share of the slope.
const DECREASE: f64 = 1e-4;

/// The energy a step starts with, J.
pub(super) struct Budget {
    /// Φ at xₙ with the pins at their new places.
    start: f64,
    /// Elastic energy there.
    elastic: f64,
    tolerance: f64,
}

impl<T: Scalar> Implicit<T> {
    /// What the step may spend.
    pub fn checked(&mut self, step: Step, state: &State) -> Budget {
        let now = *self.energy_now.get_or_insert_with(|| self.system.energy(&state.positions).total());
        let moved = step.pins.waypoints().any(|(vertex, waypoint)| waypoint != state.positions[vertex]);
        let elastic = if moved {
            self.start_with_pins_moved(step, state);
            self.system.energy(&self.point).total()
        } else {
            now
        };
        let kinetic = self.kinetic(step, &state.velocities);
        let fall = step.mass * step.gravity.length_squared() * step.dt * step.dt;
        Budget { start: kinetic + elastic, elastic, tolerance: TOLERANCE * (kinetic + now + fall) }
    }

    /// The elastic energy of the candidate, if it is finite and within the budget.
    pub fn acceptable(&mut self, budget: &Budget, step: Step, state: &State) -> Option<f64> {
        let elastic = self.system.energy(&self.candidate.positions).total();
        let end = self.potential(step, state, elastic);
        // Not a number is no less than the budget either.
        (end <= budget.start + budget.tolerance).then_some(elastic)
    }

    /// Lowers Φ from xₙ, and returns the elastic energy of the candidate it found.
    pub fn fall_back(
        &mut self,
        budget: &Budget,
        step: Step,
        state: &State,
        report: &mut StepReport,
    ) -> Result<f64, ClothFault> {
        let dt = step.dt;
        self.start_with_pins_moved(step, state);
        for (y, (&x, &v)) in self.inertial.iter_mut().zip(state.positions.iter().zip(&state.velocities)) {
            *y = x + dt * v;
        }
        let (mut elastic, mut phi) = (budget.elastic, budget.start);
        if !phi.is_finite() {
            return Err(ClothFault::NotFinite);
        }
        // Damping and drag only take energy away, so the model may leave them out.
        let linear =
            Linear { gamma: dt, projection: Projection::PositivePart, damping: 0.0, air_drag: 0.0, pin_share: 1.0 };
        for newton in 0..NEWTON_STEPS {
            match self.solve(linear, Guess::Inertia, step, state, report) {
                Ok(()) => {}
                Err(fault) if newton == 0 => return Err(fault),
                Err(_) => break,
            }
            let Some((lower, energy)) = self.search(phi, step, state) else { break };
            core::mem::swap(&mut self.point, &mut self.candidate.positions);
            (phi, elastic) = (lower, energy);
        }
        let Self { point, candidate, .. } = self;
        candidate.positions.copy_from_slice(point);
        for (v, (&new, &old)) in candidate.velocities.iter_mut().zip(point.iter().zip(&state.positions)) {
            *v = (new - old) / dt;
        }
        self.clamp_velocities(budget, elastic, step, state, report);
        Ok(elastic)
    }

    /// Backtracks along `moves` from `point` until Φ falls enough; `candidate` is then the new point, with its Φ and elastic
    /// energy.
    fn search(&mut self, phi: f64, step: Step, state: &State) -> Option<(f64, f64)> {
        let held = step.pins.held();
        // b = −Δt² ∇Φ at the free vertices; it has not been touched by the solve.
        let slope = -(0..held.len())
            .filter(|&v| !held[v])
            .map(|v| DVec3::from(self.system.rhs[v].to_f64()).dot(self.moves[v]))
            .sum::<f64>()
            / (step.dt * step.dt);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            for (vertex, c) in self.candidate.positions.iter_mut().enumerate() {
                let d = if held[vertex] { DVec3::ZERO } else { self.moves[vertex] };
                *c = self.point[vertex] + share * d;
            }
            let elastic = self.system.energy(&self.candidate.positions).total();
            let lower = self.potential(step, state, elastic);
            if lower <= phi + DECREASE * share * slope.min(0.0) {
                return Some((lower, elastic));
            }
            share *= 0.5;
        }
        None
    }

    /// Takes out of the velocities what kinetic energy is beyond the budget.
    fn clamp_velocities(&mut self, budget: &Budget, elastic: f64, step: Step, state: &State, report: &mut StepReport) {
        let kinetic = self.kinetic(step, &self.candidate.velocities);
        let x = &self.candidate.positions;
        let fallen = self.sum(step, |v| step.masses[v] * step.gravity.dot(x[v] - state.positions[v]));
        let allowed = (budget.start + budget.tolerance - elastic + fallen).max(0.0);
        if kinetic > allowed {
            report.velocity_clamps += 1;
            let scale = (allowed / kinetic).sqrt();
            for v in &mut self.candidate.velocities {
                *v *= scale;
            }
        }
    }

    /// Puts the point of linearisation at xₙ with held vertices at their waypoints.
    fn start_with_pins_moved(&mut self, step: Step, state: &State) {
        self.point.copy_from_slice(&state.positions);
        for (vertex, waypoint) in step.pins.waypoints() {
            self.point[vertex] = waypoint;
        }
    }

    /// Sum over the free vertices.
    fn sum(&self, step: Step, term: impl Fn(usize) -> f64 + Sync) -> f64 {
        let held = step.pins.held();
        for_parts(self.system.matrix.pattern().parts(), (), &|part: &Part, ()| {
            part.rows.clone().filter(|&vertex| !held[vertex]).map(&term).sum::<f64>()
        })
    }

    /// Kinetic energy of the free vertices, J.
    fn kinetic(&self, step: Step, velocities: &[DVec3]) -> f64 {
        self.sum(step, |v| 0.5 * step.masses[v] * velocities[v].length_squared())
    }

    /// Φ of the free vertices of the candidate, J.
    fn potential(&self, step: Step, state: &State, elastic: f64) -> f64 {
        let rate = 1.0 / (step.dt * step.dt);
        let x = &self.candidate.positions;
        let inertia_and_fall = self.sum(step, |v| {
            let moved = x[v] - state.positions[v];
            let gap = moved - step.dt * state.velocities[v];
            step.masses[v] * (0.5 * rate * gap.length_squared() - step.gravity.dot(moved))
        });
        inertia_and_fall + elastic
    }
}
