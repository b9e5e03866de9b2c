//! The bending elements of a cloth.

use super::BlockPattern;
use super::batch::{Batches, Elements, Output, PartBatches, pack};
use super::implicit_step::Linearisation;
use crate::physics::energy::hinge::{self, Edges, Rest};
use crate::physics::material::Fabric;
use crate::physics::math::{Lanes, Oct, Pack, Padded, ROWS, Real, Scalar, V3};
use crate::physics::mesh::RestShape;

/// All hinges, in batches.
pub(super) struct Hinges<T> {
    batches: Batches<4, 6>,
    rest: Vec<Rest<Pack<T>>>,
    /// Which hinge of the rest shape stands at each place.
    sources: Vec<u32>,
    /// By batch: a bit for each pair of vertices (i, j) of each hinge, set if i is the row of its block below the diagonal, and
    /// not j.
    rows_first: Vec<[u8; ROWS]>,
}

impl<T: Scalar> Hinges<T> {
    pub fn new(shape: &RestShape, fabric: &Fabric, inner: &[u32], rank: &[u32], pattern: &BlockPattern) -> Self {
        let vertices: Vec<_> = shape.hinges.iter().map(|h| h.vertices.map(|v| inner[v as usize])).collect();
        let (batches, sources) = Batches::new(&vertices, pattern, rank);
        let bits = |&source: &u32| {
            let Some(vertices) = vertices.get(source as usize) else { return 0 };
            PAIRS.iter().enumerate().map(|(pair, &[i, j])| u8::from(vertices[i] > vertices[j]) << pair).sum()
        };
        let rows_first =
            sources.chunks_exact(ROWS).map(|batch| core::array::from_fn(|lane| bits(&batch[lane]))).collect();
        let mut hinges = Self { batches, rest: Vec::new(), sources, rows_first };
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
        let stiffness = pack::<T>(&self.sources, 0.0, |i| rest(i).stiffness);
        let rest_angle = pack::<T>(&self.sources, 0.0, |i| rest(i).rest_angle);
        let floor = pack::<T>(&self.sources, 1.0, |i| rest(i).normal_floor);
        let constants = stiffness.into_iter().zip(rest_angle).zip(floor);
        self.rest = constants
            .map(|((stiffness, rest_angle), normal_floor)| Rest { stiffness, rest_angle, normal_floor })
            .collect();
    }

    #[inline(always)]
    fn rest<S: Oct<T>>(&self, s: S, batch: usize) -> Rest<Lanes<T, S>> {
        let Rest { stiffness, rest_angle, normal_floor } = &self.rest[batch];
        Rest {
            stiffness: Lanes::load(s, stiffness),
            rest_angle: Lanes::load(s, rest_angle),
            normal_floor: Lanes::load(s, normal_floor),
        }
    }

    #[inline(always)]
    fn edges<S: Oct<T>>(&self, s: S, batch: usize, x: &[Padded<f64>]) -> Edges<Lanes<T, S>> {
        let [e, a, b] = self.batches.edges(s.wide(), batch, x);
        [V3::narrow(s, e), V3::narrow(s, a), V3::narrow(s, b)]
    }
}

/// The pairs of vertices of a hinge.
const PAIRS: [[usize; 2]; 6] = [[1, 0], [2, 0], [2, 1], [3, 0], [3, 1], [3, 2]];

impl<T: Scalar> Elements<T> for Hinges<T> {
    fn batches(&self) -> &[PartBatches] {
        self.batches.parts()
    }

    #[inline(always)]
    fn energy<S: Oct<T>>(&self, s: S, batch: usize, x: &[Padded<f64>]) -> Lanes<T, S> {
        hinge::energy(&self.rest(s, batch), self.edges(s, batch, x))
    }

    /// All of the Hessian is material.
    #[inline(always)]
    fn assemble<S: Oct<T>>(&self, s: S, batch: usize, at: &Linearisation<T>, out: &mut Output<T>) {
        let rest = self.rest(s, batch);
        let angle = hinge::angle(self.edges(s, batch, at.x), rest.normal_floor);
        let rigidity = hinge::rigidity(&rest);
        let mut moment = hinge::moment(&rest, angle.theta);
        if at.rate > 0.0 {
            let moves = self.batches.edge_moves(s, batch, at.moved);
            moment += rigidity * rigidity.splat(at.rate) * angle.change(moves);
        }

        let gradient = angle.gradient;
        for (vertex, gradient) in gradient.into_iter().enumerate() {
            out.add_forces(s, self.batches.vertices(batch, vertex), gradient * -moment);
        }
        let weight = rigidity * rigidity.splat(at.material);
        let bits = &self.rows_first[batch];
        for (pair, [i, j]) in PAIRS.into_iter().enumerate() {
            let [row, column] = in_order(s, bits, pair as u32, [gradient[i], gradient[j]]);
            out.add_blocks(s, self.batches.slots(batch, pair), &(row * weight).outer(column));
        }
    }
}

/// The two vectors of each element where its bit is set, elsewhere the second first.
#[inline(always)]
fn in_order<T: Scalar, S: Oct<T>>(
    s: S,
    bits: &[u8; ROWS],
    bit: u32,
    [V3(a), V3(b)]: [V3<Lanes<T, S>>; 2],
) -> [V3<Lanes<T, S>>; 2] {
    let (mut first, mut second) = (a, b);
    for c in 0..3 {
        first[c].v = s.if_bit(bits, bit, a[c].v, b[c].v);
        second[c].v = s.if_bit(bits, bit, b[c].v, a[c].v);
    }
    [V3(first), V3(second)]
}
