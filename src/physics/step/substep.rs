//! What a substep is given.

use bevy::math::DVec3;

use super::pins::Pins;
use super::state::State;
use crate::physics::contact::{Collider, ContactSettings, Surroundings};
use crate::physics::terms::Substep;

/// A substep of a cloth with its pins and colliders: nothing of it changes while the substep is taken.
#[derive(Clone, Copy)]
pub(in crate::physics) struct Step<'a> {
    /// What terms see of it.
    pub start: Substep<'a>,
    pub pins: &'a Pins,
    pub around: Surroundings<'a>,
}

/// What all substeps of a step have in common.
#[derive(Clone, Copy)]
pub(in crate::physics) struct World<'a> {
    /// By vertex, kg.
    pub masses: &'a [f64],
    /// Of all together, kg.
    pub mass: f64,
    /// m/s².
    pub gravity: DVec3,
    /// m/s.
    pub wind: DVec3,
    pub colliders: &'a [Collider],
    pub contact: ContactSettings,
}

impl World<'_> {
    /// The substep of `dt` seconds that begins and ends at these shares of the step, from a state and with the waypoints of pins set.
    pub fn substep<'a>(
        &'a self,
        [from, to]: [f64; 2],
        dt: f64,
        is_impact: bool,
        state: &'a State,
        pins: &'a Pins,
    ) -> Step<'a> {
        let Self { masses, mass, gravity, wind, colliders, contact: settings } = *self;
        let (x, v, held) = (&state.positions[..], &state.velocities[..], pins.held());
        let frame = pins.mean_velocity(x, dt).unwrap_or_else(|| mean_velocity(masses, mass, v));
        Step {
            start: Substep { x, v, held, masses, mass, gravity, wind, frame, dt, from, to },
            pins,
            around: Surroundings { colliders, settings, is_impact, from, to },
        }
    }
}

/// Momentum over mass, m/s.
pub(super) fn mean_velocity(masses: &[f64], mass: f64, velocities: &[DVec3]) -> DVec3 {
    masses.iter().zip(velocities).map(|(&mass, &v)| mass * v).sum::<DVec3>() / mass
}
