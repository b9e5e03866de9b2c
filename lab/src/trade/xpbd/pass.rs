//! One sweep over all elements.

use super::{Damping, Settings};

/// How the elements are to be solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass {
    /// Δt², s².
    pub dt2: f64,
    /// What the constraint's value counts: 1, or 0 where only its rate does.
    pub value: f64,
    /// What its change in this substep counts, γ; 0 if it is not to be looked at.
    pub rate: f64,
    /// Factor of the compliance.
    pub compliance: f64,
    /// Factor of ∇C M⁻¹ ∇Cᵀ: 1 + γ, or 1 where only the rate counts, and less if over-relaxed.
    pub mobility: f64,
}

impl Pass {
    /// The pass over the positions and, if there is one, that over the velocities.
    pub fn of(settings: &Settings, dt: f64, dp: f64) -> (Self, Option<Self>) {
        let gamma = if settings.damping == Damping::Constraints { dp / dt } else { 0.0 };
        let mobility = (1.0 + gamma) / settings.relaxation;
        let positions = Self { dt2: dt * dt, value: 1.0, rate: gamma, compliance: 1.0, mobility };
        // The stress dp C ε̇ of the rate at the end of the substep: compliance dt/dp for the strain of a substep.
        let velocities = (settings.damping == Damping::Velocities && dp > 0.0).then(|| Self {
            value: 0.0,
            rate: 1.0,
            compliance: dt / dp,
            mobility: 1.0,
            ..positions
        });
        (positions, velocities)
    }

    /// For so many substeps at once: an impulse that is to last.
    pub fn lasting(self, substeps: u32) -> Self {
        Self { dt2: self.dt2 * f64::from(substeps), ..self }
    }
}
