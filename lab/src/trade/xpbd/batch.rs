//! Elements in batches of eight that share no vertex.

use bevy_cloth::physics::math::{Lanes, Oct, Pack, Padded, ROWS, Scalar, V3};

use super::Point;
use super::colouring::by_colour;

/// The vertices of elements of V vertices each.
#[derive(Clone, Debug)]
pub(super) struct Batches<const V: usize>(Vec<[[u32; ROWS]; V]>);

impl<const V: usize> Batches<V> {
    /// Batches of these elements, colour after colour and in each in the order of their first vertex, and which element stands
    /// at each place. Where a batch is filled up there is none: such a place has the vertex after the last, that belongs to
    /// nobody, and its rest data must make it contribute nothing.
    pub fn new(elements: &[[u32; V]], vertex_count: usize) -> (Self, Vec<Option<u32>>) {
        let mut order: Vec<u32> = (0..elements.len() as u32).collect();
        order.sort_by_key(|&element| elements[element as usize].into_iter().min());
        let ordered: Vec<_> = order.iter().map(|&element| elements[element as usize]).collect();
        let mut sources = Vec::new();
        for colour in by_colour(&ordered, vertex_count) {
            sources.extend(colour.iter().map(|&place| Some(order[place as usize])));
            sources.resize(sources.len().next_multiple_of(ROWS), None);
        }
        let vertex = |source: Option<u32>, which: usize| {
            source.map_or(vertex_count as u32, |element| elements[element as usize][which])
        };
        let batches = sources.chunks_exact(ROWS);
        let vertices = batches
            .map(|batch| core::array::from_fn(|which| core::array::from_fn(|lane| vertex(batch[lane], which))))
            .collect();
        (Self(vertices), sources)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Vertices 1… of each element relative to its vertex 0, where they have got to.
    #[inline(always)]
    pub fn edges<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        points: &[Point<T>],
    ) -> [V3<Lanes<T, S>>; E] {
        let mut edges = [[Padded::zero(); ROWS]; E];
        for lane in 0..ROWS {
            let vertices = &self.0[batch];
            let origin = points[vertices[0][lane] as usize];
            for (i, edge) in edges.iter_mut().enumerate() {
                let point = points[vertices[i + 1][lane] as usize];
                edge[lane] = (point.at - origin.at) + (point.moved - origin.moved);
            }
        }
        turned(s, &edges)
    }

    /// The same at the beginning of the substep.
    #[inline(always)]
    pub fn settled_edges<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        points: &[Point<T>],
    ) -> [V3<Lanes<T, S>>; E] {
        let mut edges = [[Padded::zero(); ROWS]; E];
        for lane in 0..ROWS {
            let vertices = &self.0[batch];
            let origin = points[vertices[0][lane] as usize].at;
            for (i, edge) in edges.iter_mut().enumerate() {
                edge[lane] = points[vertices[i + 1][lane] as usize].at - origin;
            }
        }
        turned(s, &edges)
    }

    /// How far those edges have changed in the substep.
    #[inline(always)]
    pub fn edge_moves<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        points: &[Point<T>],
    ) -> [V3<Lanes<T, S>>; E] {
        let mut edges = [[Padded::zero(); ROWS]; E];
        for lane in 0..ROWS {
            let vertices = &self.0[batch];
            let origin = points[vertices[0][lane] as usize].moved;
            for (i, edge) in edges.iter_mut().enumerate() {
                edge[lane] = points[vertices[i + 1][lane] as usize].moved - origin;
            }
        }
        turned(s, &edges)
    }

    /// Moves one vertex of each element on.
    #[inline(always)]
    pub fn shift<T: Scalar, S: Oct<T>>(
        &self,
        s: S,
        batch: usize,
        which: usize,
        V3([x, y, z]): V3<Lanes<T, S>>,
        points: &mut [Point<T>],
    ) {
        let moves = s.turn_back([x.v, y.v, z.v]);
        for (&vertex, moved) in self.0[batch][which].iter().zip(moves) {
            points[vertex as usize].moved += moved;
        }
    }
}

/// Eight vectors of each kind as eight x, eight y and eight z.
#[inline(always)]
fn turned<T: Scalar, S: Oct<T>, const E: usize>(s: S, edges: &[[Padded<T>; ROWS]; E]) -> [V3<Lanes<T, S>>; E] {
    let mut turned = [V3::of(s, s.turn(edges[0])); E];
    for (turned, edge) in turned.iter_mut().zip(edges).skip(1) {
        *turned = V3::of(s, s.turn(*edge));
    }
    turned
}

/// A value for each element of each batch, `filler` where there is none.
pub(super) fn pack<T: Scalar>(sources: &[Option<u32>], filler: f64, value: impl Fn(usize) -> f64) -> Vec<Pack<T>> {
    let of = |source: Option<u32>| source.map_or(filler, |element| value(element as usize));
    let batches = sources.chunks_exact(ROWS);
    batches.map(|batch| Pack(core::array::from_fn(|lane| T::from_f64(of(batch[lane]))))).collect()
}
