//! The terms of a cloth: those of its linear system, and contact.

use bevy::math::DVec3;

use super::substep::Step;
use crate::physics::assembly::{Ordering, Part, Stencil, System};
use crate::physics::contact::ContactLayer;
use crate::physics::material::Fabric;
use crate::physics::math::Scalar;
use crate::physics::mesh::RestShape;
use crate::physics::terms::Term;

/// All terms; see [`terms`](crate::physics::terms) for the list.
pub(super) struct Terms<T: Scalar> {
    /// A and b, and the terms that are not contact.
    pub system: System<T>,
    /// Contact with colliders, which has an active set that the step asks for.
    pub contact: ContactLayer,
}

impl<T: Scalar> Terms<T> {
    /// The parts that vertices are worked on by.
    pub fn parts(&self) -> &[Part] {
        self.system.matrix.pattern().parts()
    }

    fn each(&mut self) -> impl Iterator<Item = &mut dyn Term<T>> {
        let contact: &mut dyn Term<T> = &mut self.contact;
        self.system.terms().chain(core::iter::once(contact))
    }

    /// Begins a substep: targets are set and contacts found.
    pub fn begin(&mut self, step: &Step) {
        if step.around.colliders.is_empty() {
            self.contact.forget();
        } else {
            self.contact.detect(&step.around, &step.start);
        }
        self.each().for_each(|term| term.begin(&step.start));
    }

    /// Forces on points of the cloth, linearized with vertices at `x`.
    pub fn stencils(&mut self, x: &[DVec3], out: &mut Vec<Stencil>) {
        out.clear();
        self.each().for_each(|term| term.add_stencils(x, out));
    }

    /// Potential of what holds for this substep alone, J.
    pub fn substep_potential(&mut self, x: &[DVec3]) -> f64 {
        self.each().map(|term| term.substep_potential(x)).sum()
    }

    /// Work of the world on the way from xₙ to `x`, J.
    pub fn work(&mut self, step: &Step, x: &[DVec3]) -> f64 {
        self.each().map(|term| term.work(&step.start, x)).sum()
    }

    /// Ends a substep that led to `x`.
    pub fn end(&mut self, step: &Step, x: &[DVec3]) {
        self.contact.remember(&step.around);
        self.each().for_each(|term| term.end(x));
    }
}

/// The contacts of a cloth whose vertices are numbered as `ordering` says.
pub(super) fn contact(shape: &RestShape, fabric: &Fabric, ordering: &Ordering) -> ContactLayer {
    let triangles = shape.triangles.iter().map(|triangle| triangle.vertices.map(|v| ordering.inner[v as usize]));
    ContactLayer::new(fabric, triangles.collect(), longest_sides(shape, ordering))
}

/// By vertex, as `ordering` numbers them: length of the longest side that it is an end of at rest, m.
pub(super) fn longest_sides(shape: &RestShape, ordering: &Ordering) -> Vec<f64> {
    let mut sides = vec![0.0_f64; shape.positions.len()];
    for &[a, b] in &shape.edges {
        let length = shape.positions[a as usize].distance(shape.positions[b as usize]);
        for vertex in [a, b].map(|vertex| ordering.inner[vertex as usize] as usize) {
            sides[vertex] = sides[vertex].max(length);
        }
    }
    sides
}
