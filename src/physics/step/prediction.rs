//! Where a substep comes from, where inertia leads, and where it is linearized; and where the moves that were solved for lead.

use bevy::math::DVec3;

use super::integrator::hesitation;
use super::newton::Iterate;
use super::plan::Scheme;
use super::state::{History, State};
use super::substep::Step;
use crate::physics::assembly::Projection;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::contact::ContactLayer;

/// Share of the way ahead that a cloth which settles is linearized at: further on, its free folds and corners are driven by it as much
/// as the air slows them, and swing for long.
const SETTLING: f64 = 0.6;

/// What the scheme gives the linear system, by vertex. See [`ImplicitStep`](crate::physics::assembly::ImplicitStep).
#[derive(Default)]
pub(super) struct Prediction {
    /// q, m.
    pub origin: Vec<DVec3>,
    /// y, m.
    pub inertial: Vec<DVec3>,
    /// Where the forces are linearized first, m.
    pub point: Vec<DVec3>,
    /// Factors of M; empty if all are 1.
    pub inertia: Vec<f64>,
}

/// What of the linear system is one for all vertices.
#[derive(Clone, Copy)]
pub(super) struct Linear {
    /// γ, s.
    pub gamma: f64,
    pub projection: Projection,
    /// Whether material damping and drag take part.
    pub dissipates: bool,
    /// Share of the way to their waypoints that held vertices go.
    pub pin_share: f64,
}

impl Scheme {
    /// What of the linear system depends on the scheme, for a substep of `dt` seconds.
    pub fn linear(self, dt: f64) -> Linear {
        let (gamma, projection, pin_share) = match self {
            Self::BackwardEuler | Self::Change => (dt, Projection::PositivePart, 1.0),
            Self::Midpoint => (0.5 * dt, Projection::Absolute, 0.5),
            Self::Bdf2(bdf2) => (bdf2.gamma, Projection::Absolute, 1.0),
        };
        Linear { gamma, projection, dissipates: true, pin_share }
    }
}

impl Prediction {
    /// By a scheme, in the memory of an earlier one. A cloth that has nearly come to rest on something of this velocity (m/s) is
    /// linearized further back.
    pub fn new(
        memory: Self,
        scheme: Scheme,
        settling_on: Option<DVec3>,
        step: &Step,
        history: &History,
        parts: &[Part],
    ) -> Self {
        let Self { mut origin, mut inertial, mut point, mut inertia } = memory;
        let (dt, before) = (step.start.dt, &history.state);
        inertia.clear();
        for points in [&mut origin, &mut inertial, &mut point] {
            points.resize(step.start.x.len(), DVec3::ZERO);
        }
        let predict = |vertex: usize| {
            let (x, v) = (step.start.x[vertex], step.start.v[vertex]);
            match scheme {
                Scheme::BackwardEuler | Scheme::Change => (x, x + dt * v, x),
                Scheme::Midpoint => (x, x + 0.5 * dt * v, x + 0.5 * dt * v),
                Scheme::Bdf2(bdf2) => {
                    let previous = before.velocities[vertex];
                    let origin = bdf2.combine(x, before.positions[vertex]);
                    let inertial = origin + bdf2.gamma * bdf2.combine(v, previous);
                    let mean = 0.5 * (v + previous);
                    let point = match settling_on {
                        Some(surface) => x + dt * (surface + SETTLING * (mean - surface)),
                        None => {
                            let frame = step.start.frame;
                            inertial.lerp(x + dt * mean, hesitation(v - frame, previous - frame))
                        }
                    };
                    (origin, inertial, point)
                }
            }
        };
        let rows = (&mut origin[..], &mut inertial[..], &mut point[..]);
        for_parts(parts, rows, &|part: &Part, (origin, inertial, point)| {
            for (i, vertex) in part.rows.clone().enumerate() {
                (origin[i], inertial[i], point[i]) = predict(vertex);
            }
        });
        Self { origin, inertial, point, inertia }
    }

    /// Lets these vertices take a step of backward Euler, whatever the others take: by BDF2, which continues the motion of two
    /// steps, what is stopped by a surface would go back at half its speed.
    pub fn slow_down(&mut self, vertices: impl Iterator<Item = usize>, gamma: f64, step: &Step) {
        let Self { inertia, inertial, .. } = self;
        inertia.resize(step.start.x.len(), 1.0);
        let factor = gamma * gamma / (step.start.dt * step.start.dt);
        for vertex in vertices.filter(|&vertex| !step.start.held[vertex]) {
            inertia[vertex] = factor;
            inertial[vertex] = step.start.x[vertex] + step.start.dt * step.start.v[vertex];
        }
    }

    /// Lets what touches take a step of backward Euler, and linearizes it where contact will have it.
    pub fn start_touching(&mut self, contact: &ContactLayer, gamma: f64, step: &Step) {
        self.slow_down(contact.touched(), gamma, step);
        let Self { inertial, point, .. } = self;
        for vertex in contact.touched().filter(|&vertex| !step.start.held[vertex]) {
            point[vertex] = inertial[vertex];
        }
        contact.project(point, step.start.held);
    }

    /// Whether a vertex takes a step of backward Euler.
    pub fn is_slowed(&self, vertex: usize) -> bool {
        self.inertia.get(vertex).is_some_and(|&factor| factor != 1.0)
    }

    /// The state that the moves of `end` lead to, written over `out`. A `free` cloth is neither pinned nor touches anything.
    pub fn finish(&self, out: &mut State, scheme: Scheme, end: &Iterate, free: bool, step: &Step, parts: &[Part]) {
        let dt = step.start.dt;
        let lead = |vertex: usize| {
            let (x, v) = (step.start.x[vertex], step.start.v[vertex]);
            if let Some(waypoint) = step.pins.waypoint(vertex) {
                // A pin is reached to the last bit, whatever the precision of the solve.
                return (waypoint, (waypoint - x) / dt);
            }
            let reached = end.at(vertex);
            // Not `reached - x`, in which the digits of a small move are lost.
            let euler = (reached, (end.point[vertex] - x + end.moves[vertex]) / dt);
            if self.is_slowed(vertex) {
                return euler;
            }
            match scheme {
                Scheme::BackwardEuler | Scheme::Change => euler,
                Scheme::Midpoint => (2.0 * reached - x, 4.0 / dt * (reached - x) - v),
                Scheme::Bdf2(bdf2) => (reached, (reached - self.origin[vertex]) / bdf2.gamma),
            }
        };
        let rows = (&mut out.positions[..], &mut out.velocities[..]);
        for_parts(parts, rows, &|part: &Part, (positions, velocities)| {
            for (i, vertex) in part.rows.clone().enumerate() {
                (positions[i], velocities[i]) = lead(vertex);
            }
        });
        if matches!(scheme, Scheme::Change) && free {
            center_on_trapezoid(out, step, parts);
        }
    }
}

/// Moves a state so that its center of mass went at the mean of the velocities before and after. Only for cloth without pins: no
/// stiffness has a part in that.
fn center_on_trapezoid(State { positions, velocities }: &mut State, step: &Step, parts: &[Part]) {
    let velocities = &velocities[..];
    let change = for_parts(parts, (), &|part: &Part, ()| {
        let rows = part.rows.clone();
        rows.map(|vertex| step.start.masses[vertex] * (velocities[vertex] - step.start.v[vertex])).sum::<DVec3>()
    });
    let ahead = 0.5 * step.start.dt / step.start.mass * change;
    for_parts(parts, &mut positions[..], &|_: &Part, positions| {
        for x in positions {
            *x -= ahead;
        }
    });
}
