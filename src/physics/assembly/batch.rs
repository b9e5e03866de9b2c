//! Elements in batches of one per lane.

use bevy::math::DVec3;

use super::{BlockCsr, BlockPattern};
use crate::physics::math::{M3, Real, Scalar, V3};

/// Which vertices and matrix slots the elements of one kind have, V vertices each.
///
/// The last batch is filled up with copies of the last element; the rest data of a copy must make it contribute nothing.
#[derive(Clone, Debug)]
pub(super) struct Batches<const V: usize> {
    vertices: Vec<[u32; V]>,
    slots: Vec<[[u32; V]; V]>,
    lanes: usize,
}

impl<const V: usize> Batches<V> {
    pub fn new(mut vertices: Vec<[u32; V]>, lanes: usize, pattern: &BlockPattern) -> Self {
        fill_up(&mut vertices, lanes);
        let slots = vertices.iter().map(|&v| pattern.element_slots(v)).collect();
        Self { vertices, slots, lanes }
    }

    /// Number of batches.
    pub fn len(&self) -> usize {
        self.vertices.len() / self.lanes
    }

    /// Vertices 1… of each element relative to its vertex 0. Differences are taken in f64: far from the origin, and for
    /// short edges, f32 positions would not do.
    #[inline(always)]
    pub fn edges<L: Real, const E: usize>(&self, batch: usize, x: &[DVec3]) -> [V3<L>; E] {
        let elements = &self.vertices[batch * L::LANES..][..L::LANES];
        core::array::from_fn(|edge| {
            V3(core::array::from_fn(|axis| {
                L::from_lanes(|lane| {
                    let v = &elements[lane];
                    L::Scalar::from_f64(x[v[edge + 1] as usize][axis] - x[v[0] as usize][axis])
                })
            }))
        })
    }

    /// How much each of those edges changes from the points `from` to the points `to`.
    #[inline(always)]
    pub fn edge_moves<L: Real, const E: usize>(&self, batch: usize, from: &[DVec3], to: &[DVec3]) -> [V3<L>; E] {
        let elements = &self.vertices[batch * L::LANES..][..L::LANES];
        core::array::from_fn(|edge| {
            V3(core::array::from_fn(|axis| {
                L::from_lanes(|lane| {
                    let [a, b] = [0, edge + 1].map(|i| elements[lane][i] as usize);
                    L::Scalar::from_f64((to[b][axis] - to[a][axis]) - (from[b][axis] - from[a][axis]))
                })
            }))
        })
    }

    /// Lane by lane a function of an element's index and its edges `x1−x0`, `x2−x0` in f64.
    #[inline(always)]
    pub fn map<L: Real>(&self, batch: usize, x: &[DVec3], f: impl Fn(usize, [V3<f64>; 2]) -> f64) -> L {
        L::from_lanes(|lane| {
            let element = batch * L::LANES + lane;
            let v = &self.vertices[element];
            let edge = |i: usize| V3((x[v[i] as usize] - x[v[0] as usize]).to_array());
            L::Scalar::from_f64(f(element, [edge(1), edge(2)]))
        })
    }

    /// Adds to the forces on the vertices of each element.
    #[inline(always)]
    pub fn scatter_forces<L: Real>(&self, batch: usize, forces: [V3<L>; V], out: &mut [V3<L::Scalar>]) {
        let elements = &self.vertices[batch * L::LANES..][..L::LANES];
        for (lane, vertices) in elements.iter().enumerate() {
            for (vertex, force) in vertices.iter().zip(&forces) {
                out[*vertex as usize] += force.lane(lane);
            }
        }
    }

    /// Adds the block (i, j) of each element to the matrix.
    #[inline(always)]
    pub fn scatter_block<L: Real>(
        &self,
        batch: usize,
        (i, j): (usize, usize),
        block: &M3<L>,
        out: &mut BlockCsr<L::Scalar>,
    ) {
        let slots = &self.slots[batch * L::LANES..][..L::LANES];
        for (lane, slots) in slots.iter().enumerate() {
            out.blocks[slots[i][j] as usize] += block.lane(lane);
        }
    }
}

/// Repeats the last value until the last batch is full.
pub(super) fn fill_up<T: Clone>(values: &mut Vec<T>, lanes: usize) {
    if let Some(filler) = values.last().cloned() {
        values.resize(values.len().next_multiple_of(lanes), filler);
    }
}

/// Packs one value per element into lanes; missing elements of the last batch take `filler`.
pub(super) fn pack<L: Real>(values: &[f64], batch: usize, filler: f64) -> L {
    L::from_lanes(|lane| L::Scalar::from_f64(values.get(batch * L::LANES + lane).copied().unwrap_or(filler)))
}
