//! The plan of a step: how many substeps it is taken in, and how each is integrated. No other file decides either.
//!
//! | what | substeps |
//! |---|---|
//! | settings | [`SolverSettings::substeps`] at least |
//! | something pushes a vertex far past its neighbors | as many as bring that below [`LEAP`] sides of triangles each |
//! | the step before was taken in [`MANY_PIECES`] or more | half as many |
//! | in the step before [`MANY_RESCUES`] vertices or more were moved out of colliders | twice as many, up to [`RESCUE_PIECES`] |
//!
//! | what | scheme |
//! |---|---|
//! | settings ask for backward Euler | [`Scheme::BackwardEuler`] |
//! | nothing is known of an earlier step | [`Scheme::Midpoint`], or backward Euler if something touches |
//! | the step is about as long as the one before | [`Scheme::Bdf2`], backward Euler for vertices that touch |
//! | it is much longer or shorter | [`Scheme::Change`], and two Newton steps in it and the next |

use super::integrator::{Bdf2, Integrator};
use super::state::History;
use crate::physics::cloth::SolverSettings;

/// How much further a collider may push a vertex in a substep than one beside it, in sides of triangles: what is pushed on alone is
/// torn about.
pub(super) const LEAP: f64 = 0.7;
/// Substeps, at most, that an impact is taken in.
const MOST_PIECES: u32 = 16;
/// After so many substeps there are half as many at least: what was hit is still fast.
const MANY_PIECES: u32 = 8;
/// Where so many vertices had to be rescued in a step, it was too long: the next is taken in twice as many substeps, up to a few, as what
/// is crushed for long is rescued for long.
const MANY_RESCUES: u32 = 5;
const RESCUE_PIECES: u32 = 4;

/// Newton iterations of a step whose length is far from that of the one before, and of the next, at least: linearized once,
/// they gain energy.
const CHANGE_NEWTON_STEPS: u32 = 2;

/// How the last step went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::physics) struct Impact {
    /// Substeps that it was taken in.
    pieces: u32,
    /// Vertices that were rescued in it.
    pub rescues: u32,
}

impl Impact {
    pub const NONE: Self = Self { pieces: 1, rescues: 0 };

    /// The next step, in which colliders push a vertex so many times [`LEAP`] further than one beside it.
    pub fn next(self, leaps: f64) -> Self {
        Self { pieces: (leaps.ceil() as u32).max(self.pieces_after()).clamp(1, MOST_PIECES), rescues: 0 }
    }

    /// Substeps that the step should be taken in.
    pub fn pieces(self) -> u32 {
        self.pieces
    }

    /// Substeps of the next step at least.
    fn pieces_after(self) -> u32 {
        let calming = if self.pieces >= MANY_PIECES { self.pieces / 2 } else { 1 };
        let shorter = if self.rescues >= MANY_RESCUES { RESCUE_PIECES.min(2 * self.pieces) } else { 1 };
        calming.max(shorter)
    }
}

/// How a substep is integrated.
#[derive(Clone, Copy)]
pub(super) enum Scheme {
    BackwardEuler,
    /// Backward Euler where the length of steps changes: free fall, which it runs ahead of, is put right.
    Change,
    /// Half a step of backward Euler, continued to a whole one: second order from a single state.
    Midpoint,
    Bdf2(Bdf2),
}

/// How a substep is taken.
#[derive(Clone, Copy)]
pub(super) struct Plan {
    pub scheme: Scheme,
    /// Linear solves at most, but for those that contact asks for.
    pub newton_steps: u32,
    /// Whether the length is far from that of the substep before.
    pub changed: bool,
}

impl Plan {
    /// Of a substep of `dt` (s) that follows on `history`; `touching` if something is near.
    pub fn new(settings: &SolverSettings, history: &History, dt: f64, touching: bool) -> Self {
        let bdf2 = history.dt.map(|previous| Bdf2::new(dt, previous));
        let changed = bdf2.is_some_and(|bdf2| bdf2.is_none());
        let scheme = match (settings.integrator, bdf2) {
            (Integrator::BackwardEuler, _) => Scheme::BackwardEuler,
            (Integrator::Bdf2, Some(None)) => Scheme::Change,
            (Integrator::Bdf2, Some(Some(bdf2))) => Scheme::Bdf2(bdf2),
            (Integrator::Bdf2, None) if touching => Scheme::BackwardEuler,
            (Integrator::Bdf2, None) => Scheme::Midpoint,
        };
        let at_least = if changed || history.changed { CHANGE_NEWTON_STEPS } else { 1 };
        Self { scheme, newton_steps: settings.newton_steps.max(at_least), changed }
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
