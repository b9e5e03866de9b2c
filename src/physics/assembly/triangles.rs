//! The membrane elements of a cloth.

use bevy::math::DVec3;

use super::batch::{Batches, fill_up, pack};
use super::implicit_step::{Linearisation, Projection};
use super::{BlockCsr, BlockPattern};
use crate::physics::energy::membrane::{self, Gram, Orthotropic, Rest, Strain};
use crate::physics::material::Fabric;
use crate::physics::math::{Kernel, Real, V3, dispatch};
use crate::physics::mesh::{RestShape, Triangle};

fn constants<L: Real>(fabric: &Fabric) -> Orthotropic<L> {
    Orthotropic {
        k0: L::splat(fabric.warp_stiffness.into()),
        k1: L::splat(fabric.coupling.into()),
        k2: L::splat(fabric.weft_stiffness.into()),
        k3: L::splat(fabric.shear_stiffness.into()),
    }
}

/// All triangles, in batches.
pub(super) struct Triangles<L> {
    batches: Batches<3>,
    rest: Vec<Rest<L>>,
    /// Gram matrices of the rest edges, by element: in f64, see [`membrane`].
    rest_grams: Vec<Gram<f64>>,
    constants: Orthotropic<L>,
}

impl<L: Real> Triangles<L> {
    pub fn new(shape: &RestShape, fabric: &Fabric, pattern: &BlockPattern) -> Self {
        let batches = Batches::new(shape.triangles.iter().map(|t| t.vertices).collect(), L::LANES, pattern);
        let column = |f: &dyn Fn(&Triangle) -> f64| -> Vec<f64> { shape.triangles.iter().map(f).collect() };
        let dm: [[Vec<f64>; 2]; 2] =
            core::array::from_fn(|r| core::array::from_fn(|c| column(&|t| t.dm_inverse[r][c])));
        let areas = column(&|t| t.area);
        let rest = (0..batches.len())
            .map(|batch| Rest {
                dm_inverse: core::array::from_fn(|r| core::array::from_fn(|c| pack(&dm[r][c], batch, 0.0))),
                // A filler has no area, so no energy, force or Hessian.
                area: pack(&areas, batch, 0.0),
            })
            .collect();
        let mut rest_grams = shape.triangles.iter().map(|t| t.rest_gram).collect();
        fill_up(&mut rest_grams, L::LANES);
        Self { batches, rest, rest_grams, constants: constants(fabric) }
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, fabric: &Fabric) {
        self.constants = constants(fabric);
    }

    #[inline(always)]
    fn strain(&self, batch: usize, x: &[DVec3]) -> Strain<L> {
        let change = |entry: usize| {
            self.batches
                .map(batch, x, |element, edges| membrane::half_gram_change(edges, self.rest_grams[element])[entry])
        };
        self.rest[batch].green_strain([change(0), change(1), change(2)])
    }

    /// Energy, J.
    pub fn energy(&self, x: &[DVec3]) -> f64 {
        dispatch(EnergyOf(self, x))
    }

    #[inline(always)]
    fn energy_inline(&self, x: &[DVec3]) -> f64 {
        let rest = self.rest.iter().enumerate();
        rest.map(|(i, rest)| membrane::energy(rest, &self.constants, &self.strain(i, x)).sum_lanes()).sum()
    }

    /// Adds the forces, damping included, and the weighted projected Hessian.
    pub fn assemble(&self, at: &Linearisation, forces: &mut [V3<L::Scalar>], matrix: &mut BlockCsr<L::Scalar>) {
        dispatch(Assemble { elements: self, at, forces, matrix });
    }

    #[inline(always)]
    fn assemble_inline(&self, at: &Linearisation, forces: &mut [V3<L::Scalar>], matrix: &mut BlockCsr<L::Scalar>) {
        let (material, geometric, rate) = (L::splat(at.material), L::splat(at.geometric), L::splat(at.rate));
        let k = &self.constants;
        for (batch, rest) in self.rest.iter().enumerate() {
            let w = rest.deformation(self.batches.edges(batch, at.x));
            let stress = k.stress(&self.strain(batch, at.x));
            let projected = match at.projection {
                Projection::PositivePart => stress.positive_part(),
                Projection::Absolute => stress.absolute(),
            };
            let mut total = stress;
            if at.rate > 0.0 {
                let moved = rest.deformation(self.batches.edge_moves(batch, at.origin, at.x));
                total = total + k.stress(&w.strain_rate(&moved)) * rate;
            }
            let [g1, g2] = membrane::gradient(rest, &total, &w);
            self.batches.scatter_forces(batch, [g1 + g2, -g1, -g2], forces);
            let blocks = membrane::hessian(rest, k, &projected, &w, material, geometric).blocks();
            for (i, row) in blocks.iter().enumerate() {
                for (j, block) in row.iter().enumerate() {
                    self.batches.scatter_block(batch, (i, j), block, matrix);
                }
            }
        }
    }
}

struct EnergyOf<'a, L>(&'a Triangles<L>, &'a [DVec3]);

impl<L: Real> Kernel for EnergyOf<'_, L> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        self.0.energy_inline(self.1)
    }
}

struct Assemble<'a, L: Real> {
    elements: &'a Triangles<L>,
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
