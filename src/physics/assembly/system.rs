//! A and b of one implicit step.

use std::sync::Arc;

use bevy::math::DVec3;

use super::batch::{self, Output};
use super::contacts;
use super::hinges::Hinges;
use super::implicit_step::{ImplicitStep, Linearisation};
use super::ordering::along;
use super::parts::{ByGroup, BySlice, Part, for_parts};
use super::row_sums::SubtractRows;
use super::triangles::Triangles;
use super::{BlockCsr, BlockPattern, Group, Ordering, Slicing};
use crate::physics::energy::gravity;
use crate::physics::material::Fabric;
use crate::physics::math::{M3, Padded, ROWS, Scalar};
use crate::physics::mesh::RestShape;

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

/// The linear system of a cloth: elements, and the storage of A and b. All vertices are numbered as its ordering says.
pub struct System<T: Scalar> {
    triangles: Triangles<T>,
    hinges: Hinges<T>,
    /// x, where the cloth is to be linearised or measured, m.
    points: Vec<Padded<f64>>,
    /// x − q, see [`Linearisation`].
    moved: Vec<Padded<T>>,
    /// A.
    pub matrix: BlockCsr<T>,
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
        for (place, vertex) in along(&shape.positions).into_iter().enumerate() {
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
        Self {
            triangles: Triangles::new(shape, fabric, inner, &rank, &pattern),
            hinges: Hinges::new(shape, fabric, inner, &rank, &pattern),
            points: vec![Padded::zero(); shape.vertex_count()],
            moved: zeros.clone(),
            matrix: BlockCsr::zero(Arc::new(pattern)),
            rhs: zeros,
        }
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, shape: &RestShape, fabric: &Fabric) {
        self.triangles.set_fabric(fabric);
        self.hinges.measure(shape, fabric);
    }

    /// Takes over a shape of the same elements that measure otherwise.
    pub fn measure(&mut self, shape: &RestShape, fabric: &Fabric, ordering: &Ordering) {
        self.triangles.measure(shape, &ordering.inner);
        self.hinges.measure(shape, fabric);
    }

    /// Says that the cloth was mirrored.
    pub fn mirror(&mut self) {
        self.hinges.mirror();
    }

    /// Elastic energy at `x`.
    pub fn energy(&mut self, x: &[DVec3]) -> ElasticEnergy {
        let parts = self.matrix.pattern().parts();
        for_parts(parts, &mut self.points[..], &|part: &Part, points| pad(&x[part.rows.clone()], points));
        let Self { triangles, hinges, points, matrix, .. } = self;
        let parts = matrix.pattern().parts();
        ElasticEnergy { membrane: triangles.energy_at(parts, points), bending: hinges.total_energy(parts, points) }
    }

    /// The same, for those who may not change anything.
    pub fn energy_at(&self, x: &[DVec3]) -> ElasticEnergy {
        let mut points = vec![Padded::zero(); x.len()];
        pad(x, &mut points);
        let parts = self.matrix.pattern().parts();
        ElasticEnergy {
            membrane: self.triangles.energy_at(parts, &points),
            bending: self.hinges.total_energy_at(parts, &points),
        }
    }

    /// Says which vertices are held, so that what is clamped does not bend. (That they do not move is said by
    /// [`Constraints`](super::Constraints).)
    pub fn hold(&mut self, held: &[bool]) {
        self.hinges.hold(held);
    }

    /// Says that the cloth is at `x` now, whatever was before.
    pub fn settle(&mut self, x: &[DVec3]) {
        pad(x, &mut self.points);
        self.hinges.settle(&self.points);
    }

    /// The vertices that [`hold`](Self::hold) was last told; empty if what is clamped bends as all else.
    pub(crate) fn held(&self) -> &[bool] {
        self.hinges.held()
    }

    /// What hinges remember from linearisation to linearisation.
    pub(crate) fn turns(&self) -> Vec<T> {
        self.hinges.turns()
    }

    /// Puts that back.
    pub(crate) fn set_turns(&mut self, turns: &[T]) {
        self.hinges.set_turns(turns);
    }

    /// Fills A and b.
    pub fn assemble(&mut self, step: &ImplicitStep, masses: &[f64]) {
        let Self { triangles, hinges, points, moved, matrix, rhs } = self;
        let pattern = Arc::clone(matrix.pattern());
        // Relative to the first vertex, as f32 has few digits and only differences count.
        let common = step.x[0] - step.origin[0];
        for_parts(pattern.parts(), (&mut points[..], &mut moved[..]), &|part: &Part, (points, moved)| {
            pad(&step.x[part.rows.clone()], points);
            if step.damping > 0.0 {
                for (moved, vertex) in moved.iter_mut().zip(part.rows.clone()) {
                    *moved = Padded::from_f64((step.x[vertex] - step.origin[vertex] - common).to_array());
                }
            }
        });
        let linearisation = Linearisation::new(step, points, moved);
        hinges.prepare(&linearisation);
        let (diagonal, lower) = matrix.clear();
        for_parts(
            pattern.parts(),
            (diagonal, lower, &mut rhs[..]),
            &|part: &Part, (BySlice(diagonal), ByGroup(lower), rhs)| {
                diagonal.fill(Group::zero());
                lower.fill(Group::zero());
                // Forces first, then b.
                rhs.fill(Padded::zero());
                let mut out = Output::new(part, lower, rhs);
                batch::assemble(&*triangles, &linearisation, &mut out);
                batch::assemble(&*hinges, &linearisation, &mut out);
                for (rhs, vertex) in rhs.iter_mut().zip(part.rows.clone()) {
                    let (inertia, b) = inertia(step, vertex, masses[vertex], DVec3::from(rhs.to_f64()));
                    let slot = pattern.diagonal(vertex);
                    let inertia = M3::scaled_identity(T::from_f64(inertia));
                    diagonal[slot / ROWS - part.slices.start].set_block(slot % ROWS, inertia);
                    *rhs = Padded::from_f64(b.to_array());
                }
            },
        );
        let (diagonal, lower) = matrix.diagonal_and_lower();
        for_parts(pattern.parts(), diagonal, &|part: &Part, BySlice(diagonal)| {
            T::dispatch(SubtractRows { pattern: &pattern, part, lower, diagonal });
        });
        for term in step.contacts {
            contacts::add(matrix, rhs, step, term);
        }
    }
}

fn pad(x: &[DVec3], points: &mut [Padded<f64>]) {
    for (point, x) in points.iter_mut().zip(x) {
        *point = Padded::new(x.to_array());
    }
}

/// What a vertex of this mass, with this elastic force on it, adds to the diagonal of A, and has as b.
fn inertia(step: &ImplicitStep, vertex: usize, mass: f64, elastic: DVec3) -> (f64, DVec3) {
    let x = step.x[vertex];
    let factor = step.inertia.map_or(1.0, |factors| factors[vertex]);
    let inertia = factor + step.gamma * step.air_drag;
    let carried = factor * (step.inertial[vertex] - x) - step.gamma * step.air_drag * (x - step.origin[vertex]);
    let force = elastic + gravity::force(step.gravity, mass);
    (mass * inertia, mass * (carried - inertia * step.drift) + step.gamma * step.gamma * force)
}
