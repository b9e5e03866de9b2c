//! The bending elements of a cloth.

use bevy::math::DVec3;

use super::batch::{Batches, pack};
use super::implicit_step::Linearisation;
use super::{BlockCsr, BlockPattern};
use crate::physics::energy::hinge::{self, Rest};
use crate::physics::material::Fabric;
use crate::physics::math::{Kernel, Real, V3, dispatch};
use crate::physics::mesh::RestShape;

/// All hinges, in batches.
pub(super) struct Hinges<L> {
    batches: Batches<4>,
    rest: Vec<Rest<L>>,
}

impl<L: Real> Hinges<L> {
    pub fn new(shape: &RestShape, fabric: &Fabric, pattern: &BlockPattern) -> Self {
        let batches = Batches::new(shape.hinges.iter().map(|h| h.vertices).collect(), L::LANES, pattern);
        let mut hinges = Self { batches, rest: Vec::new() };
        hinges.set_fabric(shape, fabric);
        hinges
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, shape: &RestShape, fabric: &Fabric) {
        let rests: Vec<Rest<f64>> = shape
            .hinges
            .iter()
            .map(|h| Rest::new(fabric.bending_along(h.direction), h.length, h.height, h.double_areas, h.rest_angle))
            .collect();
        let column = |f: &dyn Fn(&Rest<f64>) -> f64| -> Vec<f64> { rests.iter().map(f).collect() };
        let stiffness = column(&|rest| rest.stiffness);
        let rest_angle = column(&|rest| rest.rest_angle);
        let floor = column(&|rest| rest.normal_floor);
        self.rest = (0..self.batches.len())
            .map(|batch| Rest {
                // A filler has no stiffness, so no energy, force or Hessian.
                stiffness: pack(&stiffness, batch, 0.0),
                rest_angle: pack(&rest_angle, batch, 0.0),
                normal_floor: pack(&floor, batch, 1.0),
            })
            .collect();
    }

    /// Energy, J.
    pub fn energy(&self, x: &[DVec3]) -> f64 {
        dispatch(EnergyOf(self, x))
    }

    #[inline(always)]
    fn energy_inline(&self, x: &[DVec3]) -> f64 {
        let rest = self.rest.iter().enumerate();
        rest.map(|(i, rest)| hinge::energy(rest, self.batches.edges(i, x)).sum_lanes()).sum()
    }

    /// Adds the forces, damping included, and the weighted Gauss–Newton Hessian. All of that Hessian is material.
    pub fn assemble(&self, at: &Linearisation, forces: &mut [V3<L::Scalar>], matrix: &mut BlockCsr<L::Scalar>) {
        dispatch(Assemble { elements: self, at, forces, matrix });
    }

    #[inline(always)]
    fn assemble_inline(&self, at: &Linearisation, forces: &mut [V3<L::Scalar>], matrix: &mut BlockCsr<L::Scalar>) {
        let (weight, rate) = (L::splat(at.material), L::splat(at.rate));
        for (batch, rest) in self.rest.iter().enumerate() {
            let angle = hinge::angle(self.batches.edges(batch, at.x), rest.normal_floor);
            let rigidity = hinge::rigidity(rest);
            let mut moment = hinge::moment(rest, angle.theta);
            if at.rate > 0.0 {
                moment += rigidity * rate * angle.change(self.batches.edge_moves(batch, at.origin, at.x));
            }
            self.batches.scatter_forces(batch, core::array::from_fn(|i| angle.gradient[i] * -moment), forces);
            for i in 0..4 {
                let scaled = angle.gradient[i] * (rigidity * weight);
                self.batches.scatter_block(batch, (i, i), &scaled.outer(angle.gradient[i]), matrix);
                for j in i + 1..4 {
                    let block = scaled.outer(angle.gradient[j]);
                    self.batches.scatter_block(batch, (i, j), &block, matrix);
                    self.batches.scatter_block(batch, (j, i), &block.transpose(), matrix);
                }
            }
        }
    }
}

struct EnergyOf<'a, L>(&'a Hinges<L>, &'a [DVec3]);

impl<L: Real> Kernel for EnergyOf<'_, L> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        self.0.energy_inline(self.1)
    }
}

struct Assemble<'a, L: Real> {
    elements: &'a Hinges<L>,
    at: &'a Linearisation<'a>,
    forces: &'a mut [V3<L::Scalar>],
    matrix: &'a mut BlockCsr<L::Scalar>,
}

impl<L: Real> Kernel for Assemble<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.elements.assemble_inline(self.at, self.forces, self.matrix);
    }
}
