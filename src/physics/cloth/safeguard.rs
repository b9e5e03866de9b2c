//! The energy safeguard: no step is taken that is not finite, or gains energy that nothing gave it.
//!
//! A step from xₙ is accepted if the incremental potential of backward Euler (Gast et al. 2014, eq. 3),
//! `Φ(x) = ½ |x − xₙ − Δt vₙ|²_M / Δt² + E(x) − g·M (x − xₙ)`, is no higher where it ends than at xₙ with the pins at their
//! new places, up to a tolerance: the work of pins and gravity is then part of the comparison. Otherwise Φ is lowered from xₙ
//! by Newton steps with a line search, which bounds the energy whatever the time step and the state.
//!
//! Φ says where a step may end, not how fast, and a tolerance used up in every step would still add up. So there is an account too:
//! what kinetic, elastic and gravity's energy have gained together beyond the work of the pins, and not lost again since, is held
//! below the same tolerance over any number of steps, by scaling velocities down.

use bevy::math::DVec3;

use super::engine::Step;
use super::implicit::{Guess, Implicit};
use super::scheme::Linear;
use super::{ClothFault, State, StepReport};
use crate::physics::assembly::Projection;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::math::Scalar;

/// Share of kinetic, elastic and gravity's energy that a step may gain: rounding, truncated solves, second-order steps.
const TOLERANCE: f64 = 0.05;
/// Share of the kinetic energy that must be left after slowing down: else the step is taken again.
const LEAST_KINETIC: f64 = 0.5;
/// Newton steps of the fallback.
const NEWTON_STEPS: u32 = 3;
/// Halvings of a Newton step: a flat sheet as stiff as steel that falls for a second bends within a millionth of the fall.
const HALVINGS: u32 = 24;
/// Shares of a Newton step below this must lower Φ: else they are no step.
const LEAST_SHARE: f64 = 1e-3;
/// Sufficient decrease (Armijo), as a share of the slope.
const DECREASE: f64 = 1e-4;
/// Share of what is left of the budget that may be spent where no step lowers Φ.
const LAST_RESORT: f64 = 0.25;
/// Error of an elastic energy in units in the last place: below that no decrease can be told.
const ROUNDINGS: f64 = 8.0;

/// The energy a step starts with, J.
pub(super) struct Budget {
    /// Φ at xₙ with the pins at their new places.
    start: f64,
    /// Elastic energy there.
    elastic: f64,
    /// What Φ may gain.
    tolerance: f64,
    /// What kinetic, elastic and gravity's energy may gain.
    gain: f64,
}

impl<T: Scalar> Implicit<T> {
    /// What the step may spend.
    pub fn checked(&mut self, step: Step, state: &State) -> Budget {
        let now = *self.energy_now.get_or_insert_with(|| self.system.energy(&state.positions).total());
        let kinetic = self.kinetic(step, &state.velocities);
        let fall = step.mass * step.gravity.length_squared() * step.dt * step.dt;
        let tolerance = TOLERANCE * (kinetic + now + fall);
        let moved = step.pins.waypoints().any(|(vertex, waypoint)| waypoint != state.positions[vertex]);
        let elastic = if moved {
            self.start_with_pins_moved(step, state);
            let mut dragged = self.system.energy(&self.point);
            if dragged.bending > now + tolerance {
                // Bent so far at once, the turns of mid-edge normals are far from where they belong, and energy that they hold is
                // not the work of pins.
                self.system.settle(&self.point);
                dragged = self.system.energy(&self.point);
            }
            dragged.total()
        } else {
            now
        };
        Budget { start: kinetic + elastic, elastic, tolerance, gain: (tolerance - self.surplus).max(0.0) }
    }

    /// The elastic energy of the candidate, if it is finite and within the budget, slowed down a little if need be.
    pub fn acceptable(
        &mut self,
        budget: &mut Budget,
        step: Step,
        state: &State,
        report: &mut StepReport,
    ) -> Option<f64> {
        let elastic = self.system.energy(&self.candidate.positions).total();
        let end = self.potential(step, state, elastic);
        budget.start += self.contact.work(&state.positions, &self.candidate.positions);
        // Not a number is no less than the budget either.
        let within = end <= budget.start + budget.tolerance;
        (within && self.slow_down(LEAST_KINETIC, budget, elastic, step, state, report)).then_some(elastic)
    }

    /// Lowers Φ from xₙ, and returns the elastic energy of the candidate it found.
    pub fn fall_back(
        &mut self,
        mut budget: Budget,
        step: Step,
        state: &State,
        report: &mut StepReport,
    ) -> Result<f64, ClothFault> {
        let dt = step.dt;
        self.start_with_pins_moved(step, state);
        for (y, (&x, &v)) in self.inertial.iter_mut().zip(state.positions.iter().zip(&state.velocities)) {
            *y = x + dt * v;
        }
        self.inertia.clear();
        self.candidate.positions.copy_from_slice(&self.point);
        if self.guard(step, state) > 0 {
            // Like what pins are dragged to, what colliders push before them is their work.
            let pushed = self.system.energy(&self.candidate.positions).total();
            self.point.copy_from_slice(&self.candidate.positions);
            budget.start = self.potential(step, state, pushed);
            budget.elastic = pushed;
        }
        self.contact.brace(&self.point);
        let mut reached = (budget.start + self.contact.potential(&self.point), budget.elastic);
        if !budget.start.is_finite() {
            return Err(ClothFault::NotFinite);
        }
        let flying = !step.pins.any() && self.contact.is_empty();
        if flying {
            self.carry_on(step, state);
            self.candidate.positions.copy_from_slice(&self.point);
            reached.0 = self.potential(step, state, budget.elastic);
        }
        // Damping and drag only take energy away, so the model may leave them out.
        let linear =
            Linear { gamma: dt, projection: Projection::PositivePart, damping: 0.0, air_drag: 0.0, pin_share: 1.0 };
        for newton in 0..NEWTON_STEPS {
            self.contact.choose(&self.point);
            match self.solve(linear, Guess::Downhill, step, state, report) {
                Ok(()) => {}
                Err(ClothFault::Solver) => self.descend_by_diagonal(step),
                Err(fault) if newton == 0 => return Err(fault),
                Err(_) => break,
            }
            if self.find_late_contact(step, state) {
                self.contact.brace(&self.point);
                if self.solve(linear, Guess::Downhill, step, state, report).is_err() {
                    break;
                }
            }
            // A solve brings the turns of mid-edge normals closer to their minimum: that is no work of the moves.
            let elastic = self.system.energy(&self.point).total();
            let relaxed = reached.1 - elastic;
            reached = (reached.0 - relaxed, elastic);
            if newton == 0 {
                budget.start -= relaxed;
            }
            let mut found = self.search(reached, 0.0, step, state);
            if found.is_none() && newton == 0 {
                // The gradient of a collapsed triangle is not quite that of its energy, and may spoil the moves of all. Rather than
                // stand still for ever the cloth may use up some of its budget.
                self.descend_by_diagonal(step);
                let downhill = self.search(reached, 0.0, step, state);
                found = downhill.or_else(|| self.search(reached, LAST_RESORT * budget.gain, step, state));
            }
            let Some(lower) = found else { break };
            core::mem::swap(&mut self.point, &mut self.candidate.positions);
            reached = lower;
        }
        let elastic = reached.1;
        if flying {
            self.carry_on(step, state);
        }
        let Self { point, candidate, .. } = self;
        candidate.positions.copy_from_slice(point);
        for (v, (&new, &old)) in candidate.velocities.iter_mut().zip(point.iter().zip(&state.positions)) {
            *v = (new - old) / dt;
        }
        self.contact.settle(&self.candidate.positions);
        budget.start += self.contact.work(&state.positions, &self.candidate.positions);
        self.slow_down(0.0, &budget, elastic, step, state, report);
        Ok(elastic)
    }

    /// Shifts the point of a cloth that nothing holds, so that its centre goes where inertia and gravity take it: elastic forces have
    /// no part in that, but for rounding. Nothing lowers Φ further, and whatever else fails, the cloth flies on.
    fn carry_on(&mut self, step: Step, state: &State) {
        let mut missing = step.mass * step.dt * step.dt * step.gravity;
        for (vertex, &mass) in step.masses.iter().enumerate() {
            let moved = self.point[vertex] - state.positions[vertex];
            missing += mass * (step.dt * state.velocities[vertex] - moved);
        }
        let shift = missing / step.mass;
        for x in &mut self.point {
            *x += shift;
        }
    }

    /// Moves along the gradient, scaled by the diagonal of the matrix, in place of a solve that failed.
    fn descend_by_diagonal(&mut self, step: Step) {
        let Self { system, moves, .. } = self;
        for (vertex, moved) in moves.iter_mut().enumerate() {
            let diagonal = system.matrix.diagonal(vertex).0;
            let largest = (0..3).map(|i| diagonal[i][i].to_f64()).fold(step.masses[vertex], f64::max);
            *moved = DVec3::from(system.rhs[vertex].to_f64()) / largest;
        }
    }

    /// Backtracks along `moves` from `point`, of this Φ and elastic energy, until Φ falls enough, or rises by no more than
    /// `slack`; `candidate` is then the new point, with its Φ and elastic energy.
    fn search(&mut self, (phi, elastic): (f64, f64), slack: f64, step: Step, state: &State) -> Option<(f64, f64)> {
        let held = step.pins.held();
        // b = −Δt² ∇Φ at the free vertices; it has not been touched by the solve.
        let slope = -(0..held.len())
            .filter(|&v| !held[v])
            .map(|v| DVec3::from(self.system.rhs[v].to_f64()).dot(self.moves[v]))
            .sum::<f64>()
            / (step.dt * step.dt);
        let slack = slack + ROUNDINGS * T::EPSILON * elastic;
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            for (vertex, c) in self.candidate.positions.iter_mut().enumerate() {
                let d = if held[vertex] { DVec3::ZERO } else { self.moves[vertex] };
                *c = self.point[vertex] + share * d;
            }
            self.guard(step, state);
            let elastic = self.system.energy(&self.candidate.positions).total();
            let lower = self.potential(step, state, elastic) + self.contact.potential(&self.candidate.positions);
            if lower <= phi + DECREASE * share * slope.min(0.0) + if share < LEAST_SHARE { 0.0 } else { slack } {
                return Some((lower, elastic));
            }
            share *= 0.5;
        }
        None
    }

    /// Takes out of the velocities of the candidate what kinetic energy is beyond the budget, if at least this share of it is left
    /// then, and keeps account of what was gained.
    fn slow_down(
        &mut self,
        least: f64,
        budget: &Budget,
        elastic: f64,
        step: Step,
        state: &State,
        report: &mut StepReport,
    ) -> bool {
        let kinetic = self.kinetic(step, &self.candidate.velocities);
        let x = &self.candidate.positions;
        let fallen = self.sum(step, |v| step.masses[v] * step.gravity.dot(x[v] - state.positions[v]));
        let before = budget.start + fallen - elastic;
        let allowed = (before + budget.gain).max(0.0);
        if kinetic > allowed {
            if allowed < least * kinetic {
                return false;
            }
            report.velocity_clamps += 1;
            let scale = (allowed / kinetic).sqrt();
            for v in &mut self.candidate.velocities {
                *v *= scale;
            }
        }
        self.surplus = (self.surplus + kinetic.min(allowed) - before).max(0.0);
        true
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
    pub fn kinetic(&self, step: Step, velocities: &[DVec3]) -> f64 {
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
