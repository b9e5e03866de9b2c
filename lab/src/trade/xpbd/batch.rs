//! Elements in batches that share no vertex: two times eight.

use bevy_cloth::physics::math::{Lanes, Oct, Pack, Padded, ROWS, Scalar, V3};

use super::Point;
use super::colouring::by_colour;
use super::twin::{Twin, pair, parted};

/// Elements of a batch.
const SIZE: usize = 2 * ROWS;

/// The vertices of elements of V vertices each.
#[derive(Clone, Debug)]
pub(super) struct Batches<const V: usize>(Vec<[[[u32; ROWS]; V]; 2]>);

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
            sources.resize(sources.len().next_multiple_of(SIZE), None);
        }
        let vertex = |source: Option<u32>, which: usize| {
            source.map_or(vertex_count as u32, |element| elements[element as usize][which])
        };
        let octet =
            |batch: &[Option<u32>]| core::array::from_fn(|which| core::array::from_fn(|i| vertex(batch[i], which)));
        let batches = sources.chunks_exact(SIZE).map(|batch| [octet(&batch[..ROWS]), octet(&batch[ROWS..])]);
        (Self(batches.collect()), sources)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Vertices 1… of each element relative to its vertex 0: where they have got to.
    #[inline(always)]
    pub fn edges<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        points: &[Point<T>],
    ) -> [V3<Twin<Lanes<T, S>>>; E] {
        self.differences(s, batch, points, now)
    }

    /// The same at the beginning of the substep.
    #[inline(always)]
    pub fn edges_before<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        points: &[Point<T>],
    ) -> [V3<Twin<Lanes<T, S>>>; E] {
        self.differences(s, batch, points, before)
    }

    /// How far those edges have changed in the substep.
    #[inline(always)]
    pub fn edge_moves<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        points: &[Point<T>],
    ) -> [V3<Twin<Lanes<T, S>>>; E] {
        self.differences(s, batch, points, moved)
    }

    #[inline(always)]
    fn differences<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        points: &[Point<T>],
        of: impl Fn(&Point<T>, &Point<T>) -> Padded<T>,
    ) -> [V3<Twin<Lanes<T, S>>>; E] {
        let [first, second] = &self.0[batch];
        let (a, b): ([_; E], [_; E]) = (gather(first, points, &of), gather(second, points, &of));
        let mut edges = [pair(V3::of(s, s.turn(a[0])), V3::of(s, s.turn(b[0]))); E];
        for i in 1..E {
            edges[i] = pair(V3::of(s, s.turn(a[i])), V3::of(s, s.turn(b[i])));
        }
        edges
    }

    /// Moves one vertex of each element on.
    #[inline(always)]
    pub fn shift<T: Scalar, S: Oct<T>>(
        &self,
        s: S,
        batch: usize,
        which: usize,
        moves: V3<Twin<Lanes<T, S>>>,
        points: &mut [Point<T>],
    ) {
        for (vertices, V3([x, y, z])) in self.0[batch].iter().zip(parted(moves)) {
            for (&vertex, moved) in vertices[which].iter().zip(s.turn_back([x.v, y.v, z.v])) {
                points[vertex as usize].moved += moved;
            }
        }
    }
}

#[inline(always)]
fn now<T: Scalar>(point: &Point<T>, origin: &Point<T>) -> Padded<T> {
    (point.at - origin.at) + (point.moved - origin.moved)
}

#[inline(always)]
fn before<T: Scalar>(point: &Point<T>, origin: &Point<T>) -> Padded<T> {
    point.at - origin.at
}

#[inline(always)]
fn moved<T: Scalar>(point: &Point<T>, origin: &Point<T>) -> Padded<T> {
    point.moved - origin.moved
}

#[inline(always)]
fn gather<T: Scalar, const V: usize, const E: usize>(
    vertices: &[[u32; ROWS]; V],
    points: &[Point<T>],
    of: &impl Fn(&Point<T>, &Point<T>) -> Padded<T>,
) -> [[Padded<T>; ROWS]; E] {
    let mut edges = [[Padded::zero(); ROWS]; E];
    for lane in 0..ROWS {
        let origin = &points[vertices[0][lane] as usize];
        for (i, edge) in edges.iter_mut().enumerate() {
            edge[lane] = of(&points[vertices[i + 1][lane] as usize], origin);
        }
    }
    edges
}

/// A value for each element of each batch, `filler` where there is none.
pub(super) fn pack<T: Scalar>(sources: &[Option<u32>], filler: f64, value: impl Fn(usize) -> f64) -> Vec<[Pack<T>; 2]> {
    let of = |source: Option<u32>| source.map_or(filler, |element| value(element as usize));
    let octet = |batch: &[Option<u32>]| Pack(core::array::from_fn(|i| T::from_f64(of(batch[i]))));
    sources.chunks_exact(SIZE).map(|batch| [octet(&batch[..ROWS]), octet(&batch[ROWS..])]).collect()
}
