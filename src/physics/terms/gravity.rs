//! Gravity, `E = −Σ mᵢ g·xᵢ`: a constant force, so its Hessian is zero.

use bevy::math::DVec3;

use super::{Row, Substep, Term};
use crate::physics::assembly::ImplicitStep;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::math::Scalar;

/// Potential energy of the masses (kg) at these positions (m), J; zero at the origin.
pub fn energy(gravity: DVec3, masses: &[f64], positions: &[DVec3]) -> f64 {
    -masses.iter().zip(positions).map(|(&m, &x)| m * gravity.dot(x)).sum::<f64>()
}

/// The weight of the vertices.
#[derive(Clone, Copy, Debug)]
pub struct Gravity;

impl<T: Scalar> Term<T> for Gravity {
    fn add_rows(&self, at: &ImplicitStep, masses: &[f64], first: usize, rows: &mut [Row]) {
        let fall = at.gamma * at.gamma * at.gravity;
        for (row, &mass) in rows.iter_mut().zip(&masses[first..]) {
            row.b += mass * fall;
        }
    }

    /// Zero at xₙ.
    fn driven(&mut self, substep: &Substep, x: &[DVec3], parts: &[Part]) -> f64 {
        let Substep { x: start, held, masses, gravity, .. } = *substep;
        for_parts(parts, (), &|part: &Part, ()| {
            let free = part.rows.clone().filter(|&vertex| !held[vertex]);
            -free.map(|vertex| masses[vertex] * gravity.dot(x[vertex] - start[vertex])).sum::<f64>()
        })
    }
}
