//! Inertia: `M (x' − y)`, with y where it alone would lead.

use super::{Row, Term};
use crate::physics::assembly::ImplicitStep;
use crate::physics::math::Scalar;

/// The masses of the vertices, see [`ImplicitStep`].
#[derive(Clone, Copy, Debug)]
pub struct Inertia;

impl<T: Scalar> Term<T> for Inertia {
    fn add_rows(&self, at: &ImplicitStep, masses: &[f64], first: usize, rows: &mut [Row]) {
        for (vertex, row) in (first..).zip(rows) {
            let mass = masses[vertex] * at.inertia.map_or(1.0, |factors| factors[vertex]);
            row.diagonal += mass;
            row.b += mass * (at.inertial[vertex] - at.x[vertex]);
        }
    }
}
