//! Cloth in motion.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, SolverSettings};

use super::Row;
use super::strip::{Strip, mean, pin, place, run, vertices};
use crate::scenes::DT;

/// Small swings of a hanging strip: f₁ = j₀₁/(4π) √(g/L), j₀₁ = 2.404826.
pub fn swing() -> Vec<Row> {
    let length = 1.0;
    let expected = 2.404_826 / (4.0 * core::f64::consts::PI) * (9.81_f64 / length).sqrt();
    let strip = Strip { length, width: 0.1, along: 30, across: 3 };
    let fabric = Fabric::isotropic(0.15, 2000.0, 0.0, 1e-8).undamped();
    let mut cloth = strip.cloth(fabric, SolverSettings::default());
    // Its first mode, J₀(j₀₁ √(s/L)) at the distance s from the free end.
    place(&mut cloth, |x| {
        let s = length - x.x;
        DVec3::new(x.z, -x.x, 0.01 * bessel_j0(2.404_826 * (s / length).sqrt()))
    });
    pin(&mut cloth, |x| x.x == 0.0);
    let tip = vertices(&cloth, |x| x.x == length);
    let dt = DT / 4.0;
    let (mut before, mut crossings) = (mean(&cloth, &tip).z, Vec::new());
    for step in 1..=(6.0 / dt) as u32 {
        cloth.step(dt);
        let z = mean(&cloth, &tip).z;
        if before > 0.0 && z <= 0.0 {
            crossings.push((f64::from(step) - z / (z - before)) * dt);
        }
        before = z;
    }
    let measured = match crossings[..] {
        [first, .., last] => (crossings.len() - 1) as f64 / (last - first),
        _ => f64::NAN,
    };
    vec![Row::new("swing/Hz", format!("L {length} m, 240 Hz"), expected, measured, 1e-2)]
}

/// `J₀(x) = Σ (−x²/4)ⁿ/n!²`.
fn bessel_j0(x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for n in 1..20 {
        term *= -x * x / 4.0 / f64::from(n * n);
        sum += term;
    }
    sum
}

/// Angular momentum left after a second of free spin without air, of what there was.
pub fn spin() -> Vec<Row> {
    let strip = Strip { length: 1.0, width: 1.0, along: 24, across: 24 };
    let mut cloth = strip.cloth(Fabric { air_drag: 0.0, ..Fabric::denim() }, SolverSettings::default());
    cloth.set_gravity(DVec3::ZERO);
    let centre = DVec3::new(0.5, 0.0, 0.5);
    let positions = cloth.positions().to_vec();
    let velocities: Vec<_> = positions.iter().map(|&x| core::f64::consts::TAU * DVec3::Y.cross(x - centre)).collect();
    cloth.set_state(&positions, &velocities);
    let before = angular_momentum(&cloth, centre);
    run(&mut cloth, DT, 1.0);
    let kept = angular_momentum(&cloth, centre).dot(before) / before.length_squared();
    vec![Row::new("spin: momentum kept", "denim, 1 Hz, 60 Hz, 1 s".into(), 1.0, kept, 1e-2)]
}

fn angular_momentum(cloth: &Cloth, centre: DVec3) -> DVec3 {
    let vertices = cloth.positions().iter().zip(cloth.velocities()).zip(cloth.masses());
    vertices.map(|((&x, &v), &m)| m * (x - centre).cross(v)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bessel_function_has_its_zero() {
        assert!(bessel_j0(2.404_826).abs() < 1e-6 && bessel_j0(0.0) == 1.0);
    }
}
