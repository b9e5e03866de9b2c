//! How fast motion dies: what the integrators take away by themselves, and what the material does.

use bevy_cloth::physics::{Integrator, SolverSettings};

use super::Row;
use super::motion::{cantilever_decay, cantilever_frequency};
use super::string::Strung;
use super::strip::{exact, run};

/// Rates of decay of the first mode of a string, in e-foldings a second, which nothing but the integrator damps; and of a
/// cantilever, whose material does: ½ dp ω².
pub fn damping() -> Vec<Row> {
    let mut rows = Vec::new();
    for (integrator, name) in [(Integrator::BackwardEuler, "BE"), (Integrator::Bdf2, "BDF2")] {
        for (frequency, rate) in [(1.0, 60.0), (2.0, 60.0), (5.0, 60.0), (2.0, 240.0), (5.0, 240.0)] {
            let dt = 1.0 / rate;
            let angle = core::f64::consts::TAU * frequency * dt;
            let kept = match integrator {
                Integrator::BackwardEuler => 1.0 / (1.0 + angle * angle).sqrt(),
                Integrator::Bdf2 => bdf2(angle),
            };
            let parameters = format!("{name}, {frequency} Hz at {rate} Hz");
            let measured = string_decay(integrator, frequency, dt);
            rows.push(Row::new("numerical damping/(1/s)", parameters, -kept.ln() / dt, measured, 5e-2));
        }
    }
    for damping in [0.002, 0.01] {
        let omega = core::f64::consts::TAU * cantilever_frequency();
        let expected = 0.5 * damping * omega * omega;
        let measured = cantilever_decay(damping);
        rows.push(Row::new("material damping/(1/s)", format!("cantilever, dp {damping} s"), expected, measured, 5e-2));
    }
    rows
}

/// Magnitude of the principal root ζ of BDF2 for an undamped mode of ω Δt = `angle`: 3/2 − 2/ζ + 1/(2 ζ²) = i ω Δt.
fn bdf2(angle: f64) -> f64 {
    // 1/ζ = 2 − √(1 + 2 i ω Δt).
    let modulus = (1.0 + 4.0 * angle * angle).sqrt().sqrt();
    let argument = 0.5 * (2.0 * angle).atan2(1.0);
    1.0 / (2.0 - modulus * argument.cos()).hypot(modulus * argument.sin())
}

fn string_decay(integrator: Integrator, frequency: f64, dt: f64) -> f64 {
    let string = Strung::of_frequency(frequency);
    let mut cloth = string.cloth(1, SolverSettings { integrator, ..exact() });
    let seconds = (1.0 / frequency).max(0.5);
    run(&mut cloth, dt, seconds);
    let before = string.amplitude(&cloth, 1);
    run(&mut cloth, dt, seconds);
    (before / string.amplitude(&cloth, 1)).ln() / seconds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bdf2_damps_with_the_fourth_power_of_the_step() {
        // |ζ| = 1 − (ω Δt)⁴/4 + …
        let loss = |angle: f64| 1.0 - bdf2(angle);
        assert!((loss(0.1) / (0.25 * 1e-4) - 1.0).abs() < 0.05, "{}", loss(0.1));
        assert!((loss(0.1) / loss(0.05) - 16.0).abs() < 1.0);
    }
}
