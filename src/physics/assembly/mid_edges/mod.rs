//! The turns of the mid-edge normals of a cloth, and the moments that follow.
//!
//! A turn is no unknown of the linear system: before the forces are linearised, a few damped Jacobi sweeps bring the turns from where
//! they were in the step before to the minimum of the energy, and the moments found there take the place of those of plain hinges.
//!
//! Edges stand in packs of [`ROWS`], hinges in the order of their batches, part by part, then the edges without hinge.

mod kernels;
mod topology;

use core::ops::Range;

use self::kernels::{EnergyOf, Packs, Sweep};
pub(super) use self::kernels::{Phi, turned};
use self::topology::{Edges, Side};
use super::batch::FILLER;
use super::parts::{Part, for_parts};
use crate::physics::energy::mid_edge::{Rows, lumped};
use crate::physics::material::Fabric;
use crate::physics::math::{Pack, ROWS, Scalar};
use crate::physics::mesh::RestShape;

/// Damping of the sweeps: below 2/3 they converge on any mesh, as P of a triangle is at most three times its diagonal.
const RELAXATION: f64 = 0.6;
/// Sweeps before a linearisation.
const SWEEPS: u32 = 2;
/// Sweeps when the turns of the step before say nothing.
const SWEEPS_FROM_NOTHING: u32 = 60;

/// The edges of a cloth, their turns and their moments.
pub(super) struct MidEdges<T> {
    edges: Edges,
    /// Packs by part of the cloth; those without hinge stand at the end of the last, so that a cloth in one part stays on its thread.
    parts: Vec<Part>,
    /// By pack: the other edges of the first triangle and of the second.
    others: Vec<[[Side; ROWS]; 4]>,
    rows: Vec<Rows<Pack<T>>>,
    /// By pack: share of the residual that a sweep takes away, 1/(N·m); zero where the turn is held.
    relaxation: Vec<Pack<T>>,
    /// By pack: share of the first triangle in Θ.
    shares: Vec<Pack<T>>,
    /// By triangle: its vertices.
    triangles: Vec<[u32; 3]>,
    /// Vertices held when those were made.
    held: Vec<bool>,
    /// By pack: with Θ as damping has it, see [`Hinges::prepare`](super::hinges::Hinges::prepare).
    phi: Vec<Phi<T>>,
    next_phi: Vec<Phi<T>>,
    /// By pack: ∂E/∂θ, N·m.
    moments: Vec<Pack<T>>,
    /// By batch of hinges: the edge at each place.
    places: Vec<[u32; ROWS]>,
}

impl<T: Scalar> MidEdges<T> {
    /// The edges of a cloth. `own` are the batches of each part that are its own, and `sources` the hinge at each place.
    pub fn new(shape: &RestShape, inner: &[u32], own: impl Iterator<Item = Range<usize>>, sources: &[u32]) -> Self {
        let (mut parts, mut places) = (Vec::new(), Vec::new());
        for (index, batches) in own.enumerate() {
            let start = places.len() / ROWS;
            places.extend_from_slice(&sources[batches.start * ROWS..batches.end * ROWS]);
            parts.push(packs(index, start..places.len() / ROWS));
        }
        let edges = Edges::new(shape, &places);
        let count = edges.count() / ROWS;
        if let Some(last) = parts.last_mut() {
            last.rows.end = count;
        }

        let mut edge_of = vec![0; shape.hinges.len()];
        for (edge, &hinge) in places.iter().enumerate().filter(|(_, hinge)| **hinge != FILLER) {
            edge_of[hinge as usize] = edge as u32;
        }
        let edge_of = |&hinge: &u32| edge_of.get(hinge as usize).copied().unwrap_or(edges.count() as u32 - 1);
        let others = |pack: usize| {
            let lanes: [_; ROWS] = core::array::from_fn(|lane| edges.others(pack * ROWS + lane));
            core::array::from_fn(|which| lanes.map(|others| others[which]))
        };
        let zero = Pack([T::zero(); ROWS]);
        Self {
            others: (0..count).map(others).collect(),
            places: sources.chunks_exact(ROWS).map(|batch| core::array::from_fn(|i| edge_of(&batch[i]))).collect(),
            triangles: shape.triangles.iter().map(|t| t.vertices.map(|v| inner[v as usize])).collect(),
            rows: vec![Rows { first: [zero; 3], second: [zero; 3] }; count],
            relaxation: vec![zero; count],
            shares: vec![zero; count],
            held: vec![false; shape.vertex_count()],
            phi: vec![[zero; 2]; count],
            next_phi: vec![[zero; 2]; count],
            moments: vec![zero; count],
            edges,
            parts,
        }
    }

    /// Takes over what the edges measure at rest, and the material.
    pub fn measure(&mut self, shape: &RestShape, fabric: &Fabric) {
        let Self { edges, rows, .. } = self;
        edges.for_rows(shape, fabric, |edge, second, values| {
            let rows = &mut rows[edge / ROWS];
            let packs = if second { &mut rows.second } else { &mut rows.first };
            for (pack, value) in packs.iter_mut().zip(values) {
                pack.0[edge % ROWS] = T::from_f64(value);
            }
        });
        self.clamp();
    }

    /// Turns every angle round.
    pub fn mirror(&mut self) {
        for value in self.phi.as_flattened_mut().iter_mut().flat_map(|pack| &mut pack.0) {
            *value = -*value;
        }
    }

    /// Clamps every triangle that is held by all its vertices: it does not bend, and the cloth leaves it at its tangent. Says
    /// whether that is a change.
    pub fn hold(&mut self, held: &[bool]) -> bool {
        let changed = self.held != held;
        if changed {
            self.held.copy_from_slice(held);
            self.clamp();
        }
        changed
    }

    /// The vertices that [`hold`](Self::hold) was last told.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// φ of all packs, one number after another.
    pub fn turns(&self) -> Vec<T> {
        self.phi.iter().flatten().flat_map(|pack| pack.0).collect()
    }

    /// Puts them back, after [`hold`](Self::hold).
    pub fn set_turns(&mut self, turns: &[T]) {
        for (pack, turns) in self.phi.iter_mut().flatten().zip(turns.chunks_exact(ROWS)) {
            pack.0.copy_from_slice(turns);
        }
    }

    fn clamp(&mut self) {
        for edge in 0..self.edges.count() {
            let Self { edges, triangles, held, .. } = &*self;
            let fixed = |triangle: u32| triangles[triangle as usize].iter().all(|&v| held[v as usize]);
            let beside = edges.triangles(edge);
            let clamped = beside.map(|triangle| triangle.is_some_and(fixed));
            let share = match clamped {
                [true, false] => 0.0,
                [false, true] => 1.0,
                _ => 0.5,
            };
            let Rows { first, second } = self.rows(edge);
            let turns = beside[0].is_some() && clamped == [false; 2] && first[0] + second[0] > 0.0;
            let relaxation = if turns { RELAXATION / (first[0] + second[0]) } else { 0.0 };
            self.shares[edge / ROWS].0[edge % ROWS] = T::from_f64(share);
            self.relaxation[edge / ROWS].0[edge % ROWS] = T::from_f64(relaxation);
        }
        // What is clamped has no turn.
        for (pack, [first, second]) in self.phi.iter_mut().enumerate() {
            for lane in 0..ROWS {
                if self.relaxation[pack].0[lane] == T::zero() {
                    let (deviation, share) = (first.0[lane] + second.0[lane], self.shares[pack].0[lane]);
                    first.0[lane] = share * deviation;
                    second.0[lane] = deviation - first.0[lane];
                }
            }
        }
    }

    fn rows(&self, edge: usize) -> Rows<f64> {
        let Rows { first, second } = &self.rows[edge / ROWS];
        let entry = |pack: &Pack<T>| pack.0[edge % ROWS].to_f64();
        Rows { first: first.each_ref().map(entry), second: second.each_ref().map(entry) }
    }

    /// What bounds the part of each hinge of a batch in the Hessian from above, N·m.
    pub fn bounds(&self, batch: usize) -> Pack<T> {
        let share = |edge: usize, second: bool| {
            let share = self.shares[edge / ROWS].0[edge % ROWS].to_f64();
            if second { 1.0 - share } else { share }
        };
        Pack(self.places[batch].map(|edge| {
            let edge = edge as usize;
            let others = self.edges.others(edge).map(|other| {
                let bends = self.edges.hinge(other.edge()).is_some();
                if bends { share(other.edge(), other.is_second()) } else { 0.0 }
            });
            T::from_f64(lumped(&self.rows(edge), [share(edge, false), share(edge, true)], others))
        }))
    }

    /// Brings the turns towards the minimum of the energy for the angles that `angles` writes, for one part of the cloth
    /// at a time, and finds the moments.
    pub fn relax(&mut self, angles: &impl Angles<T>) {
        self.sweep(SWEEPS, angles);
    }

    /// Brings the turns to the minimum, wherever they were.
    pub fn settle(&mut self, angles: &impl Angles<T>) {
        self.phi.fill([Pack([T::zero(); ROWS]); 2]);
        self.sweep(SWEEPS_FROM_NOTHING, angles);
    }

    fn sweep(&mut self, sweeps: u32, angles: &impl Angles<T>) {
        let Self { edges, parts, rows, others, relaxation, shares, phi, next_phi, moments, .. } = self;
        find_phi(parts, edges.hinge_count / ROWS, shares, phi, next_phi, angles);
        core::mem::swap(phi, next_phi);
        for _ in 0..sweeps {
            let packs = Packs { rows, others, phi };
            for_parts(parts, (&mut next_phi[..], &mut moments[..]), &|part: &Part, (phi, moments)| {
                T::dispatch(Sweep { packs, relaxation, shares, first: part.rows.start, phi, moments });
            });
            core::mem::swap(phi, next_phi);
        }
    }

    /// Energy for the turns there are and other angles, J.
    pub fn energy(&mut self, angles: &impl Angles<T>) -> f64 {
        let mut phi = core::mem::take(&mut self.next_phi);
        let energy = self.energy_in(&mut phi, angles);
        self.next_phi = phi;
        energy
    }

    /// The same, for those who may not change anything.
    pub fn energy_at(&self, angles: &impl Angles<T>) -> f64 {
        self.energy_in(&mut self.phi.clone(), angles)
    }

    fn energy_in(&self, phi: &mut [Phi<T>], angles: &impl Angles<T>) -> f64 {
        let Self { parts, rows, others, .. } = self;
        find_phi(parts, self.edges.hinge_count / ROWS, &self.shares, &self.phi, phi, angles);
        let packs = Packs { rows, others, phi };
        for_parts(parts, (), &|part: &Part, ()| T::dispatch(EnergyOf { packs, range: part.rows.clone() }))
    }

    /// ∂E/∂θ of each hinge of a batch, N·m.
    #[inline(always)]
    pub fn moments(&self, batch: usize) -> Pack<T> {
        let mut moments = [T::zero(); ROWS];
        for (moment, &edge) in moments.iter_mut().zip(&self.places[batch]) {
            *moment = self.moments[edge as usize / ROWS].0[edge as usize % ROWS];
        }
        Pack(moments)
    }
}

/// A part of packs.
fn packs(index: usize, range: Range<usize>) -> Part {
    Part { index, rows: range, slices: 0..0, groups: 0..0, incoming: 0..0 }
}

/// Writes φ of the edges of a part, for other angles and the turns of the φ given, with the shares of the first triangles.
pub(super) trait Angles<T>: Fn(usize, &[Pack<T>], &[Phi<T>], &mut [Phi<T>]) + Sync {}

impl<T, F: Fn(usize, &[Pack<T>], &[Phi<T>], &mut [Phi<T>]) + Sync> Angles<T> for F {}

/// φ for other angles and the same turns. Packs from `hinges` on are edges without hinge, and have no angle.
fn find_phi<T: Scalar>(
    parts: &[Part],
    hinges: usize,
    shares: &[Pack<T>],
    phi: &[Phi<T>],
    next: &mut [Phi<T>],
    angles: &impl Angles<T>,
) {
    for_parts(parts, next, &|part: &Part, next| {
        let bent = part.rows.start..part.rows.end.min(hinges);
        let (next, rest) = next.split_at_mut(bent.len());
        angles(part.index, &shares[bent.clone()], &phi[bent.clone()], next);
        rest.copy_from_slice(&phi[bent.end..part.rows.end]);
    });
}
