//! The energy safeguard: no substep is taken that is not finite, or gains energy that nothing gave it.
//!
//! A substep from xₙ is accepted if the incremental potential of backward Euler (Gast et al. 2014, eq. 3),
//! `Φ(x) = ½ |x − xₙ − Δt vₙ|²_M / Δt² + Σ potentials(x)`, is no higher where it ends than at xₙ with the pins at their
//! new places, up to a tolerance: the work of pins and gravity is then part of the comparison, and what else the world does is
//! allowed for by the [`work`](crate::physics::terms::Term::work) of terms. Otherwise the [`descent`](super::descent) lowers Φ.
//!
//! Φ says where a substep may end, not how fast, and a tolerance used up in every substep would still add up. So there is an
//! [`Account`] too: what kinetic energy and potentials have gained together beyond the work of pins and of the world, and not lost
//! again since, is held below the same tolerance over any number of substeps, by scaling velocities down.

use bevy::math::DVec3;

use super::state::State;
use super::substep::Step;
use super::terms::Terms;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::cloth::StepReport;
use crate::physics::math::Scalar;

/// Share of the energy that a substep may gain: rounding, truncated solves, second-order steps.
const TOLERANCE: f64 = 0.05;
/// Share of the kinetic energy that must be left after slowing down: else the substep is taken again.
pub(super) const LEAST_KINETIC: f64 = 0.5;

/// The energy a cloth has, and what of it nothing gave.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Account {
    /// Potential of the present state that depends on positions alone, if known, J.
    pub stored: Option<f64>,
    /// Energy gained that nothing gave, and not lost again since, J.
    pub surplus: f64,
}

/// The energy a substep starts with, J.
#[derive(Clone, Copy)]
pub(super) struct Budget {
    /// Kinetic energy, and potentials at xₙ with the pins at their new places.
    pub start: f64,
    /// The part of that which depends on positions alone.
    pub stored: f64,
    /// What Φ may gain.
    tolerance: f64,
    /// What kinetic energy and potentials may gain.
    pub gain: f64,
}

/// Potentials of a trial state, J.
#[derive(Clone, Copy)]
pub(super) struct Reached {
    /// What depends on positions alone.
    pub stored: f64,
    /// What depends on the substep too.
    pub driven: f64,
}

impl Budget {
    /// The same with more to start with, J.
    pub fn with(self, more: f64) -> Self {
        Self { start: self.start + more, ..self }
    }
}

impl Reached {
    /// Of vertices at `x`, where the substep may end.
    pub fn new<T: Scalar>(terms: &mut Terms<T>, step: &Step, x: &[DVec3]) -> Self {
        Self { stored: terms.system.stored(x), driven: terms.system.driven(&step.start, x) }
    }

    /// Φ, J.
    pub fn phi(&self, parts: &[Part], step: &Step, x: &[DVec3]) -> f64 {
        inertia(parts, step, x) + self.driven + self.stored
    }
}

impl Account {
    /// What a substep may spend. `dragged` is memory for where pins drag the cloth.
    pub fn open<T: Scalar>(&mut self, terms: &mut Terms<T>, step: &Step, dragged: &mut Vec<DVec3>) -> Budget {
        let start = &step.start;
        let now = *self.stored.get_or_insert_with(|| terms.system.stored(start.x));
        let kinetic = kinetic(terms.parts(), step, DVec3::ZERO, start.v);
        let fall = start.mass * start.gravity.length_squared() * start.dt * start.dt;
        let tolerance = TOLERANCE * (kinetic + now + fall);
        let moved = step.pins.waypoints().any(|(vertex, waypoint)| waypoint != start.x[vertex]);
        drag_pins(step, dragged);
        let driven = terms.system.driven(start, dragged);
        let stored = if moved {
            // Bent so far at once, the turns of mid-edge normals are far from where they belong, and energy that they hold is not
            // the work of pins.
            terms.system.stored_within(now + tolerance, dragged)
        } else {
            now
        };
        let gain = (tolerance - self.surplus).max(0.0);
        Budget { start: kinetic + stored + driven, stored, tolerance, gain }
    }

    /// The stored potential of a candidate, J, if it is finite and within the budget, slowed down a little if need be.
    pub fn accept<T: Scalar>(
        &mut self,
        mut budget: Budget,
        terms: &mut Terms<T>,
        candidate: &mut State,
        step: &Step,
        report: &mut StepReport,
    ) -> Option<f64> {
        let reached = Reached::new(terms, step, &candidate.positions);
        let end = reached.phi(terms.parts(), step, &candidate.positions);
        budget.start += terms.work(step, &candidate.positions);
        // Not a number is no less than the budget either.
        let within = end <= budget.start + budget.tolerance;
        (within && self.slow_down(LEAST_KINETIC, &budget, reached, terms.parts(), candidate, step, report))
            .then_some(reached.stored)
    }

    /// Takes out of the velocities of the candidate what kinetic energy is beyond the budget, if at least this share of it is left
    /// then, and keeps account of what was gained.
    #[expect(clippy::too_many_arguments, reason = "values of three stages")]
    pub fn slow_down(
        &mut self,
        least: f64,
        budget: &Budget,
        reached: Reached,
        parts: &[Part],
        candidate: &mut State,
        step: &Step,
        report: &mut StepReport,
    ) -> bool {
        let kinetic = kinetic(parts, step, DVec3::ZERO, &candidate.velocities);
        let before = budget.start - reached.driven - reached.stored;
        let allowed = (before + budget.gain).max(0.0);
        if kinetic > allowed {
            if allowed < least * kinetic {
                return false;
            }
            report.velocity_clamps += 1;
            let scale = (allowed / kinetic).sqrt();
            candidate.velocities.iter_mut().for_each(|v| *v *= scale);
        }
        self.surplus = (self.surplus + kinetic.min(allowed) - before).max(0.0);
        true
    }
}

/// xₙ with held vertices at their waypoints, m.
pub(super) fn drag_pins(step: &Step, out: &mut Vec<DVec3>) {
    out.clear();
    out.extend_from_slice(step.start.x);
    for (vertex, waypoint) in step.pins.waypoints() {
        out[vertex] = waypoint;
    }
}

/// Sum over the free vertices.
fn sum(parts: &[Part], step: &Step, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    let held = step.start.held;
    for_parts(parts, (), &|part: &Part, ()| part.rows.clone().filter(|&vertex| !held[vertex]).map(&term).sum::<f64>())
}

/// Kinetic energy of the free vertices in a frame of this velocity, J.
pub(super) fn kinetic(parts: &[Part], step: &Step, frame: DVec3, velocities: &[DVec3]) -> f64 {
    sum(parts, step, |v| 0.5 * step.start.masses[v] * velocities[v].distance_squared(frame))
}

/// Φ's part of inertia, of the free vertices, J.
fn inertia(parts: &[Part], step: &Step, x: &[DVec3]) -> f64 {
    let start = &step.start;
    let rate = 0.5 / (start.dt * start.dt);
    sum(parts, step, |v| {
        let gap = x[v] - start.x[v] - start.dt * start.v[v];
        start.masses[v] * rate * gap.length_squared()
    })
}
