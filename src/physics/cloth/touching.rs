//! What contact changes about a step.
//!
//! Vertices that touch take a step of backward Euler, whatever the others take: by BDF2, which continues the motion of two
//! steps, what is stopped by a surface would go back at half its speed.

use bevy::platform::time::Instant;

use super::engine::Step;
use super::implicit::{Guess, Implicit};
use super::scheme::Linear;
use super::{ClothFault, State, StepReport};
use crate::physics::assembly::Ordering;
use crate::physics::contact::{ContactLayer, Moving};
use crate::physics::material::Fabric;
use crate::physics::math::Scalar;
use crate::physics::mesh::RestShape;

/// Share of the forces of contact that may be wrong after a solve: the few touches that were will be right in the next step.
const WRONG: f64 = 0.1;
/// Solves beyond the first, at most, in which touches are let go, found or begin to slip.
const CONTACT_STEPS: u32 = 2;
/// Above this share there may be more: an impact that is left half solved drags the cloth along as if it were glued.
const MOSTLY_WRONG: f64 = 0.5;
const MOST_CONTACT_STEPS: u32 = 8;

/// How much further a collider may push a vertex in a substep than one beside it, in sides of triangles: what is pushed on alone is
/// torn about.
const LEAP: f64 = 0.7;
/// Substeps, at most, that an impact is taken in.
const MOST_PIECES: u32 = 16;
/// After so many substeps there are half as many at least: what was hit is still fast.
const MANY_PIECES: u32 = 8;
/// Where so many vertices had to be rescued in a step, it was too long: the next is taken in twice as many substeps, up to a few, as what
/// is crushed for long is rescued for long.
const MANY_RESCUES: u32 = 5;
const RESCUE_PIECES: u32 = 4;

/// How the last step went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Impact {
    /// Substeps that it was taken in.
    pieces: u32,
    /// Vertices that were rescued in it.
    rescues: u32,
}

impl Impact {
    pub const NONE: Self = Self { pieces: 1, rescues: 0 };

    /// Substeps of the next step at least.
    fn pieces_after(self) -> u32 {
        let calming = if self.pieces >= MANY_PIECES { self.pieces / 2 } else { 1 };
        let shorter = if self.rescues >= MANY_RESCUES { RESCUE_PIECES.min(2 * self.pieces) } else { 1 };
        calming.max(shorter)
    }
}

fn moving<'a>(step: &Step<'a>, state: &'a State) -> Moving<'a> {
    Moving {
        x: &state.positions,
        v: &state.velocities,
        held: step.pins.held(),
        masses: step.masses,
        gravity: step.gravity,
        dt: step.dt,
    }
}

/// The layer of a cloth whose vertices are numbered as `ordering` says.
pub(super) fn contact_layer(shape: &RestShape, fabric: &Fabric, ordering: &Ordering) -> ContactLayer {
    let triangles = shape.triangles.iter().map(|triangle| triangle.vertices.map(|v| ordering.inner[v as usize]));
    ContactLayer::new(fabric, triangles.collect(), longest_side(shape))
}

/// Length of the longest side of a triangle at rest, m.
pub(super) fn longest_side(shape: &RestShape) -> f64 {
    let squares = shape.edges.iter().map(|[a, b]| {
        let [a, b] = [a, b].map(|&vertex| shape.positions[vertex as usize]);
        a.distance_squared(b)
    });
    squares.fold(0.0, f64::max).sqrt()
}

impl<T: Scalar> Implicit<T> {
    /// Finds the touches of the step, and says whether there are any.
    pub fn find_contact(&mut self, step: Step, state: &State, report: &mut StepReport) -> bool {
        self.inertia.clear();
        if step.around.colliders.is_empty() {
            self.contact.forget();
            return false;
        }
        let start = Instant::now();
        self.contact.detect(&step.around, &moving(&step, state));
        report.contact += start.elapsed();
        !self.contact.is_empty()
    }

    /// Substeps in which nothing is pushed too far at once.
    pub fn impact_pieces(&mut self, step: Step, state: &State) -> u32 {
        let leap = LEAP * self.contact.longest_side();
        let shear = self.contact.shear(&step.around, &moving(&step, state), leap);
        let pieces = (shear / leap).ceil() as u32;
        let pieces = pieces.max(self.impact.pieces_after()).clamp(1, MOST_PIECES);
        self.impact = Impact { pieces, rescues: 0 };
        pieces
    }

    /// Lets what touches take a step of backward Euler.
    pub fn slow_down_touching(&mut self, gamma: f64, step: Step, state: &State) {
        let Self { contact, inertia, inertial, .. } = self;
        inertia.resize(state.positions.len(), 1.0);
        let factor = gamma * gamma / (step.dt * step.dt);
        for vertex in contact.touched().filter(|&vertex| !step.pins.held()[vertex]) {
            inertia[vertex] = factor;
            inertial[vertex] = state.positions[vertex] + step.dt * state.velocities[vertex];
        }
    }

    /// Linearises what touches where contact will have it.
    pub fn start_at_planes(&mut self, held: &[bool]) {
        let Self { contact, inertial, point, .. } = self;
        for vertex in contact.touched().filter(|&vertex| !held[vertex]) {
            point[vertex] = inertial[vertex];
        }
        contact.project(point, held);
    }

    /// Finds what the last solve leads into; says whether there was anything.
    pub fn find_late_contact(&mut self, step: Step, state: &State) -> bool {
        let Self { contact, point, moves, .. } = self;
        !step.around.colliders.is_empty()
            && contact.find_late(&step.around, &moving(&step, state), |vertex| point[vertex] + moves[vertex])
    }

    /// Judges contact by the last solve, and solves again where it was wrong, or where there are to be more Newton steps.
    pub fn follow_contact(
        &mut self,
        linear: Linear,
        newton_steps: u32,
        step: Step,
        state: &State,
        report: &mut StepReport,
    ) -> Result<(), ClothFault> {
        let mut linearised = 1;
        for solves in 0.. {
            let Self { contact, point, moves, .. } = self;
            let end = |vertex: usize| point[vertex] + moves[vertex];
            let wrong = contact.judge(end);
            let most = if wrong > MOSTLY_WRONG { MOST_CONTACT_STEPS } else { CONTACT_STEPS };
            let mut again = wrong > WRONG;
            again |= contact.find_late(&step.around, &moving(&step, state), end);
            again &= solves < most;
            if !again && linearised >= newton_steps {
                break;
            }
            report.contact_solves += u32::from(again);
            self.slow_down_touching(linear.gamma, step, state);
            self.move_point();
            let before = report.iterations;
            self.solve(linear, Guess::Point, step, state, report)?;
            let solved = self.settings.kind.is_iterative() && report.iterations == before;
            linearised = if solved { newton_steps } else { linearised + 1 };
        }
        Ok(())
    }

    /// Moves out what of the candidate ended inside a collider; says how many vertices that were.
    pub fn guard(&mut self, step: Step, state: &State) -> u32 {
        let Self { contact, candidate: State { positions, velocities }, .. } = self;
        let rescues = contact.guard(&step.around, &moving(&step, state), positions, velocities);
        self.impact.rescues += rescues;
        rescues
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_grow_while_vertices_are_rescued_and_fall_off_after_an_impact() {
        let after = |pieces, rescues| Impact { pieces, rescues }.pieces_after();
        assert_eq!([1, 2, 4, 4], [(1, 4), (1, 5), (2, 9), (4, 100)].map(|(pieces, rescues)| after(pieces, rescues)));
        assert_eq!([1, 4, 6, 8], [(7, 0), (8, 0), (13, 9), (16, 0)].map(|(pieces, rescues)| after(pieces, rescues)));
        assert_eq!(Impact::NONE.pieces_after(), 1);
    }
}
