//! The bending elements of a cloth.

use bevy::math::DVec3;

use super::BlockPattern;
use super::batch::{Batches, Elements, FILLER, Output, PartBatches, pack};
use super::implicit_step::Linearisation;
use crate::physics::energy::hinge::{self, Rest};
use crate::physics::material::Fabric;
use crate::physics::math::{Padded, Real, Spread, V3};
use crate::physics::mesh::RestShape;

/// All hinges, in batches.
pub(super) struct Hinges<L> {
    batches: Batches<4, 6>,
    rest: Vec<Rest<L>>,
    /// Which hinge of the rest shape stands at each place.
    sources: Vec<u32>,
    /// The vertices of each in ascending order.
    ascending: Vec<[u8; 4]>,
}

impl<L: Real> Hinges<L> {
    pub fn new(shape: &RestShape, fabric: &Fabric, inner: &[u32], rank: &[u32], pattern: &BlockPattern) -> Self {
        let vertices: Vec<_> = shape.hinges.iter().map(|h| h.vertices.map(|v| inner[v as usize])).collect();
        let (batches, sources) = Batches::new(&vertices, L::LANES, pattern, rank);
        let ascending = sources.iter().map(|&source| {
            let mut order = [0, 1, 2, 3];
            if source != FILLER {
                order.sort_unstable_by_key(|&i| vertices[source as usize][usize::from(i)]);
            }
            order
        });
        let mut hinges = Self { batches, rest: Vec::new(), ascending: ascending.collect(), sources };
        hinges.set_fabric(shape, fabric);
        hinges
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, shape: &RestShape, fabric: &Fabric) {
        let rest = |i: usize| {
            let h = &shape.hinges[i];
            Rest::new(fabric.bending_along(h.direction), h.length, h.height, h.double_areas, h.rest_angle)
        };
        // A filler has no stiffness, so no energy, force or Hessian.
        let stiffness = pack::<L>(&self.sources, 0.0, |i| rest(i).stiffness);
        let rest_angle = pack::<L>(&self.sources, 0.0, |i| rest(i).rest_angle);
        let floor = pack::<L>(&self.sources, 1.0, |i| rest(i).normal_floor);
        let constants = stiffness.into_iter().zip(rest_angle).zip(floor);
        self.rest = constants
            .map(|((stiffness, rest_angle), normal_floor)| Rest { stiffness, rest_angle, normal_floor })
            .collect();
    }
}

impl<L: Real> Elements for Hinges<L> {
    type Lanes = L;

    fn batches(&self) -> &[PartBatches] {
        self.batches.parts()
    }

    #[inline(always)]
    fn energy(&self, batch: usize, x: &[DVec3]) -> L {
        hinge::energy(&self.rest[batch], self.batches.edges(batch, x))
    }

    /// All of the Hessian is material.
    #[inline(always)]
    fn assemble(&self, batch: usize, at: &Linearisation<L::Scalar>, out: &mut Output<L::Scalar>) {
        let rest = &self.rest[batch];
        let angle = hinge::angle(self.batches.edges(batch, at.x), rest.normal_floor);
        let rigidity = hinge::rigidity(rest);
        let mut moment = hinge::moment(rest, angle.theta);
        if at.rate > 0.0 {
            let moves = self.batches.edge_moves(batch, at.moved);
            moment += rigidity * L::splat(at.rate) * angle.change(moves);
        }

        let (vertices, slots) = (self.batches.vertices::<L>(batch), self.batches.slots::<L>(batch));
        let ascending = &self.ascending[batch * L::LANES..][..L::LANES];
        let weight = rigidity * L::splat(at.material);
        let [g0, g1, g2, g3] = angle.gradient;
        let gradients = [quads(g0), quads(g1), quads(g2), quads(g3)];
        for lane in 0..L::LANES {
            let force = L::Scalar::zero() - moment.lane(lane);
            let mut sorted = [0; 4];
            let mut spread = [Spread::new(Padded::zero(), L::Scalar::zero()); 4];
            for (i, &from) in ascending[lane].iter().enumerate() {
                let from = usize::from(from % 4);
                let gradient = Padded::<L::Scalar>(gradients[from].as_ref()[lane]);
                sorted[i] = vertices[lane][from];
                spread[i] = Spread::new(gradient, weight.lane(lane));
                out.add_force(sorted[i], gradient * force);
            }
            let mut slot = slots[lane].iter();
            for i in 0..4 {
                for j in 0..i {
                    if let Some(&slot) = slot.next() {
                        out.add(slot as usize, spread[i].outer(&spread[j]));
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn quads<L: Real>(V3([x, y, z]): V3<L>) -> L::Quads {
    L::quads([x, y, z, L::zero()])
}
