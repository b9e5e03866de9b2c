//! Elements in batches of one per lane.

use core::ops::Range;

use bevy::math::DVec3;

use super::implicit_step::Linearisation;
use super::{BlockPattern, Group, Part};
use crate::physics::math::{Flat, Kernel, Padded, ROWS, Real, Scalar, V3, dispatch};

/// A kind of element.
pub(super) trait Elements: Sync {
    type Lanes: Real;
    /// The batches of each part.
    fn batches(&self) -> &[PartBatches];
    /// Energy of a batch, lane by lane, J.
    fn energy(&self, batch: usize, x: &[DVec3]) -> Self::Lanes;
    /// Adds forces, damping included, and of the weighted projected Hessian of a batch what is below the diagonal: the rest
    /// follows from it, see [`row_sums`](super::row_sums).
    fn assemble(&self, batch: usize, at: &Linearisation<ScalarOf<Self>>, out: &mut Output<ScalarOf<Self>>);
}

/// The number type of the matrix.
type ScalarOf<E> = <<E as Elements>::Lanes as Real>::Scalar;

/// Energy of the elements of a part, J.
pub(super) fn energy<E: Elements>(elements: &E, part: usize, x: &[DVec3]) -> f64 {
    dispatch(EnergyOf { elements, part, x })
}

/// Adds what the elements have to say about the rows of a part.
pub(super) fn assemble<E: Elements>(elements: &E, at: &Linearisation<ScalarOf<E>>, out: &mut Output<ScalarOf<E>>) {
    dispatch(Assemble { elements, at, out });
}

struct EnergyOf<'a, E> {
    elements: &'a E,
    part: usize,
    x: &'a [DVec3],
}

impl<E: Elements> Kernel for EnergyOf<'_, E> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let mut sum = 0.0;
        for batch in self.elements.batches()[self.part].own.clone() {
            sum += self.elements.energy(batch, self.x).sum_lanes();
        }
        sum
    }
}

struct Assemble<'a, 'b, E: Elements> {
    elements: &'a E,
    at: &'a Linearisation<'a, ScalarOf<E>>,
    out: &'a mut Output<'b, ScalarOf<E>>,
}

impl<E: Elements> Kernel for Assemble<'_, '_, E> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for batch in self.elements.batches()[self.out.part].all.clone() {
            self.elements.assemble(batch, self.at, self.out);
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

    /// Adds to the force on a vertex.
    #[inline(always)]
    pub fn add_force(&mut self, vertex: u32, force: Padded<T>) {
        if let Some(sum) = self.forces.get_mut((vertex as usize).wrapping_sub(self.first_row)) {
            *sum += force;
        }
    }

    /// Adds to the block of a slot.
    #[inline(always)]
    pub fn add(&mut self, slot: usize, block: Flat<T>) {
        if let Some(group) = self.groups.get_mut((slot / ROWS).wrapping_sub(self.first_group)) {
            group.accumulate(slot % ROWS, block);
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

/// No element.
pub(super) const FILLER: u32 = u32::MAX;

/// The vertices and matrix slots of elements of one kind, of V vertices and P = V (V−1)/2 pairs each.
#[derive(Clone, Debug)]
pub(super) struct Batches<const V: usize, const P: usize> {
    vertices: Vec<[u32; V]>,
    /// Slots of the pairs (1, 0), (2, 0), (2, 1), … of the vertices in ascending order.
    slots: Vec<[u32; P]>,
    parts: Vec<PartBatches>,
}

impl<const V: usize, const P: usize> Batches<V, P> {
    /// Batches of these elements, and which of them stands at each place; [`FILLER`] where a batch is filled up with a copy,
    /// whose rest data must make it contribute nothing.
    /// They stand in the order of `rank`, by vertex: so what is near each other is worked on one after the other.
    pub fn new(elements: &[[u32; V]], lanes: usize, pattern: &BlockPattern, rank: &[u32]) -> (Self, Vec<u32>) {
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
            let start = sources.len() / lanes;
            let [own, _] = groups.map(|mut group| {
                group.sort_by_key(|&element| elements[element].into_iter().map(|vertex| rank[vertex as usize]).max());
                sources.extend(group.iter().map(|&element| element as u32));
                batches.vertices.extend(group.iter().map(|&element| elements[element]));
                while !sources.len().is_multiple_of(lanes) {
                    sources.push(FILLER);
                    batches.vertices.extend(group.last().map(|&element| elements[element]));
                }
                start..sources.len() / lanes
            });
            batches.parts.push(PartBatches { own, all: start..sources.len() / lanes });
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

    /// The vertices of the elements of a batch.
    #[inline(always)]
    pub fn vertices<L: Real>(&self, batch: usize) -> &[[u32; V]] {
        &self.vertices[batch * L::LANES..][..L::LANES]
    }

    /// The slots of the elements of a batch.
    #[inline(always)]
    pub fn slots<L: Real>(&self, batch: usize) -> &[[u32; P]] {
        &self.slots[batch * L::LANES..][..L::LANES]
    }

    /// Vertices 1… of each element relative to its vertex 0, coordinate by coordinate. Differences are taken in f64: far from
    /// the origin, and for short edges, f32 positions would not do.
    #[inline(always)]
    pub fn edges<L: Real, const E: usize>(&self, batch: usize, x: &[DVec3]) -> [V3<L>; E] {
        let vertices = self.vertices::<L>(batch);
        let mut edges = [V3::zero(); E];
        for (i, edge) in edges.iter_mut().enumerate() {
            *edge = V3(L::from_rows(
                #[inline(always)]
                |lane| {
                    let v = &vertices[lane];
                    rounded::<L>(x[v[i + 1] as usize] - x[v[0] as usize])
                },
            ));
        }
        edges
    }

    /// How much each of those edges changes when the vertices move so far.
    #[inline(always)]
    pub fn edge_moves<L: Real, const E: usize>(&self, batch: usize, moved: &[Padded<L::Scalar>]) -> [V3<L>; E] {
        let vertices = self.vertices::<L>(batch);
        let mut edges = [V3::zero(); E];
        for (i, edge) in edges.iter_mut().enumerate() {
            *edge = V3(L::from_rows(
                #[inline(always)]
                |lane| {
                    let v = &vertices[lane];
                    (moved[v[i + 1] as usize] - moved[v[0] as usize]).v3().0
                },
            ));
        }
        edges
    }
}

#[inline(always)]
fn rounded<L: Real>(v: DVec3) -> [L::Scalar; 3] {
    [L::Scalar::from_f64(v.x), L::Scalar::from_f64(v.y), L::Scalar::from_f64(v.z)]
}

/// Slots of the pairs of an element's vertices.
fn pair_slots<const V: usize, const P: usize>(mut vertices: [u32; V], pattern: &BlockPattern) -> [u32; P] {
    vertices.sort_unstable();
    let mut pairs = (1..V).flat_map(|i| (0..i).map(move |j| (i, j)));
    core::array::from_fn(|_| {
        let (i, j) = pairs.next().expect("P is the number of pairs");
        pattern.slot(vertices[i], vertices[j]).expect("the pattern is made of the elements")
    })
}

/// A value for each element of each batch, one per lane; fillers take `filler`.
pub(super) fn pack<L: Real>(sources: &[u32], filler: f64, value: impl Fn(usize) -> f64) -> Vec<L> {
    let of = |source: u32| if source == FILLER { filler } else { value(source as usize) };
    let batches = sources.chunks_exact(L::LANES);
    batches.map(|batch| L::from_lanes(|lane| L::Scalar::from_f64(of(batch[lane])))).collect()
}
