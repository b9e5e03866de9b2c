//! What is done instead of a substep that was not accepted: Φ is lowered from xₙ by Newton steps with a line search, which bounds
//! the energy whatever the length of the substep and the state.

use bevy::math::DVec3;

use super::acceptance::{Account, Budget, Reached, drag_pins};
use super::newton::{Guess, Iterate, Newton};
use super::prediction::{Linear, Prediction};
use super::state::State;
use super::substep::Step;
use super::terms::Terms;
use crate::physics::assembly::Projection;
use crate::physics::cloth::{ClothFault, StepReport};
use crate::physics::math::Scalar;

/// Newton steps.
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

/// A descent from xₙ.
pub(super) struct Descent<'a, 'b, T: Scalar> {
    pub terms: &'a mut Terms<T>,
    pub newton: &'a mut Newton<T>,
    pub step: &'a Step<'b>,
    /// Memory for y and q, for the point that was reached with the moves from there, and for a trial state.
    pub prediction: &'a mut Prediction,
    pub iterate: &'a mut Iterate,
    pub candidate: &'a mut State,
}

/// A point that a search has led to.
#[derive(Clone, Copy)]
struct Lower {
    /// Φ with what holds for this substep alone, J.
    phi: f64,
    potential: Reached,
    /// Vertices that were moved out of colliders there.
    rescues: u32,
}

impl<T: Scalar> Descent<'_, '_, T> {
    /// Lowers Φ; the candidate is then where that led. Returns its stored potential, J, and how many of its vertices were moved out
    /// of colliders.
    pub fn run(
        &mut self,
        mut budget: Budget,
        account: &mut Account,
        report: &mut StepReport,
    ) -> Result<(f64, u32), ClothFault> {
        let step = self.step;
        let dt = step.start.dt;
        let mut reached = self.begin(&mut budget)?;
        let flying = !step.pins.any() && self.terms.contact.is_empty() && !self.terms.hold();
        if flying {
            self.carry_on();
            self.candidate.positions.copy_from_slice(&self.iterate.point);
            reached.phi = self.phi(reached.potential);
        }
        // Damping and drag only take energy away, so the model may leave them out.
        let linear = Linear { gamma: dt, projection: Projection::PositivePart, dissipates: false, pin_share: 1.0 };
        for newton in 0..NEWTON_STEPS {
            self.terms.contact.choose(&self.iterate.point);
            match self.solve(linear, report) {
                Ok(()) => {}
                Err(ClothFault::Solver) => self.move_by_diagonal(),
                Err(fault) if newton == 0 => return Err(fault),
                Err(_) => break,
            }
            let Self { terms, iterate, .. } = self;
            if terms.contact.find_late(&step.around, &step.start, |vertex| iterate.at(vertex)) {
                terms.contact.brace(&iterate.point);
                if self.solve(linear, report).is_err() {
                    break;
                }
            }
            // A solve brings the turns of mid-edge normals closer to their minimum: that is no work of the moves.
            let stored = self.terms.system.stored(&self.iterate.point);
            let relaxed = reached.potential.stored - stored;
            reached.phi -= relaxed;
            reached.potential.stored = stored;
            if newton == 0 {
                budget.start -= relaxed;
            }
            let mut found = self.search(reached, 0.0);
            if found.is_none() && newton == 0 {
                // The gradient of a collapsed triangle is not quite that of its energy, and may spoil the moves of all. Rather than
                // stand still for ever the cloth may use up some of its budget.
                self.move_by_diagonal();
                found = self.search(reached, 0.0).or_else(|| self.search(reached, LAST_RESORT * budget.gain));
            }
            let Some(lower) = found else { break };
            core::mem::swap(&mut self.iterate.point, &mut self.candidate.positions);
            reached = lower;
        }
        if flying {
            self.carry_on();
        }
        self.end(&budget, account, reached.potential, report);
        Ok((reached.potential.stored, reached.rescues))
    }

    /// Puts the cloth where pins and colliders drag it, and says what Φ is there.
    fn begin(&mut self, budget: &mut Budget) -> Result<Lower, ClothFault> {
        let Self { terms, step, prediction, iterate, candidate, .. } = self;
        let start = &step.start;
        drag_pins(step, &mut iterate.point);
        prediction.inertia.clear();
        for (y, (&x, &v)) in prediction.inertial.iter_mut().zip(start.x.iter().zip(start.v)) {
            *y = x + start.dt * v;
        }
        candidate.positions.copy_from_slice(&iterate.point);
        let State { positions, velocities } = &mut **candidate;
        let mut potential = Reached { stored: budget.stored, driven: terms.system.driven(start, &iterate.point) };
        let rescues = terms.contact.guard(&step.around, start, positions, velocities);
        if rescues > 0 {
            // Like what pins are dragged to, what colliders push before them is their work.
            iterate.point.copy_from_slice(positions);
            potential = Reached::new(terms, step, positions);
            budget.start = potential.phi(terms.parts(), step, positions);
        }
        terms.contact.brace(&iterate.point);
        if !budget.start.is_finite() {
            return Err(ClothFault::NotFinite);
        }
        Ok(Lower { phi: budget.start + terms.substep_potential(&iterate.point), potential, rescues })
    }

    /// Φ of the candidate, without what holds for this substep alone, J.
    fn phi(&self, potential: Reached) -> f64 {
        potential.phi(self.terms.parts(), self.step, &self.candidate.positions)
    }

    fn solve(&mut self, linear: Linear, report: &mut StepReport) -> Result<(), ClothFault> {
        let Self { terms, newton, step, prediction, iterate, .. } = self;
        newton.solve(terms, linear, Guess::Downhill, (prediction, iterate), step, report)
    }

    /// Shifts the point of a cloth that nothing holds, so that its center goes where inertia and gravity take it: elastic forces have
    /// no part in that, but for rounding. Nothing lowers Φ further, and whatever else fails, the cloth flies on.
    fn carry_on(&mut self) {
        let start = &self.step.start;
        let mut missing = start.mass * start.dt * start.dt * start.gravity;
        for (vertex, &mass) in start.masses.iter().enumerate() {
            let moved = self.iterate.point[vertex] - start.x[vertex];
            missing += mass * (start.dt * start.v[vertex] - moved);
        }
        let shift = missing / start.mass;
        for x in &mut self.iterate.point {
            *x += shift;
        }
    }

    /// Moves along the gradient, scaled by the diagonal of the matrix, in place of a solve that failed.
    fn move_by_diagonal(&mut self) {
        let Self { terms, step, iterate, .. } = self;
        let system = &terms.system;
        for (vertex, moved) in iterate.moves.iter_mut().enumerate() {
            let diagonal = system.matrix.diagonal(vertex).0;
            let largest = (0..3).map(|i| diagonal[i][i].to_f64()).fold(step.start.masses[vertex], f64::max);
            *moved = DVec3::from(system.rhs[vertex].to_f64()) / largest;
        }
    }

    /// Backtracks along the moves from a point until Φ falls enough, or rises by no more than `slack`; the candidate is then the
    /// new point.
    fn search(&mut self, from: Lower, slack: f64) -> Option<Lower> {
        let Self { terms, step, iterate, candidate, .. } = self;
        let held = step.start.held;
        // b = −Δt² ∇Φ at the free vertices; it has not been touched by the solve.
        let slope = -(0..held.len())
            .filter(|&v| !held[v])
            .map(|v| DVec3::from(terms.system.rhs[v].to_f64()).dot(iterate.moves[v]))
            .sum::<f64>()
            / (step.start.dt * step.start.dt);
        let slack = slack + ROUNDINGS * T::EPSILON * from.potential.stored;
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            for (vertex, c) in candidate.positions.iter_mut().enumerate() {
                let d = if held[vertex] { DVec3::ZERO } else { iterate.moves[vertex] };
                *c = iterate.point[vertex] + share * d;
            }
            let State { positions, velocities } = &mut **candidate;
            let rescues = terms.contact.guard(&step.around, &step.start, positions, velocities);
            let potential = Reached::new(terms, step, positions);
            let phi = potential.phi(terms.parts(), step, positions) + terms.substep_potential(positions);
            if phi <= from.phi + DECREASE * share * slope.min(0.0) + if share < LEAST_SHARE { 0.0 } else { slack } {
                return Some(Lower { phi, potential, rescues: rescues.max(from.rescues) });
            }
            share *= 0.5;
        }
        None
    }

    /// Makes the point that was reached the candidate, with velocities within the budget.
    fn end(&mut self, budget: &Budget, account: &mut Account, potential: Reached, report: &mut StepReport) {
        let Self { terms, step, iterate, candidate, .. } = self;
        let start = &step.start;
        candidate.positions.copy_from_slice(&iterate.point);
        for (v, (&new, &old)) in candidate.velocities.iter_mut().zip(iterate.point.iter().zip(start.x)) {
            *v = (new - old) / start.dt;
        }
        terms.contact.settle(&candidate.positions);
        let budget = budget.with(terms.work(step, &candidate.positions));
        account.slow_down(0.0, &budget, potential, terms.parts(), candidate, step, report);
    }
}
