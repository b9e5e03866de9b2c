//! A and b of one implicit step.

use std::sync::Arc;

use bevy::math::DVec3;

use super::hinges::Hinges;
use super::implicit_step::{ImplicitStep, Linearisation};
use super::triangles::Triangles;
use super::{BlockCsr, BlockPattern};
use crate::physics::energy::gravity;
use crate::physics::material::Fabric;
use crate::physics::math::{M3, Real, Scalar, V3};
use crate::physics::mesh::RestShape;

/// Elastic energy by term, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElasticEnergy {
    /// Stretch and shear.
    pub membrane: f64,
    /// Bending.
    pub bending: f64,
}

impl ElasticEnergy {
    /// Sum of the terms, J.
    pub fn total(&self) -> f64 {
        self.membrane + self.bending
    }
}

/// The linear system of a cloth: elements, and the storage of A and b.
pub struct System<L: Real> {
    triangles: Triangles<L>,
    hinges: Hinges<L>,
    forces: Vec<V3<L::Scalar>>,
    /// A.
    pub matrix: BlockCsr<L::Scalar>,
    /// b, kg·m.
    pub rhs: Vec<V3<L::Scalar>>,
}

impl<L: Real> System<L> {
    /// The system of a cloth; the pattern of A and the slot of each element's blocks are found here, once.
    pub fn new(shape: &RestShape, fabric: &Fabric) -> Self {
        let triangles = shape.triangles.iter().map(|t| &t.vertices[..]);
        let hinges = shape.hinges.iter().map(|h| &h.vertices[..]);
        let pattern = BlockPattern::new(shape.vertex_count(), triangles.chain(hinges));
        let zeros = vec![V3::zero(); shape.vertex_count()];
        Self {
            triangles: Triangles::new(shape, fabric, &pattern),
            hinges: Hinges::new(shape, fabric, &pattern),
            forces: zeros.clone(),
            matrix: BlockCsr::zero(Arc::new(pattern)),
            rhs: zeros,
        }
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, shape: &RestShape, fabric: &Fabric) {
        self.triangles.set_fabric(fabric);
        self.hinges.set_fabric(shape, fabric);
    }

    /// Elastic energy at `x`.
    pub fn energy(&self, x: &[DVec3]) -> ElasticEnergy {
        ElasticEnergy { membrane: self.triangles.energy(x), bending: self.hinges.energy(x) }
    }

    /// Fills A and b.
    pub fn assemble(&mut self, step: &ImplicitStep, masses: &[f64]) {
        let gamma = step.gamma;
        let linearisation = Linearisation::from(step);
        self.matrix.clear();
        self.forces.fill(V3::zero());
        self.triangles.assemble(&linearisation, &mut self.forces, &mut self.matrix);
        self.hinges.assemble(&linearisation, &mut self.forces, &mut self.matrix);

        let inertia = 1.0 + gamma * step.air_drag;
        for (vertex, &mass) in masses.iter().enumerate() {
            *self.matrix.diagonal_mut(vertex) += M3::scaled_identity(Scalar::from_f64(mass * inertia));
            let x = step.x[vertex];
            let elastic = DVec3::from(self.forces[vertex].to_f64());
            let carried = step.inertial[vertex] - x - gamma * step.air_drag * (x - step.origin[vertex]);
            let force = elastic + gravity::force(step.gravity, mass);
            let rhs = mass * (carried - inertia * step.drift) + gamma * gamma * force;
            self.rhs[vertex] = V3::from_f64(rhs.to_array());
        }
    }
}
