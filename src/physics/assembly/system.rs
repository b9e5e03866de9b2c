//! A and b of one implicit step.

use std::sync::Arc;

use bevy::math::DVec3;

use super::batch::Output;
use super::bending_hessian::BendingHessian;
use super::hinges::Hinges;
use super::implicit_step::{ImplicitStep, Linearization, Places};
use super::ordering::along;
use super::parts::{ByGroup, BySlice, Merge, Part, Split, for_parts};
use super::row_sums::SubtractRows;
use super::stencils;
use super::triangles::Triangles;
use super::{BlockEll, BlockPattern, Group, Ordering, Slicing};
use crate::physics::material::Fabric;
use crate::physics::math::{M3, Pack, Padded, ROWS, Scalar};
use crate::physics::mesh::RestShape;
use crate::physics::terms::{AirDrag, Gravity, Inertia, Row, Substep, Term, Trial};

/// Elastic energy by term, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElasticEnergy {
    /// Stretch and shear.
    pub membrane: f64,
    /// Bending.
    pub bending: f64,
}

impl ElasticEnergy {
    /// Sum of the terms, J.
    pub fn total(&self) -> f64 {
        self.membrane + self.bending
    }
}

/// Rows that terms of single vertices are asked for at a time: few enough for the first cache.
const CHUNK: usize = 64;

/// The terms of a cloth but contact, which the step keeps: it solves again for it.
struct Terms<T: Scalar> {
    membrane: Triangles<T>,
    bending: Hinges<T>,
    others: Vec<Box<dyn Term<T>>>,
}

impl<T: Scalar> Terms<T> {
    fn each(&self) -> impl Iterator<Item = &dyn Term<T>> {
        let elastic: [&dyn Term<T>; 2] = [&self.membrane, &self.bending];
        elastic.into_iter().chain(self.others.iter().map(|term| &**term))
    }

    fn each_mut(&mut self) -> impl Iterator<Item = &mut dyn Term<T>> {
        let elastic: [&mut dyn Term<T>; 2] = [&mut self.membrane, &mut self.bending];
        elastic.into_iter().chain(self.others.iter_mut().map(|term| &mut **term as &mut dyn Term<T>))
    }

    /// What single vertices have in A and b, from row `first` on.
    fn rows<'a>(&self, step: &ImplicitStep, masses: &[f64], first: usize, rows: &'a mut [Row]) -> &'a [Row] {
        rows.fill(Row::default());
        self.each().for_each(|term| term.add_rows(step, masses, first, rows));
        rows
    }
}

/// The linear system of a cloth: terms, and the storage of A and b. All vertices are numbered as its ordering says.
pub struct System<T: Scalar> {
    terms: Terms<T>,
    bending_hessian: BendingHessian<T>,
    /// x, where the cloth is to be linearized or measured, m.
    points: Vec<Padded<f64>>,
    /// x relative to `middle`, see [`Places`], m.
    local: Vec<Padded<T>>,
    /// A vertex in the middle of the longest way through the cloth.
    middle: usize,
    /// x − q, see [`Linearization`].
    moved: Vec<Padded<T>>,
    /// A.
    pub matrix: BlockEll<T>,
    /// b, kg·m.
    pub rhs: Vec<Padded<T>>,
}

impl<T: Scalar> System<T> {
    /// The system of a cloth; the pattern of A and the slot of each element's blocks are found here, once.
    pub fn new(shape: &RestShape, fabric: &Fabric, ordering: &Ordering) -> Self {
        let inner = &ordering.inner;
        let triangles: Vec<_> = shape.triangles.iter().map(|t| t.vertices.map(|v| inner[v as usize])).collect();
        let hinges: Vec<_> = shape.bending_hinges().iter().map(|h| h.vertices.map(|v| inner[v as usize])).collect();
        let mut rank = vec![0; shape.vertex_count()];
        let along = along(&shape.positions);
        for (place, &vertex) in along.iter().enumerate() {
            rank[inner[vertex as usize] as usize] = place as u32;
        }
        let pattern = BlockPattern::new(
            shape.vertex_count(),
            &ordering.part_starts,
            Slicing::Independent,
            triangles.iter().map(|vertices| &vertices[..]),
            hinges.iter().map(|vertices| &vertices[..]),
        );
        let zeros = vec![Padded::zero(); shape.vertex_count()];
        let bending = Hinges::new(shape, fabric, inner, &rank, &pattern);
        Self {
            bending_hessian: BendingHessian::new(&bending, &pattern),
            terms: Terms {
                membrane: Triangles::new(shape, fabric, inner, &rank, &pattern),
                bending,
                others: vec![Box::new(Inertia), Box::new(Gravity), Box::new(AirDrag::new(fabric))],
            },
            points: vec![Padded::zero(); shape.vertex_count()],
            local: zeros.clone(),
            middle: along.get(along.len() / 2).map_or(0, |&vertex| inner[vertex as usize] as usize),
            moved: zeros.clone(),
            matrix: BlockEll::zero(Arc::new(pattern)),
            rhs: zeros,
        }
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, shape: &RestShape, fabric: &Fabric) {
        self.measure_hinges(shape, fabric);
        self.terms.each_mut().for_each(|term| term.set_fabric(fabric));
    }

    /// Takes over a shape of the same elements that measure otherwise.
    pub fn measure(&mut self, shape: &RestShape, fabric: &Fabric, ordering: &Ordering) {
        self.terms.membrane.measure(shape, &ordering.inner);
        self.measure_hinges(shape, fabric);
    }

    fn measure_hinges(&mut self, shape: &RestShape, fabric: &Fabric) {
        self.terms.bending.measure(shape, fabric);
        self.bending_hessian.measure(&self.terms.bending, self.matrix.pattern());
    }

    /// Says that the cloth was mirrored.
    pub fn mirror(&mut self) {
        self.terms.bending.mirror();
    }

    /// All terms but contact.
    pub(crate) fn terms(&mut self) -> impl Iterator<Item = &mut dyn Term<T>> {
        self.terms.each_mut()
    }

    /// Adds a term.
    #[cfg(test)]
    pub(crate) fn register(&mut self, term: Box<dyn Term<T>>) {
        self.terms.others.push(term);
    }

    /// Sums what `of` says of the terms at `x`.
    fn sum(&mut self, x: &[DVec3], mut of: impl FnMut(&mut dyn Term<T>, &Trial<T>) -> f64) -> f64 {
        let Self { terms, points, local, middle, matrix, .. } = self;
        let parts = matrix.pattern().parts();
        place(parts, x, *middle, points, local);
        let trial = Trial { places: Places { x: points, local }, parts };
        terms.each_mut().map(|term| of(term, &trial)).sum()
    }

    /// Potential at `x` that depends on positions alone, J.
    pub(crate) fn stored(&mut self, x: &[DVec3]) -> f64 {
        self.sum(x, |term, trial| term.stored(trial))
    }

    /// The same. A term that has more than this forgets the hidden state that it has it by, and is asked again.
    pub(crate) fn stored_within(&mut self, limit: f64, x: &[DVec3]) -> f64 {
        self.sum(x, |term, trial| {
            let potential = term.stored(trial);
            if potential <= limit {
                return potential;
            }
            term.settle(trial);
            term.stored(trial)
        })
    }

    /// Potential at `x` that depends on the substep too, J.
    pub(crate) fn driven(&mut self, substep: &Substep, x: &[DVec3]) -> f64 {
        let Self { terms, matrix, .. } = self;
        let parts = matrix.pattern().parts();
        terms.each_mut().map(|term| term.driven(substep, x, parts)).sum()
    }

    /// Elastic energy at `x`.
    pub fn energy(&self, x: &[DVec3]) -> ElasticEnergy {
        let (mut points, mut local) = (self.points.clone(), self.local.clone());
        let parts = self.matrix.pattern().parts();
        place(parts, x, self.middle, &mut points, &mut local);
        let at = Places { x: &points, local: &local };
        let Terms { membrane, bending, .. } = &self.terms;
        ElasticEnergy { membrane: membrane.energy_at(parts, at), bending: bending.total_energy_at(parts, at) }
    }

    /// Says which vertices are held, so that what is clamped does not bend. (That they do not move is said by
    /// [`Constraints`](super::Constraints).)
    pub fn hold(&mut self, held: &[bool]) {
        if self.terms.bending.hold(held) {
            self.bending_hessian.measure(&self.terms.bending, self.matrix.pattern());
        }
    }

    /// Says that the cloth is at `x` now, whatever was before.
    pub fn settle(&mut self, x: &[DVec3]) {
        self.sum(x, |term, trial| {
            term.settle(trial);
            0.0
        });
    }

    /// The vertices that [`hold`](Self::hold) was last told; empty if what is clamped bends as all else.
    pub(crate) fn held(&self) -> &[bool] {
        self.terms.bending.held()
    }

    /// What hinges remember from linearization to linearization.
    pub(crate) fn turns(&self) -> Vec<T> {
        self.terms.bending.turns()
    }

    /// Puts that back.
    pub(crate) fn set_turns(&mut self, turns: &[T]) {
        self.terms.bending.set_turns(turns);
    }

    /// Tells for the vertices of each part what terms of single vertices have in A and b, and sums what it returns.
    pub(crate) fn for_rows<D: Split, R: Merge + Default>(
        &self,
        step: &ImplicitStep,
        masses: &[f64],
        data: D,
        work: &(impl Fn(&Part, &mut D, usize, &Row) -> R + Sync),
    ) -> R {
        for_parts(self.matrix.pattern().parts(), data, &|part: &Part, mut data| {
            let mut chunk = [Row::default(); CHUNK];
            let mut sum = R::default();
            for first in part.rows.clone().step_by(CHUNK) {
                let count = CHUNK.min(part.rows.end - first);
                for (vertex, row) in (first..).zip(self.terms.rows(step, masses, first, &mut chunk[..count])) {
                    sum = sum.merge(work(part, &mut data, vertex, row));
                }
            }
            sum
        })
    }

    /// The move of a cloth that nothing holds as a whole, m: elastic forces have no part in that.
    pub(crate) fn free_drift(&self, step: &ImplicitStep, masses: &[f64]) -> DVec3 {
        let [diagonal, x, y, z] = self.for_rows(step, masses, (), &|_, (), _, row: &Row| {
            let [x, y, z] = row.b.to_array();
            [row.diagonal, x, y, z]
        });
        DVec3::new(x, y, z) / diagonal
    }

    /// Sum of mass times the move that inertia and drag alone would give a vertex, kg·m: zero at rest.
    pub(crate) fn inertial_drift(&self, step: &ImplicitStep, masses: &[f64]) -> DVec3 {
        self.for_rows(step, masses, (), &|_, (), vertex, row: &Row| {
            let mass = masses[vertex];
            mass * (mass / row.diagonal * (step.inertial[vertex] - step.x[vertex]))
        })
    }

    /// Fills A and b.
    pub fn assemble(&mut self, step: &ImplicitStep, masses: &[f64]) {
        let Self { terms, bending_hessian, points, local, middle, moved, matrix, rhs } = self;
        let pattern = Arc::clone(matrix.pattern());
        place(pattern.parts(), step.x, *middle, points, local);
        if step.damping > 0.0 {
            // Relative to one vertex, as f32 has few digits and only differences count.
            let common = step.x[*middle] - step.origin[*middle];
            for_parts(pattern.parts(), &mut moved[..], &|part: &Part, moved| {
                for (moved, vertex) in moved.iter_mut().zip(part.rows.clone()) {
                    *moved = Padded::from_f64((step.x[vertex] - step.origin[vertex] - common).to_array());
                }
            });
        }
        let linearization = Linearization::new(step, Places { x: points, local }, moved);
        terms.each_mut().for_each(|term| term.prepare(&linearization));
        let terms = &*terms;
        let material = T::from_f64(linearization.material);
        for (far, &weight) in matrix.far_mut().iter_mut().zip(&bending_hessian.far) {
            *far = weight * material;
        }
        let (diagonal, lower) = matrix.clear();
        for_parts(
            pattern.parts(),
            (diagonal, lower, &mut rhs[..]),
            &|part: &Part, (BySlice(diagonal), ByGroup(lower), rhs)| {
                diagonal.fill(Group::zero());
                for (group, Pack(factors)) in lower.iter_mut().zip(&bending_hessian.near[part.groups.clone()]) {
                    *group = Group::scaled_identities(factors, material);
                }
                // Forces first, then b.
                rhs.fill(Padded::zero());
                let mut out = Output::new(part, lower, rhs);
                terms.each().for_each(|term| term.add_elements(&linearization, &mut out));
                let square = step.gamma * step.gamma;
                let mut chunk = [Row::default(); CHUNK];
                for (rhs, first) in rhs.chunks_mut(CHUNK).zip(part.rows.clone().step_by(CHUNK)) {
                    let rows = terms.rows(step, masses, first, &mut chunk[..rhs.len()]);
                    for ((rhs, row), vertex) in rhs.iter_mut().zip(rows).zip(first..) {
                        let slot = pattern.diagonal(vertex);
                        let inertia = M3::scaled_identity(T::from_f64(row.diagonal));
                        diagonal[slot / ROWS - part.slices.start].set_block(slot % ROWS, inertia);
                        let elastic = DVec3::from(rhs.to_f64());
                        let b = row.b - row.diagonal * step.drift + square * elastic;
                        *rhs = Padded::from_f64(b.to_array());
                    }
                }
            },
        );
        let (diagonal, lower) = matrix.diagonal_and_lower();
        for_parts(pattern.parts(), diagonal, &|part: &Part, BySlice(diagonal)| {
            T::dispatch(SubtractRows { pattern: &pattern, part, lower, diagonal });
        });
        for stencil in step.stencils {
            stencils::add_force(rhs, step, stencil);
            if stencil.fits(&pattern) {
                stencils::add_stiffness(matrix, step, stencil);
            } else {
                for (row, lump) in matrix.couplings_mut().push(step, stencil) {
                    let diagonal = matrix.diagonal(row);
                    matrix.set_diagonal(row, diagonal + lump);
                }
            }
        }
    }
}

/// Writes [`Places`].
fn place<T: Scalar>(parts: &[Part], x: &[DVec3], middle: usize, points: &mut [Padded<f64>], local: &mut [Padded<T>]) {
    let middle = x.get(middle).copied().unwrap_or_default();
    for_parts(parts, (points, local), &|part: &Part, (points, local)| {
        for ((point, local), x) in points.iter_mut().zip(local).zip(&x[part.rows.clone()]) {
            *point = Padded::new(x.to_array());
            *local = Padded::from_f64((*x - middle).to_array());
        }
    });
}
