//! Time integration as one implicit solve: which earlier states enter a step, and where the forces are linearised.

use bevy::math::DVec3;
use bevy::reflect::Reflect;
use bevy::reflect::std_traits::ReflectDefault;

/// How a step advances time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
pub enum Integrator {
    /// Second-order backward differences, one solve per step: keeps swing and spin. The default.
    #[default]
    Bdf2,
    /// First order, linearised where the step starts (Baraff & Witkin 1998): damps motion by itself, the more the longer the
    /// step.
    BackwardEuler,
}

/// Longest step BDF2 takes after one of length 1, well before zero-stability ends at 1 + √2 (Hairer, Nørsett & Wanner 1993,
/// III.5). Beyond, a step of backward Euler takes its place: one of the midpoint rule, as at the start, gains energy when
/// lengths change again and again.
const MAX_STEP_RATIO: f64 = 1.5;

/// Weights of the two last states in a BDF2 step of variable length (Hairer, Nørsett & Wanner 1993, III.5).
///
/// With `w = Δtₙ/Δtₙ₋₁` the new state solves `x = q + γ v`, `v = u + γ a`, where `q = c1 xₙ − c2 xₙ₋₁` and
/// `u = c1 vₙ − c2 vₙ₋₁`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bdf2 {
    pub gamma: f64,
    pub c1: f64,
    pub c2: f64,
}

impl Bdf2 {
    /// For a step `dt` after one of `previous_dt` (s); `None` if their ratio is too far from one.
    pub fn new(dt: f64, previous_dt: f64) -> Option<Self> {
        let w = dt / previous_dt;
        (1.0 / MAX_STEP_RATIO..=MAX_STEP_RATIO).contains(&w).then(|| Self {
            gamma: dt * (1.0 + w) / (1.0 + 2.0 * w),
            c1: (1.0 + w) * (1.0 + w) / (1.0 + 2.0 * w),
            c2: w * w / (1.0 + 2.0 * w),
        })
    }

    /// `c1 a − c2 b`.
    pub fn combine(&self, now: DVec3, before: DVec3) -> DVec3 {
        self.c1 * now - self.c2 * before
    }
}

/// Change of velocity up to which motion is smooth, relative to the sum of the speeds before and after it.
const SMOOTH: f64 = 0.1;

/// How far the point of linearisation of a vertex moves from the predictor towards `xₙ + Δt (vₙ + vₙ₋₁)/2`: 0 in smooth
/// motion, 1 where the velocity reverses from step to step. Linearised at the predictor alone, BDF2 with one solve never
/// comes to rest.
pub(super) fn hesitation(velocity: DVec3, previous: DVec3) -> f64 {
    let change = (velocity - previous).length_squared();
    // Most vertices change little, which takes no roots to see: (|a| + |b|)² ≥ |a|² + |b|².
    if change <= SMOOTH * SMOOTH * (velocity.length_squared() + previous.length_squared()) {
        return 0.0;
    }
    let change = change.sqrt() / (velocity.length() + previous.length());
    (4.0 * (change - SMOOTH)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x' = v, v' = −ω² x from exact starts: the error falls fourfold when the step is halved, for steps of changing length.
    #[test]
    fn bdf2_is_of_second_order_at_variable_steps() {
        let error = |refine: u32| {
            let omega = 2.0_f64;
            let length = |n: u32| 0.01 / f64::from(refine) * if n.is_multiple_of(2) { 1.0 } else { 1.3 };
            let exact = |t: f64| ((omega * t).cos(), -omega * (omega * t).sin());
            let (mut t, mut previous_dt) = (length(0), length(0));
            let (mut before, mut now) = (exact(0.0), exact(t));
            for n in 1..100 * refine {
                let dt = length(n);
                let Bdf2 { gamma, c1, c2 } = Bdf2::new(dt, previous_dt).unwrap();
                let (q, u) = (c1 * now.0 - c2 * before.0, c1 * now.1 - c2 * before.1);
                let x = (q + gamma * u) / (1.0 + gamma * gamma * omega * omega);
                before = now;
                now = (x, (x - q) / gamma);
                t += dt;
                previous_dt = dt;
            }
            (now.0 - exact(t).0).abs()
        };
        let ratio = error(1) / error(2);
        assert!((3.6..4.4).contains(&ratio), "{ratio}");
    }

    #[test]
    fn long_jumps_in_the_step_start_anew() {
        assert_eq!(Bdf2::new(1.6, 1.0), None);
        assert_eq!(Bdf2::new(0.6, 1.0), None);
        assert_eq!(Bdf2::new(1.0, f64::NAN), None);
        let even = Bdf2::new(0.5, 0.5).unwrap();
        assert!((even.gamma - 1.0 / 3.0).abs() < 1e-15 && (even.c1 - even.c2 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn hesitation_tells_reversal_from_motion() {
        assert_eq!(hesitation(DVec3::X, DVec3::X), 0.0);
        assert_eq!(hesitation(DVec3::X, -DVec3::X), 1.0);
        assert_eq!(hesitation(DVec3::ZERO, DVec3::ZERO), 0.0);
        // |Δv| / (|v| + |v'|) = 1/5, whichever way.
        let (a, b) = (DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.5, 0.0, 0.0));
        assert!((hesitation(a, b) - 0.4).abs() < 1e-14 && hesitation(a, b) == hesitation(b, a));
        assert_eq!(hesitation(a, 1.2 * a), 0.0);
    }
}
