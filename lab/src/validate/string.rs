//! A strip stretched between two ends vibrates as a string: f_n = n/(2 L) √(T/μ).

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, SolverSettings};

use super::Row;
use super::motion::frequency;
use super::strip::{Strip, exact, pin, place};

/// A strip under tension.
#[derive(Clone, Copy, Debug)]
pub struct Strung {
    /// Stretched length over rest length.
    stretch: f64,
    /// N/m.
    stiffness: f64,
}

/// kg/m², at rest.
const DENSITY: f64 = 0.15;
const CELLS: u32 = 48;
/// Of the vibration, m.
const AMPLITUDE: f64 = 1e-3;

impl Strung {
    /// Of this stretch and stiffness, 1 m long at rest.
    const fn new(stretch: f64, stiffness: f64) -> Self {
        Self { stretch, stiffness }
    }

    /// One whose first mode has this frequency, Hz.
    pub fn of_frequency(frequency: f64) -> Self {
        let unit = Self::new(1.1, 1.0);
        Self { stiffness: (frequency / unit.frequency(1)).powi(2), ..unit }
    }

    /// Of a mode, Hz.
    pub fn frequency(self, mode: u32) -> f64 {
        let tension = 0.5 * self.stiffness * self.stretch * (self.stretch * self.stretch - 1.0);
        f64::from(mode) / (2.0 * self.stretch) * (tension / (DENSITY / self.stretch)).sqrt()
    }

    /// In this mode, at its amplitude, without gravity.
    pub fn cloth(self, mode: u32, settings: SolverSettings) -> Cloth {
        let fabric = Fabric::isotropic(DENSITY as f32, self.stiffness as f32, 0.0, 0.0).undamped();
        let mut cloth = Strip::new(1.0, 4.0 / f64::from(CELLS), CELLS, 4).cloth(fabric, settings);
        cloth.set_gravity(DVec3::ZERO);
        place(&mut cloth, |x| DVec3::new(self.stretch * x.x, AMPLITUDE * shape(x, mode), x.z));
        pin(&mut cloth, |x| x.x == 0.0 || x.x == 1.0);
        cloth
    }

    /// Of the vibration there is in a mode, m.
    pub fn amplitude(self, cloth: &Cloth, mode: u32) -> f64 {
        let vertices =
            cloth.shape().positions.iter().zip(cloth.positions()).zip(cloth.velocities()).zip(cloth.masses());
        let (mut place, mut speed, mut norm) = (0.0, 0.0, 0.0);
        for (((&rest, x), v), m) in vertices {
            let shape = shape(rest, mode);
            place += m * shape * x.y;
            speed += m * shape * v.y;
            norm += m * shape * shape;
        }
        (place / norm).hypot(speed / norm / (core::f64::consts::TAU * self.frequency(mode)))
    }
}

/// sin(n π x).
fn shape(x: DVec3, mode: u32) -> f64 {
    (core::f64::consts::PI * f64::from(mode) * x.x).sin()
}

/// The first three modes.
pub fn string() -> Vec<Row> {
    let strung = Strung::new(1.05, 500.0);
    [1, 2, 3]
        .into_iter()
        .map(|mode| {
            let expected = strung.frequency(mode);
            let mut cloth = strung.cloth(mode, exact());
            let dt = 1.0 / (200.0 * expected);
            let of_shape = |cloth: &Cloth| {
                let vertices = cloth.shape().positions.iter().zip(cloth.positions());
                vertices.map(|(&rest, x)| shape(rest, mode) * x.y).sum::<f64>()
            };
            let measured = frequency(&mut cloth, dt, 4.0 / expected, of_shape);
            Row::new("string/Hz", format!("mode {mode}"), expected, measured, 1e-2)
        })
        .collect()
}
