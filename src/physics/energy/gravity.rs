//! Gravity, `E = −Σ mᵢ g·xᵢ`: a constant force, so its Hessian is zero.

use bevy::math::DVec3;

/// Potential energy of the masses (kg) at these positions (m), J; zero at the origin.
pub fn energy(gravity: DVec3, masses: &[f64], positions: &[DVec3]) -> f64 {
    -masses.iter().zip(positions).map(|(&m, &x)| m * gravity.dot(x)).sum::<f64>()
}

/// Force on a mass (kg), N.
pub fn force(gravity: DVec3, mass: f64) -> DVec3 {
    mass * gravity
}
