//! One implicit step, as the elements and the linear system see it.

use bevy::math::DVec3;

use super::ContactTerm;
use crate::physics::math::{Padded, Scalar};

/// How the stress is made safe in the geometric part of the Hessian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Eigenvalues below zero become zero: a Newton step on a convex model.
    PositivePart,
    /// Eigenvalues below zero change their sign: as stiff in compression as in tension, without which one-solve BDF2 does
    /// not come to rest.
    Absolute,
}

/// One implicit step as a linear system for the move `d` from the points `x` where the forces are linearised.
///
/// The new state is `x' = q + γ v'` with the position q and the velocity `u = (y − q)/γ` that earlier states carry into the
/// step (backward Euler: `q = xₙ`, `y = xₙ + Δt vₙ`, γ = Δt). With damping matrix D (material part of H) and drag α:
///
/// ```text
/// A = M (1 + γ α) + γ² H(x) + γ dp D(x)                                 d = x' − x
/// b = M (y − x) + γ² (f(x) + M g) − γ (dp D(x) + α M) (x − q)
/// ```
///
/// A uniform translation t meets no stiffness, `A t = M (1 + γ α) t`, but in f32 the rows of A do not quite sum to that: so
/// a drift t common to all vertices is taken out, and what is solved for is `d − t`.
///
/// For backward Euler linearised at xₙ this is Baraff & Witkin's step `[M − Δt(Δt+dp) K] Δv = Δt [f + (Δt+dp) K v]` written
/// for `d = Δt (v + Δv)`, with the same projected K on both sides.
#[derive(Clone, Copy, Debug)]
pub struct ImplicitStep<'a> {
    /// Where the forces are linearised, m.
    pub x: &'a [DVec3],
    /// y: where inertia alone would lead, m.
    pub inertial: &'a [DVec3],
    /// q: where the step comes from, m.
    pub origin: &'a [DVec3],
    /// γ, s.
    pub gamma: f64,
    /// Gravity, m/s².
    pub gravity: DVec3,
    /// Material damping dp, s.
    pub damping: f64,
    /// Drag of the air α, 1/s.
    pub air_drag: f64,
    /// How the stress is made safe.
    pub projection: Projection,
    /// Translation t that the solution is relative to, m.
    pub drift: DVec3,
    /// By vertex, if not 1 for all: factor of M in A and b. With (γ/Δt)² and y = xₙ + Δt vₙ a vertex takes a step of backward Euler
    /// while the others take one of another scheme.
    pub inertia: Option<&'a [f64]>,
    /// Forces of contact, linearised at x.
    pub contacts: &'a [ContactTerm],
}

impl<'a> ImplicitStep<'a> {
    /// Backward Euler without damping or drag, from x: `inertial` is `x + Δt v`.
    pub fn backward_euler(x: &'a [DVec3], inertial: &'a [DVec3], dt: f64, gravity: DVec3) -> Self {
        Self {
            x,
            inertial,
            origin: x,
            gamma: dt,
            gravity,
            damping: 0.0,
            air_drag: 0.0,
            projection: Projection::PositivePart,
            drift: DVec3::ZERO,
            inertia: None,
            contacts: &[],
        }
    }

    /// Mean of the move, which the elastic forces have no part in, for a cloth that nothing holds, m.
    pub fn free_drift(&self, masses: &[f64]) -> DVec3 {
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (vertex, &mass) in masses.iter().enumerate() {
            let x = self.x[vertex];
            sum += mass * (self.inertial[vertex] - x - self.gamma * self.air_drag * (x - self.origin[vertex]));
            total += mass;
        }
        sum / (total * (1.0 + self.gamma * self.air_drag)) + self.free_fall()
    }

    /// The part of gravity in the move of a cloth that nothing holds, m.
    pub fn free_fall(&self) -> DVec3 {
        self.gamma * self.gamma / (1.0 + self.gamma * self.air_drag) * self.gravity
    }

    /// The move of a vertex that inertia and drag alone would give, m: zero at rest.
    pub fn inertial_move(&self, vertex: usize) -> DVec3 {
        (self.inertial[vertex] - self.x[vertex]) / (1.0 + self.gamma * self.air_drag)
    }
}

/// What the elements need to know of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linearisation<'a, T: Scalar> {
    /// Where the forces are linearised, m.
    pub x: &'a [Padded<f64>],
    /// x − q up to a common translation, m: `(x − q)/γ` is the velocity that damping acts on.
    pub moved: &'a [Padded<T>],
    /// Factor of the material part of the Hessian in A, γ (γ + dp).
    pub material: f64,
    /// Factor of the geometric part, γ².
    pub geometric: f64,
    /// How the stress is made safe.
    pub projection: Projection,
    /// dp/γ: damping adds this times the Hessian's material part times `x − q` to the force.
    pub rate: f64,
}

impl<'a, T: Scalar> Linearisation<'a, T> {
    pub fn new(step: &ImplicitStep, x: &'a [Padded<f64>], moved: &'a [Padded<T>]) -> Self {
        Self {
            x,
            moved,
            material: step.gamma * (step.gamma + step.damping),
            geometric: step.gamma * step.gamma,
            projection: step.projection,
            rate: step.damping / step.gamma,
        }
    }
}
