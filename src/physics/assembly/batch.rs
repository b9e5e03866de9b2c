//! Elements in batches of [`ROWS`].

use core::ops::Range;

use super::implicit_step::Linearisation;
use super::{BlockPattern, Group, Part};
use crate::physics::math::{Lanes, M3, Oct, Padded, ROWS, RowKernel, Scalar, V3};

/// A kind of element.
pub(super) trait Elements<T: Scalar>: Sync {
    /// The batches of each part.
    fn batches(&self) -> &[PartBatches];
    /// Energy of the elements of a batch, J.
    fn energy<S: Oct<T>>(&self, s: S, batch: usize, x: &[Padded<f64>]) -> Lanes<T, S>;
    /// Adds forces, damping included, and of the weighted projected Hessian of a batch what is below the diagonal: the rest
    /// follows from it, see [`row_sums`](super::row_sums).
    fn assemble<S: Oct<T>>(&self, s: S, batch: usize, at: &Linearisation<T>, out: &mut Output<T>);
}

/// Energy of the elements of a part, J.
pub(super) fn energy<T: Scalar>(elements: &impl Elements<T>, part: usize, x: &[Padded<f64>]) -> f64 {
    T::dispatch(EnergyOf { elements, part, x })
}

/// Adds what the elements have to say about the rows of a part.
pub(super) fn assemble<T: Scalar>(elements: &impl Elements<T>, at: &Linearisation<T>, out: &mut Output<T>) {
    T::dispatch(Assemble { elements, at, out });
}

struct EnergyOf<'a, E> {
    elements: &'a E,
    part: usize,
    x: &'a [Padded<f64>],
}

impl<T: Scalar, E: Elements<T>> RowKernel<T> for EnergyOf<'_, E> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) -> f64 {
        let mut sum = 0.0;
        for batch in self.elements.batches()[self.part].own.clone() {
            sum += self.elements.energy(s, batch, self.x).store().sum();
        }
        sum
    }
}

struct Assemble<'a, 'b, E, T: Scalar> {
    elements: &'a E,
    at: &'a Linearisation<'a, T>,
    out: &'a mut Output<'b, T>,
}

impl<T: Scalar, E: Elements<T>> RowKernel<T> for Assemble<'_, '_, E, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        for batch in self.elements.batches()[self.out.part].all.clone() {
            self.elements.assemble(s, batch, self.at, self.out);
        }
    }
}

/// The rows of a part, which elements add to. What they add elsewhere is left out: they are assembled there again.
pub(super) struct Output<'a, T: Scalar> {
    part: usize,
    first_row: usize,
    first_group: usize,
    groups: &'a mut [Group<T>],
    forces: &'a mut [Padded<T>],
}

impl<'a, T: Scalar> Output<'a, T> {
    /// For a part, of which these are the blocks below the diagonal and the forces.
    pub fn new(part: &Part, groups: &'a mut [Group<T>], forces: &'a mut [Padded<T>]) -> Self {
        let (first_row, first_group) = (part.rows.start, part.groups.start);
        Self { part: part.index, first_row, first_group, groups, forces }
    }

    /// Adds the forces on one vertex of each element.
    #[inline(always)]
    pub fn add_forces<S: Oct<T>>(&mut self, s: S, vertices: [u32; ROWS], V3([x, y, z]): V3<Lanes<T, S>>) {
        let forces = s.turn_back([x.v, y.v, z.v]);
        for (vertex, force) in vertices.into_iter().zip(forces) {
            if let Some(sum) = self.forces.get_mut((vertex as usize).wrapping_sub(self.first_row)) {
                *sum += force;
            }
        }
    }

    /// Adds one block of each element.
    #[inline(always)]
    pub fn add_blocks<S: Oct<T>>(&mut self, s: S, slots: [u32; ROWS], block: &M3<Lanes<T, S>>) {
        let [[a, b, c], [d, e, f], [g, h, last]] = block.0;
        let first = s.transpose([a.v, b.v, c.v, d.v, e.v, f.v, g.v, h.v]);
        for ((slot, first), last) in slots.into_iter().zip(first).zip(last.store().0) {
            let slot = slot as usize;
            if let Some(group) = self.groups.get_mut((slot / ROWS).wrapping_sub(self.first_group)) {
                group.accumulate(s, slot % ROWS, first, last);
            }
        }
    }
}

/// The batches of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PartBatches {
    /// Of the elements whose last vertex is in it.
    own: Range<usize>,
    /// Of all elements that have a vertex in it.
    all: Range<usize>,
}

impl PartBatches {
    /// The batches of the elements whose last vertex is in the part.
    pub fn own(&self) -> Range<usize> {
        self.own.clone()
    }
}

/// How far apart in their order the elements of a batch are: neighbours would add to the same sums, one waiting for the other.
const APART: usize = 8;

/// No element.
pub(super) const FILLER: u32 = u32::MAX;

/// The vertices and matrix slots of elements of one kind, of V vertices and P = V (V−1)/2 pairs each.
#[derive(Clone, Debug)]
pub(super) struct Batches<const V: usize, const P: usize> {
    vertices: Vec<[u32; V]>,
    /// Slots of the pairs (1, 0), (2, 0), (2, 1), … of the vertices.
    slots: Vec<[u32; P]>,
    parts: Vec<PartBatches>,
}

impl<const V: usize, const P: usize> Batches<V, P> {
    /// Batches of these elements, and which of them stands at each place; [`FILLER`] where a batch is filled up with a copy,
    /// whose rest data must make it contribute nothing.
    /// They stand in the order of `rank`, by vertex: so what is near each other is worked on one after the other.
    pub fn new(elements: &[[u32; V]], pattern: &BlockPattern, rank: &[u32]) -> (Self, Vec<u32>) {
        let part_of = |vertex: u32| pattern.parts().partition_point(|part| part.rows.end <= vertex as usize);
        let mut in_part: Vec<[Vec<usize>; 2]> = pattern.parts().iter().map(|_| Default::default()).collect();
        for (element, vertices) in elements.iter().enumerate() {
            let owner = vertices.map(part_of).into_iter().max().unwrap_or(0);
            let mut others = vertices.map(part_of);
            others.sort_unstable();
            for (i, &part) in others.iter().enumerate() {
                if i == 0 || others[i - 1] != part {
                    in_part[part][usize::from(part != owner)].push(element);
                }
            }
        }
        let mut batches = Self { vertices: Vec::new(), slots: Vec::new(), parts: Vec::new() };
        let mut sources = Vec::new();
        for groups in in_part {
            let start = sources.len() / ROWS;
            let [own, _] = groups.map(|mut group| {
                group.sort_by_key(|&element| elements[element].into_iter().map(|vertex| rank[vertex as usize]).max());
                for run in group.chunks(ROWS * APART) {
                    let length = run.len().div_ceil(ROWS);
                    for place in (0..length).flat_map(|batch| (0..ROWS).map(move |lane| lane * length + batch)) {
                        sources.push(run.get(place).map_or(FILLER, |&element| element as u32));
                        batches.vertices.push(elements[*run.get(place).unwrap_or(&run[0])]);
                    }
                }
                start..sources.len() / ROWS
            });
            batches.parts.push(PartBatches { own, all: start..sources.len() / ROWS });
        }
        batches.vertices.shrink_to_fit();
        sources.shrink_to_fit();
        batches.slots = batches.vertices.iter().map(|&vertices| pair_slots(vertices, pattern)).collect();
        (batches, sources)
    }

    /// See [`Elements::batches`].
    pub fn parts(&self) -> &[PartBatches] {
        &self.parts
    }

    /// One vertex of each element of a batch.
    #[inline(always)]
    pub fn vertices(&self, batch: usize, which: usize) -> [u32; ROWS] {
        column(&self.vertices, batch, which)
    }

    /// The slot of one pair of each element of a batch.
    #[inline(always)]
    pub fn slots(&self, batch: usize, pair: usize) -> [u32; ROWS] {
        column(&self.slots, batch, pair)
    }

    /// Vertices 1… of each element relative to its vertex 0, in f64: far from the origin, and for short edges, f32 positions
    /// would not do.
    #[inline(always)]
    pub fn edges<S: Oct<f64>, const E: usize>(&self, s: S, batch: usize, x: &[Padded<f64>]) -> [V3<Lanes<f64, S>>; E] {
        self.differences(s, batch, x)
    }

    /// How much each of those edges changes when the vertices move so far.
    #[inline(always)]
    pub fn edge_moves<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        moved: &[Padded<T>],
    ) -> [V3<Lanes<T, S>>; E] {
        self.differences(s, batch, moved)
    }

    #[inline(always)]
    fn differences<T: Scalar, S: Oct<T>, const E: usize>(
        &self,
        s: S,
        batch: usize,
        x: &[Padded<T>],
    ) -> [V3<Lanes<T, S>>; E] {
        let origin = V3::of(s, s.turn(gather(x, self.vertices(batch, 0))));
        let mut differences = [origin; E];
        for (i, difference) in differences.iter_mut().enumerate() {
            *difference = V3::of(s, s.turn(gather(x, self.vertices(batch, i + 1)))) - origin;
        }
        differences
    }
}

/// One number of each element of a batch.
#[inline(always)]
fn column<const N: usize>(values: &[[u32; N]], batch: usize, which: usize) -> [u32; ROWS] {
    let mut column = [0; ROWS];
    for (value, element) in column.iter_mut().zip(&values[batch * ROWS..][..ROWS]) {
        *value = element[which];
    }
    column
}

#[inline(always)]
fn gather<T: Scalar>(x: &[Padded<T>], vertices: [u32; ROWS]) -> [Padded<T>; ROWS] {
    let mut gathered = [Padded::zero(); ROWS];
    for (point, vertex) in gathered.iter_mut().zip(vertices) {
        *point = x[vertex as usize];
    }
    gathered
}

/// Slots of the pairs of an element's vertices.
fn pair_slots<const V: usize, const P: usize>(vertices: [u32; V], pattern: &BlockPattern) -> [u32; P] {
    let mut pairs = (1..V).flat_map(|i| (0..i).map(move |j| (vertices[i], vertices[j])));
    core::array::from_fn(|_| {
        let (i, j) = pairs.next().expect("P is the number of pairs");
        pattern.slot(i.max(j), i.min(j)).expect("the pattern is made of the elements")
    })
}
