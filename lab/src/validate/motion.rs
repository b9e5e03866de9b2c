//! Cloth in motion.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, Precision, SolverSettings};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use super::Row;
use super::bending::clamp;
use super::strip::{Strip, exact, pin, place, run};
use crate::scenes::{DT, Meshing, Sheet, fabric};

/// Zeros of J₀, and the step as a share of the period.
const SWINGS: [f64; 3] = [2.404_826, 5.520_078, 8.653_728];
const STEPS_PER_PERIOD: f64 = 250.0;

/// Small swings of a hanging strip: f_n = j₀ₙ/(4π) √(g/L).
pub fn swing() -> Vec<Row> {
    SWINGS
        .into_iter()
        .zip(1..)
        .map(|(zero, mode)| {
            let expected = zero / (4.0 * core::f64::consts::PI) * 9.81_f64.sqrt();
            let strip = Strip::new(1.0, 0.1, 60, 6);
            let fabric = Fabric::isotropic(0.15, 2000.0, 0.0, 1e-8).undamped();
            let mut cloth = strip.cloth(fabric, exact());
            // J₀(j₀ₙ √(s/L)) at the distance s from the free end.
            let shape = move |x: DVec3| bessel_j0(zero * (1.0 - x.x).max(0.0).sqrt());
            place(&mut cloth, |x| DVec3::new(x.z, -x.x, 0.002 * shape(x)));
            pin(&mut cloth, |x| x.x == 0.0);
            // Modes are orthogonal in the mass.
            let of_mode = |cloth: &Cloth| weighted(cloth, |rest, x| shape(rest) * x.z);
            let measured = frequency(&mut cloth, 1.0 / (STEPS_PER_PERIOD * expected), 4.0 / expected, of_mode);
            Row::new("swing/Hz", format!("1 m, mode {mode}"), expected, measured, 1e-2)
        })
        .collect()
}

/// `J₀(x) = Σ (−x²/4)ⁿ/n!²`.
fn bessel_j0(x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for n in 1..40 {
        term *= -x * x / 4.0 / f64::from(n * n);
        sum += term;
    }
    sum
}

/// Sum over the vertices, by mass.
fn weighted(cloth: &Cloth, value: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let vertices = cloth.shape().positions.iter().zip(cloth.positions()).zip(cloth.masses());
    vertices.map(|((&rest, &x), &mass)| mass * value(rest, x)).sum()
}

/// How often a coordinate passes zero downwards, Hz.
pub fn frequency(cloth: &mut Cloth, dt: f64, seconds: f64, coordinate: impl Fn(&Cloth) -> f64) -> f64 {
    let (mut before, mut crossings) = (coordinate(cloth), Vec::new());
    for step in 1..=(seconds / dt).round() as u32 {
        cloth.step(dt);
        let now = coordinate(cloth);
        if before > 0.0 && now <= 0.0 {
            crossings.push((f64::from(step) - now / (now - before)) * dt);
        }
        before = now;
    }
    match crossings[..] {
        [first, .., last] => (crossings.len() - 1) as f64 / (last - first),
        _ => f64::NAN,
    }
}

/// Cells along a vibrating cantilever of 1 m, and its flexural rigidity, N·m.
const CELLS: u32 = 30;
const RIGIDITY: f64 = 1.0;

/// ω₁ = 3.516 √(D/(ρ L⁴)), in Hz.
pub fn cantilever_frequency() -> f64 {
    3.516 * (RIGIDITY / 0.15_f64).sqrt() / core::f64::consts::TAU
}

pub fn vibration() -> Vec<Row> {
    let expected = cantilever_frequency();
    let mut cloth = cantilever(0.0);
    let dt = 1.0 / (STEPS_PER_PERIOD * expected);
    let measured = frequency(&mut cloth, dt, 4.0 / expected, |cloth| weighted(cloth, |rest, x| first_mode(rest) * x.y));
    vec![Row::new("cantilever/Hz", "mode 1", expected, measured, 1e-2)]
}

/// Rate at which the vibration dies, 1/s.
pub fn cantilever_decay(damping: f64) -> f64 {
    let frequency = cantilever_frequency();
    let mut cloth = cantilever(damping);
    let amplitude = |cloth: &Cloth| {
        let place = weighted(cloth, |rest, x| first_mode(rest) * x.y);
        let velocities = cloth.shape().positions.iter().zip(cloth.velocities()).zip(cloth.masses());
        let speed: f64 = velocities.map(|((&rest, v), m)| m * first_mode(rest) * v.y).sum();
        place.hypot(speed / (core::f64::consts::TAU * frequency))
    };
    let (dt, seconds) = (1.0 / (STEPS_PER_PERIOD * frequency), 1.0 / frequency);
    run(&mut cloth, dt, seconds);
    let before = amplitude(&cloth);
    run(&mut cloth, dt, seconds);
    (before / amplitude(&cloth)).ln() / seconds
}

fn cantilever(damping: f64) -> Cloth {
    let cell = 1.0 / f64::from(CELLS);
    let fabric = Fabric::isotropic(0.15, 2e4, 0.0, RIGIDITY as f32).undamped();
    let strip = Strip::new(1.0 + cell, 4.0 * cell, CELLS + 1, 4);
    let mut cloth = strip.cloth(Fabric { damping: damping as f32, ..fabric }, exact());
    cloth.set_gravity(DVec3::ZERO);
    place(&mut cloth, |x| x + DVec3::Y * 1e-3 * first_mode(x));
    clamp(&mut cloth, cell);
    cloth
}

/// Of a cantilever that begins after the clamped cell.
fn first_mode(x: DVec3) -> f64 {
    const ROOT: f64 = 1.875_104;
    const RATIO: f64 = 0.734_096;
    let s = ROOT * (x.x - 1.0 / f64::from(CELLS)).max(0.0);
    s.cosh() - s.cos() - RATIO * (s.sinh() - s.sin())
}

/// Angular momentum left after a second of free spin without air, of what there was.
pub fn spin() -> Vec<Row> {
    let mut cloth = Strip::new(1.0, 1.0, 24, 24).cloth(free(), SolverSettings::default());
    cloth.set_gravity(DVec3::ZERO);
    let centre = DVec3::new(0.5, 0.0, 0.5);
    let positions = cloth.positions().to_vec();
    let velocities: Vec<_> = positions.iter().map(|&x| core::f64::consts::TAU * DVec3::Y.cross(x - centre)).collect();
    cloth.set_state(&positions, &velocities);
    let before = angular_momentum(&cloth, centre);
    run(&mut cloth, DT, 1.0);
    let kept = angular_momentum(&cloth, centre).dot(before) / before.length_squared();
    vec![Row::new("spin: momentum kept", "denim, 1 Hz, 60 Hz, 1 s", 1.0, kept, 1e-2)]
}

/// Denim without air.
fn free() -> Fabric {
    Fabric { air_drag: 0.0, ..Fabric::denim() }
}

fn angular_momentum(cloth: &Cloth, centre: DVec3) -> DVec3 {
    let vertices = cloth.positions().iter().zip(cloth.velocities()).zip(cloth.masses());
    vertices.map(|((&x, &v), &m)| m * (x - centre).cross(v)).sum()
}

/// Change of the momentum of a sheet that tumbles freely for a second, whatever it does inside, of what there was.
pub fn momentum() -> Vec<Row> {
    let default = SolverSettings::default();
    [("f32", default, 1e-5), ("f64", SolverSettings { precision: Precision::Double, ..default }, 1e-12)]
        .into_iter()
        .map(|(precision, settings, tolerance)| {
            let mut cloth = Strip::new(1.0, 1.0, 24, 24).cloth(free(), settings);
            cloth.set_gravity(DVec3::ZERO);
            let mut random = StdRng::seed_from_u64(3);
            let positions = cloth.positions().to_vec();
            let mut speed = || random.random_range(-0.5..0.5);
            let velocities: Vec<_> = positions.iter().map(|_| DVec3::new(1.0 + speed(), speed(), speed())).collect();
            cloth.set_state(&positions, &velocities);
            let before = linear_momentum(&cloth);
            run(&mut cloth, DT, 1.0);
            let change = linear_momentum(&cloth).distance(before) / before.length();
            let parameters = format!("denim, 60 Hz, 1 s, {precision}");
            Row::absolute("momentum: change", parameters, 0.0, change, tolerance)
        })
        .collect()
}

fn linear_momentum(cloth: &Cloth) -> DVec3 {
    cloth.velocities().iter().zip(cloth.masses()).map(|(&v, &m)| m * v).sum()
}

/// The most energy a sheet without damping ever has more than at the beginning, of what falling by its length would give.
pub fn energy() -> Vec<Row> {
    let solves = [("default", SolverSettings::default(), 1e-2), ("exact", exact(), 1e-5)];
    let rates = [30.0, 60.0, 240.0];
    rates
        .into_iter()
        .flat_map(|rate| solves.map(|solve| (rate, solve)))
        .map(|(rate, (solve, settings, tolerance))| {
            // One Newton step of such a length is not exact.
            let tolerance = if rate < 60.0 { 1e-2 } else { tolerance };
            let sheet = Sheet::new(20, Meshing::Grid);
            let mut cloth = sheet.hang(settings);
            cloth.set_fabric(fabric().undamped()).expect("the fabric is valid");
            let before = cloth.energy().total();
            let scale = cloth.masses().iter().sum::<f64>() * 9.81;
            let mut most = 0.0_f64;
            for _ in 0..(5.0 * rate) as u32 {
                cloth.step(1.0 / rate);
                most = most.max(cloth.energy().total() - before);
            }
            let parameters = format!("hung sheet, {rate} Hz, 5 s, {solve} solves");
            Row::absolute("energy gained/(M g L)", parameters, 0.0, most / scale, tolerance)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_have_their_zeros() {
        assert!(SWINGS.iter().all(|&zero| bessel_j0(zero).abs() < 1e-5) && bessel_j0(0.0) == 1.0);
        let slope = |x: f64| (first_mode(DVec3::X * (x + 1e-4)) - first_mode(DVec3::X * x)) / 1e-4;
        let clamp = 1.0 / f64::from(CELLS);
        assert!(first_mode(DVec3::X * clamp) == 0.0 && slope(clamp).abs() < 1e-2 && slope(clamp + 1.0) > 2.0);
    }
}
