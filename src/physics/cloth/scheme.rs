//! Which way a step is integrated, where it is linearised, and where the moves that were solved for lead.

use bevy::math::DVec3;

use super::State;
use super::engine::Step;
use super::implicit::{History, Implicit};
use super::integrator::{Bdf2, Integrator, hesitation};
use crate::physics::assembly::Projection;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::math::Scalar;

/// Newton iterations of a step whose length is far from that of the one before, and of the next, at least: linearised once,
/// they gain energy.
const CHANGE_NEWTON_STEPS: u32 = 2;

/// Share of the way ahead that a cloth which settles is linearised at: further on, its free folds and corners are driven by it as much
/// as the air slows them, and swing for long.
const SETTLING: f64 = 0.6;

/// How a step is integrated.
#[derive(Clone, Copy)]
pub(super) enum Scheme {
    BackwardEuler,
    /// Backward Euler where the length of steps changes: free fall, which it runs ahead of, is put right.
    Change,
    /// Half a step of backward Euler, continued to a whole one: second order from a single state.
    Midpoint,
    Bdf2(Bdf2),
}

/// What of the linear system depends on the scheme.
#[derive(Clone, Copy)]
pub(super) struct Linear {
    pub gamma: f64,
    pub projection: Projection,
    pub damping: f64,
    pub air_drag: f64,
    /// Share of the way to their waypoints that held vertices go.
    pub pin_share: f64,
}

impl<T: Scalar> Implicit<T> {
    /// The scheme of the next step, and its Newton iterations.
    pub fn scheme(&mut self, dt: f64) -> (Scheme, u32) {
        let bdf2 = self.history.dt.map(|previous| Bdf2::new(dt, previous));
        let changed = bdf2.is_some_and(|bdf2| bdf2.is_none());
        let scheme = match (self.settings.integrator, bdf2) {
            (Integrator::BackwardEuler, _) => Scheme::BackwardEuler,
            (Integrator::Bdf2, Some(None)) => Scheme::Change,
            (Integrator::Bdf2, Some(Some(bdf2))) => Scheme::Bdf2(bdf2),
            (Integrator::Bdf2, None) => Scheme::Midpoint,
        };
        let at_least = if changed || self.history.changed { CHANGE_NEWTON_STEPS } else { 1 };
        self.history.changed = changed;
        (scheme, self.settings.newton_steps.max(at_least))
    }

    /// Sets y, q and the point of linearisation.
    pub fn predict(&mut self, scheme: Scheme, dt: f64, settling: bool, state: &State) -> Linear {
        let Self { system, history: History { state: before, .. }, origin, inertial, point, .. } = self;
        let predict = |vertex: usize| {
            let (x, v) = (state.positions[vertex], state.velocities[vertex]);
            match scheme {
                Scheme::BackwardEuler | Scheme::Change => (x, x + dt * v, x),
                Scheme::Midpoint => (x, x + 0.5 * dt * v, x + 0.5 * dt * v),
                Scheme::Bdf2(bdf2) => {
                    let previous = before.velocities[vertex];
                    let origin = bdf2.combine(x, before.positions[vertex]);
                    let inertial = origin + bdf2.gamma * bdf2.combine(v, previous);
                    let mean = 0.5 * (v + previous);
                    let point = if settling {
                        x + SETTLING * dt * mean
                    } else {
                        inertial.lerp(x + dt * mean, hesitation(v, previous))
                    };
                    (origin, inertial, point)
                }
            }
        };
        let rows = (&mut origin[..], &mut inertial[..], &mut point[..]);
        for_parts(system.matrix.pattern().parts(), rows, &|part: &Part, (origin, inertial, point)| {
            for (i, vertex) in part.rows.clone().enumerate() {
                (origin[i], inertial[i], point[i]) = predict(vertex);
            }
        });
        let (gamma, projection, pin_share) = match scheme {
            Scheme::BackwardEuler | Scheme::Change => (dt, Projection::PositivePart, 1.0),
            Scheme::Midpoint => (0.5 * dt, Projection::Absolute, 0.5),
            Scheme::Bdf2(bdf2) => (bdf2.gamma, Projection::Absolute, 1.0),
        };
        Linear { gamma, projection, damping: self.damping, air_drag: self.air_drag, pin_share }
    }

    /// Where the moves lead.
    pub fn finish(&mut self, scheme: Scheme, step: Step, state: &State) {
        let dt = step.dt;
        let Self { system, inertia, origin, point, moves, candidate, .. } = self;
        let lead = |vertex: usize| {
            let (x, v) = (state.positions[vertex], state.velocities[vertex]);
            if let Some(waypoint) = step.pins.waypoint(vertex) {
                // A pin is reached to the last bit, whatever the precision of the solve.
                return (waypoint, (waypoint - x) / dt);
            }
            let reached = point[vertex] + moves[vertex];
            if inertia.get(vertex).is_some_and(|&factor| factor != 1.0) {
                return (reached, (point[vertex] - x + moves[vertex]) / dt);
            }
            match scheme {
                // Not `reached - x`, in which the digits of a small move are lost.
                Scheme::BackwardEuler | Scheme::Change => (reached, (point[vertex] - x + moves[vertex]) / dt),
                Scheme::Midpoint => (2.0 * reached - x, 4.0 / dt * (reached - x) - v),
                Scheme::Bdf2(bdf2) => (reached, (reached - origin[vertex]) / bdf2.gamma),
            }
        };
        let rows = (&mut candidate.positions[..], &mut candidate.velocities[..]);
        for_parts(system.matrix.pattern().parts(), rows, &|part: &Part, (positions, velocities)| {
            for (i, vertex) in part.rows.clone().enumerate() {
                (positions[i], velocities[i]) = lead(vertex);
            }
        });
        if matches!(scheme, Scheme::Change) && !step.pins.any() && self.contact.is_empty() {
            self.centre_on_trapezoid(step, state);
        }
    }

    /// Moves the candidate so that its centre of mass went at the mean of the velocities before and after. Only for cloth
    /// without pins: no stiffness has a part in that.
    fn centre_on_trapezoid(&mut self, step: Step, state: &State) {
        let Self { system, candidate, .. } = self;
        let parts = system.matrix.pattern().parts();
        let velocities = &candidate.velocities[..];
        let change = for_parts(parts, (), &|part: &Part, ()| {
            let rows = part.rows.clone();
            rows.map(|vertex| step.masses[vertex] * (velocities[vertex] - state.velocities[vertex])).sum::<DVec3>()
        });
        let ahead = 0.5 * step.dt / step.mass * change;
        for_parts(parts, &mut candidate.positions[..], &|_: &Part, positions| {
            for x in positions {
                *x -= ahead;
            }
        });
    }
}
