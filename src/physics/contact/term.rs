//! Contact as a term of the step.

use bevy::math::DVec3;

use super::layer::ContactLayer;
use super::touch::Touch;
use crate::physics::assembly::Stencil;
use crate::physics::math::Scalar;
use crate::physics::terms::{Substep, Term};

impl<T: Scalar> Term<T> for ContactLayer {
    fn add_stencils(&mut self, at: &[DVec3], out: &mut Vec<Stencil>) {
        let active = self.touches.iter_mut().filter(|touch| touch.is_active());
        out.extend(active.map(|touch| touch.stencil(touch.point(at))));
    }

    fn holds(&self) -> bool {
        self.any_active()
    }

    fn substep_potential(&self, x: &[DVec3]) -> f64 {
        self.touches.iter().map(|touch| touch.potential(touch.point(x))).sum()
    }

    /// Work that colliders did, counting none that they took.
    fn work(&self, substep: &Substep, x: &[DVec3]) -> f64 {
        let done = |touch: &Touch| {
            let way = touch.point(x) - touch.point(substep.x);
            let along = touch.normal.dot(way) * touch.normal.dot(touch.acted);
            along.max(0.0) + (touch.acted.dot(way) - along).max(0.0)
        };
        self.touches.iter().map(done).sum()
    }
}
