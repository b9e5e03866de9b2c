//! The bending elements of a cloth.

use super::BlockPattern;
use super::batch::{self, Batches, Elements, FILLER, Output, PartBatches};
use super::implicit_step::Linearisation;
use super::mid_edges::{self, MidEdges, Phi, turned};
use super::parts::{Part, for_parts};
use crate::physics::energy::hinge::{self, Edges, Rest};
use crate::physics::material::Fabric;
use crate::physics::math::{Lanes, Oct, Pack, Padded, ROWS, Real, RowKernel, Scalar, V3};
use crate::physics::mesh::{BendingModel, Hinge, RestShape};

/// All hinges, in batches.
pub(super) struct Hinges<T> {
    batches: Batches<4, 6>,
    rest: Vec<Rest<Pack<T>>>,
    /// Which hinge of the rest shape stands at each place.
    sources: Vec<u32>,
    /// By batch: a bit for each pair of vertices (i, j) of each hinge, set if i is the row of its block below the diagonal, and
    /// not j.
    rows_first: Vec<[u8; ROWS]>,
    /// Where the moments come from, if not from each hinge alone.
    mid_edges: Option<MidEdges<T>>,
}

/// Rest state and stiffness of a hinge.
pub(super) fn rest(hinge: &Hinge, fabric: &Fabric) -> Rest<f64> {
    rest_of(hinge, fabric.bending_along(hinge.direction))
}

fn rest_of(hinge: &Hinge, bending: f64) -> Rest<f64> {
    Rest::new(bending, hinge.length, hinge.height, hinge.double_areas, hinge.rest_angle)
}

impl<T: Scalar> Hinges<T> {
    pub fn new(shape: &RestShape, fabric: &Fabric, inner: &[u32], rank: &[u32], pattern: &BlockPattern) -> Self {
        let vertices: Vec<_> = shape.bending_hinges().iter().map(|h| h.vertices.map(|v| inner[v as usize])).collect();
        let (batches, sources) = Batches::new(&vertices, pattern, rank);
        let bits = |&source: &u32| {
            let Some(vertices) = vertices.get(source as usize) else { return 0 };
            PAIRS.iter().enumerate().map(|(pair, &[i, j])| u8::from(vertices[i] > vertices[j]) << pair).sum()
        };
        let rows_first =
            sources.chunks_exact(ROWS).map(|batch| core::array::from_fn(|lane| bits(&batch[lane]))).collect();
        let own = batches.parts().iter().map(PartBatches::own);
        let mid_edges = match shape.bending {
            BendingModel::MidEdge => Some(MidEdges::new(shape, inner, own, &sources)),
            BendingModel::Hinge | BendingModel::None => None,
        };
        let zero = Pack([T::zero(); ROWS]);
        // A filler has no stiffness, so no energy, force or Hessian.
        let filler = Rest { stiffness: zero, rest_angle: zero, normal_floor: Pack([T::from_f64(1.0); ROWS]) };
        let rest = vec![filler; sources.len() / ROWS];
        let mut hinges = Self { batches, rest, sources, rows_first, mid_edges };
        hinges.measure(shape, fabric);
        hinges
    }

    /// Takes over what the hinges measure at rest, and the material.
    pub fn measure(&mut self, shape: &RestShape, fabric: &Fabric) {
        // With mid-edge normals, the stiffness comes from there.
        let alone = self.mid_edges.is_none();
        for (sources, packs) in self.sources.chunks_exact(ROWS).zip(&mut self.rest) {
            for (lane, &source) in sources.iter().enumerate().filter(|(_, source)| **source != FILLER) {
                let hinge = &shape.hinges[source as usize];
                let bending = if alone { fabric.bending_along(hinge.direction) } else { 0.0 };
                let rest = rest_of(hinge, bending);
                packs.stiffness.0[lane] = T::from_f64(rest.stiffness);
                packs.rest_angle.0[lane] = T::from_f64(rest.rest_angle);
                packs.normal_floor.0[lane] = T::from_f64(rest.normal_floor);
            }
        }
        if let Some(mid_edges) = &mut self.mid_edges {
            mid_edges.measure(shape, fabric);
            self.bound();
        }
    }

    /// Says that the cloth was mirrored: every angle has the other sign now.
    pub fn mirror(&mut self) {
        if let Some(mid_edges) = &mut self.mid_edges {
            mid_edges.mirror();
        }
    }

    /// Gives the hinges what mid-edge normals have in the Hessian.
    fn bound(&mut self) {
        let Self { mid_edges: Some(mid_edges), rest, .. } = self else { return };
        for (batch, rest) in rest.iter_mut().enumerate() {
            rest.stiffness = Pack(mid_edges.bounds(batch).0.map(|bound| bound * T::from_f64(0.5)));
        }
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

impl<T: Scalar> Hinges<T> {
    /// Elastic energy at `x`, J.
    pub fn total_energy(&mut self, parts: &[Part], x: &[Padded<f64>]) -> f64 {
        match self.mid_edges.take() {
            None => self.total_energy_at(parts, x),
            Some(mut mid_edges) => {
                let energy = mid_edges.energy(&self.angles_at(x, None));
                self.mid_edges = Some(mid_edges);
                energy
            }
        }
    }

    /// The same, for those who may not change anything.
    pub fn total_energy_at(&self, parts: &[Part], x: &[Padded<f64>]) -> f64 {
        match &self.mid_edges {
            None => for_parts(parts, (), &|part: &Part, ()| batch::energy(self, part.index, x)),
            Some(mid_edges) => mid_edges.energy_at(&self.angles_at(x, None)),
        }
    }

    /// Before forces are linearised there.
    pub fn prepare(&mut self, at: &Linearisation<T>) {
        if let Some(mut mid_edges) = self.mid_edges.take() {
            let damping = (at.rate > 0.0).then_some(at);
            mid_edges.relax(&self.angles_at(at.x, damping));
            self.mid_edges = Some(mid_edges);
        }
    }

    /// Before anything else is done at points that have nothing to do with those before.
    pub fn settle(&mut self, x: &[Padded<f64>]) {
        if let Some(mut mid_edges) = self.mid_edges.take() {
            mid_edges.settle(&self.angles_at(x, None));
            self.mid_edges = Some(mid_edges);
        }
    }

    /// Says which vertices are held.
    pub fn hold(&mut self, held: &[bool]) {
        if self.mid_edges.as_mut().is_some_and(|mid_edges| mid_edges.hold(held)) {
            self.bound();
        }
    }

    /// The vertices held, as far as they matter.
    pub fn held(&self) -> &[bool] {
        self.mid_edges.as_ref().map_or(&[], MidEdges::held)
    }

    /// What is remembered from linearisation to linearisation.
    pub fn turns(&self) -> Vec<T> {
        self.mid_edges.as_ref().map_or_else(Vec::new, MidEdges::turns)
    }

    /// Puts that back.
    pub fn set_turns(&mut self, turns: &[T]) {
        if let Some(mid_edges) = &mut self.mid_edges {
            mid_edges.set_turns(turns);
        }
    }

    /// Angles at `x`, with what damping adds to them.
    fn angles_at(&self, x: &[Padded<f64>], damping: Option<&Linearisation<T>>) -> impl mid_edges::Angles<T> {
        move |part: usize, shares: &[Pack<T>], phi: &[Phi<T>], out: &mut [Phi<T>]| {
            T::dispatch(Angles { hinges: self, part, x, damping, shares, phi, out });
        }
    }
}

struct Angles<'a, T: Scalar> {
    hinges: &'a Hinges<T>,
    part: usize,
    x: &'a [Padded<f64>],
    damping: Option<&'a Linearisation<'a, T>>,
    shares: &'a [Pack<T>],
    phi: &'a [Phi<T>],
    out: &'a mut [Phi<T>],
}

impl<T: Scalar> RowKernel<T> for Angles<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        let Self { hinges, x, damping, .. } = self;
        let packs = self.shares.iter().zip(self.phi).zip(self.out);
        for (batch, ((share, phi), out)) in hinges.batches.parts()[self.part].own().zip(packs) {
            let rest = hinges.rest(s, batch);
            let edges = hinges.edges(s, batch, x);
            let mut deviation = hinge::deviation(hinge::theta(edges), rest.rest_angle);
            if let Some(at) = damping {
                let moves = hinges.batches.edge_moves(s, batch, at.moved);
                let change = hinge::gradient(edges, rest.normal_floor).change(moves);
                deviation += change * change.splat(at.rate);
            }
            *out = turned(deviation, share, phi);
        }
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
        let edges = self.edges(s, batch, at.x);
        let gradient = hinge::gradient(edges, rest.normal_floor);
        let rigidity = hinge::rigidity(&rest);
        let moment = match &self.mid_edges {
            Some(mid_edges) => Lanes::load(s, &mid_edges.moments(batch)),
            None => {
                let elastic = hinge::moment(&rest, hinge::theta(edges));
                if at.rate > 0.0 {
                    let moves = self.batches.edge_moves(s, batch, at.moved);
                    elastic + rigidity * rigidity.splat(at.rate) * gradient.change(moves)
                } else {
                    elastic
                }
            }
        };

        let gradient = gradient.0;
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
