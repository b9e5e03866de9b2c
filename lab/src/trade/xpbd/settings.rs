//! What can be chosen.

/// How the material's damping enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damping {
    /// Not at all: what the substeps lose by themselves is left.
    None,
    /// As the paper has it, in every constraint (2016, eq. 26). What a single iteration lacks in stiffness, ∇C M⁻¹ ∇Cᵀ beside
    /// α̃, then grows by the factor 1 + γ: of first order in the substep, no longer of second.
    Constraints,
    /// In a pass of its own over the velocities, which leaves the constraints as stiff as they are.
    Velocities,
}

/// What can be chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Substeps of a frame.
    pub substeps: u32,
    /// See [`Damping`].
    pub damping: Damping,
    /// ω: 1, or more for over-relaxation. ∇C M⁻¹ ∇Cᵀ, which makes a constraint give way, counts 1/ω; the compliance counts in
    /// full, so that the limit of many substeps stays the same.
    pub relaxation: f64,
    /// Bending is solved in every so many-th substep, for all of them: a divisor of their number.
    pub bending_every: u32,
}

impl Settings {
    /// As the papers have it, undamped.
    pub const fn published(substeps: u32) -> Self {
        Self { substeps, damping: Damping::None, relaxation: 1.0, bending_every: 1 }
    }

    /// As good as we could make it for the scenes here: over-relaxed, and bending, which is soft, solved rarely.
    pub const fn tuned(substeps: u32) -> Self {
        Self { relaxation: 1.5, bending_every: 5, ..Self::published(substeps) }
    }
}
