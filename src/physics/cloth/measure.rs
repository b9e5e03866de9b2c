//! What can be read off a cloth.

use bevy::math::DVec3;

use super::Cloth;
use crate::physics::assembly::ElasticEnergy;
use crate::physics::energy::membrane::Rest;
use crate::physics::math::V3;
use crate::physics::mesh::RestShape;
use crate::physics::terms::gravity;

/// Energy of a cloth, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// ½ Σ m v².
    pub kinetic: f64,
    /// Stretch and shear.
    pub membrane: f64,
    /// Bending.
    pub bending: f64,
    /// −Σ m g·x: zero at the world origin.
    pub gravity: f64,
}

impl Energy {
    /// Sum of the terms, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.membrane + self.bending + self.gravity
    }
}

/// Elongation of the yarns, relative to their rest length: the two directions of each triangle, so that shearing (which a
/// weave gives way to) does not count as stretch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Largest elongation; below zero if every yarn is compressed.
    pub max: f64,
    /// Root mean square over both directions, weighted by area.
    pub rms: f64,
}

pub(super) fn energy(cloth: &Cloth, elastic: ElasticEnergy) -> Energy {
    let speeds = cloth.velocities().iter().map(|v| v.length_squared());
    Energy {
        kinetic: 0.5 * cloth.masses().iter().zip(speeds).map(|(m, v2)| m * v2).sum::<f64>(),
        membrane: elastic.membrane,
        bending: elastic.bending,
        gravity: gravity::energy(cloth.gravity(), cloth.masses(), cloth.positions()),
    }
}

pub(super) fn stretch(shape: &RestShape, x: &[DVec3]) -> Stretch {
    let (mut max, mut sum, mut weight) = (f64::NEG_INFINITY, 0.0, 0.0);
    for triangle in &shape.triangles {
        let [a, b, c] = triangle.vertices.map(|v| x[v as usize]);
        let rest = Rest { dm_inverse: triangle.dm_inverse, area: triangle.area };
        let w = rest.deformation([V3((b - a).to_array()), V3((c - a).to_array())]);
        for column in [w.w_u, w.w_v] {
            let elongation = column.norm_squared().sqrt() - 1.0;
            max = max.max(elongation);
            sum += triangle.area * elongation * elongation;
            weight += triangle.area;
        }
    }
    Stretch { max, rms: (sum / weight).sqrt() }
}
