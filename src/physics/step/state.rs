//! States of a cloth.

use bevy::math::DVec3;

/// Positions and velocities of the simulated vertices, in world space.
#[derive(Clone, Debug)]
pub(in crate::physics) struct State {
    /// m.
    pub positions: Vec<DVec3>,
    /// m/s.
    pub velocities: Vec<DVec3>,
}

impl State {
    /// At the origin, at rest.
    pub fn zero(vertices: usize) -> Self {
        Self { positions: vec![DVec3::ZERO; vertices], velocities: vec![DVec3::ZERO; vertices] }
    }
}

/// The state before the present one.
pub(in crate::physics) struct History {
    pub state: State,
    /// Length of the step between them, s; `None` if there was none.
    pub dt: Option<f64>,
    /// Whether it was far from the length of the step before it.
    pub changed: bool,
}
