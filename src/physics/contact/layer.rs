//! All touches of a cloth: found before a step, remembered after it.

use std::sync::Arc;

use bevy::math::DVec3;
use parry3d::shape::SharedShape;

use super::collider::{Collider, Contact, ContactSettings};
use super::detect::Nearby;
use super::features::Features;
use super::find::{Faces, Found, Near};
use super::meeting::Body;
use super::memory::{Memories, Memory};
use super::touch::{Case, Touch};
use crate::physics::material::Fabric;
use crate::physics::terms::Substep;

/// What the touches need to know of a substep. All vertices are numbered as the engine does.
#[derive(Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub colliders: &'a [Collider],
    pub settings: ContactSettings,
    /// Whether the step is taken in more substeps than its settings ask for, because something comes in fast.
    pub is_impact: bool,
    /// The substep as shares of the way of the colliders.
    pub from: f64,
    pub to: f64,
}

impl Surroundings<'_> {
    /// Whether the substep is the whole step.
    pub fn is_whole(&self) -> bool {
        self.from == 0.0 && self.to == 1.0
    }
}

/// The touches of one cloth.
#[derive(Default)]
pub(crate) struct ContactLayer {
    pub(super) touches: Vec<Touch>,
    /// Those of the substep before.
    pub(super) memory: Memories,
    pub(super) faces: Faces,
    pub(super) nearby: Nearby,
    /// Of the shapes that were near in the last substep: the shape tells them apart.
    pub(super) features: Vec<(SharedShape, Arc<Features>)>,
    /// All vertices, in the frame of the collider that is looked at, where they are not far from it.
    pub(super) near: Vec<Near>,
    /// By vertex: how far it may end from its free way without being inside anything, squared, m²; infinite where it is held.
    pub(super) room: Vec<f64>,
    /// Vertices that ended further.
    pub(super) astray: Vec<u32>,
    pub(super) found: Vec<Found>,
    /// Stiffness of the fabric, N/m.
    pub(super) fabric: f64,
}

impl ContactLayer {
    /// For a cloth of these triangles, with the longest side around each vertex at rest, m.
    pub fn new(fabric: &Fabric, triangles: Vec<[u32; 3]>, sides: Vec<f64>) -> Self {
        let mut layer = Self { faces: Faces::new(triangles, sides), ..Self::default() };
        layer.set_fabric(fabric);
        layer
    }

    /// Changes the fabric, which says how stiff contact must be.
    pub fn set_fabric(&mut self, fabric: &Fabric) {
        self.fabric = f64::from(fabric.warp_stiffness.max(fabric.weft_stiffness));
    }

    /// Changes the longest side around each vertex at rest, m.
    pub fn measure(&mut self, sides: Vec<f64>) {
        self.faces.measure(sides);
    }

    /// Length of the longest side of a triangle at rest, m.
    pub fn longest_side(&self) -> f64 {
        self.faces.longest
    }

    /// Whether nothing is near.
    pub fn is_empty(&self) -> bool {
        self.touches.is_empty()
    }

    /// Vertices of touches that have a force; some more than once.
    pub fn touched(&self) -> impl Iterator<Item = usize> {
        self.touches.iter().filter(|touch| touch.is_active()).flat_map(|touch| {
            let corners = touch.vertices.iter().zip(touch.weights);
            corners.filter(|&(_, weight)| weight != 0.0).map(|(&vertex, _)| vertex as usize)
        })
    }

    /// Puts what touches onto its plane, what sticks where it sticks. Vertices that are held stay.
    pub fn project(&self, points: &mut [DVec3], held: &[bool]) {
        for touch in self.touches.iter().filter(|touch| touch.is_active()) {
            let x = touch.point(points);
            let mut way = (touch.offset - touch.normal.dot(x)) * touch.normal;
            if touch.case == Case::Stick {
                let back = touch.carried - x;
                way += back - touch.normal.dot(back) * touch.normal;
            }
            let corners = touch.vertices.into_iter().zip(touch.weights).filter(|&(vertex, _)| !held[vertex as usize]);
            let square: f64 = corners.clone().map(|(_, weight)| weight * weight).sum();
            for (vertex, weight) in corners {
                points[vertex as usize] += weight / square * way;
            }
        }
    }

    /// Whether any touch has a force.
    pub fn any_active(&self) -> bool {
        self.touches.iter().any(Touch::is_active)
    }

    /// Mean velocity of what the cloth touches, where it touches it, m/s; `None` if no touch has a force.
    pub fn surface_velocity(&self, substep: &Substep) -> Option<DVec3> {
        let active = self.touches.iter().filter(|touch| touch.is_active());
        let (sum, count) = active
            .fold((DVec3::ZERO, 0), |(sum, count), touch| (sum + touch.carried - touch.point(substep.x), count + 1));
        (count > 0).then(|| sum / (f64::from(count) * substep.dt))
    }

    /// Judges every touch by where a solve led, and says what forces were wrong, as a share of those that are right.
    pub fn judge(&mut self, points: impl Fn(usize) -> DVec3) -> f64 {
        let (mut wrong, mut right) = (0.0, 0.0);
        for touch in &mut self.touches {
            let x = touch.at(&points);
            wrong += touch.judge(x);
            right += touch.force.length();
        }
        if wrong > 0.0 { wrong / right } else { 0.0 }
    }

    /// Before a search from these points for a lower potential.
    pub fn brace(&mut self, points: &[DVec3]) {
        for touch in &mut self.touches {
            touch.brace(touch.point(points));
        }
    }

    /// The case of every touch as its potential has it.
    pub fn choose(&mut self, points: &[DVec3]) {
        for touch in &mut self.touches {
            touch.choose(touch.point(points));
        }
    }

    /// Takes what the potential says at these points for the forces of the substep.
    pub fn settle(&mut self, points: &[DVec3]) {
        for touch in &mut self.touches {
            touch.settle(touch.point(points));
        }
    }

    /// What a user sees of the touches that have a force, with the cloth at the points that the step led to.
    pub fn show(&self, points: &[DVec3]) -> Vec<Contact> {
        let contact = |touch: &Touch| {
            let x = touch.point(points);
            let above = touch.normal.dot(x) - touch.surface;
            Contact {
                vertices: touch.vertices,
                weights: touch.weights,
                collider: touch.id,
                point: x - above * touch.normal,
                normal: touch.normal,
                force: touch.acted,
            }
        };
        self.touches.iter().filter(|touch| touch.is_active()).map(contact).collect()
    }

    /// Remembers the touches for the next substep.
    pub fn remember(&mut self, around: &Surroundings) {
        let mut body: Option<(u32, Body)> = None;
        let Self { touches, memory, .. } = self;
        memory.replace(touches.iter().filter(|touch| touch.is_active()).map(|touch| {
            let collider = &around.colliders[touch.collider as usize];
            let body = match &mut body {
                Some((index, body)) if *index == touch.collider => body,
                other => &mut other.insert((touch.collider, Body::new(collider, around.from, around.to))).1,
            };
            let normal_force = touch.pressing_force();
            Memory {
                collider: collider.id,
                feature: touch.feature,
                vertices: touch.vertices,
                normal_force,
                before: touch.last,
                friction: body.turn_back(touch.force - normal_force * touch.normal),
                slipping: if let Case::Slip(way) = touch.case { Some(body.turn_back(way)) } else { None },
            }
        }));
    }

    /// What is remembered for the next substep.
    pub fn memories(&self) -> &[Memory] {
        self.memory.all()
    }

    /// Replaces that.
    pub fn recall_all(&mut self, memories: &[Memory]) {
        self.memory.replace(memories.iter().copied());
    }

    /// Forgets everything: the cloth was put elsewhere.
    pub fn forget(&mut self) {
        self.touches.clear();
        self.room.clear();
        self.memory.clear();
        self.features.clear();
    }
}

impl Touch {
    /// N of the force; none if that is of another plane, which the touch was found at after the last solve.
    fn pressing_force(&self) -> f64 {
        self.normal.dot(self.force).max(0.0)
    }

    /// Its point of the cloth.
    fn at(&self, points: impl Fn(usize) -> DVec3) -> DVec3 {
        if self.weights[0] == 1.0 {
            return points(self.vertices[0] as usize);
        }
        self.vertices.iter().zip(self.weights).map(|(&vertex, weight)| weight * points(vertex as usize)).sum()
    }

    pub fn point(&self, points: &[DVec3]) -> DVec3 {
        self.at(|vertex| points[vertex])
    }
}

#[cfg(test)]
mod tests {
    use super::super::touch::tests::touch;
    use super::*;

    /// Its friction would be negative in the next step, and without bounds where it does not slip yet.
    #[test]
    fn what_was_found_at_another_plane_after_the_last_solve_presses_nothing() {
        let mut touch = touch();
        touch.settle(DVec3::new(0.1, 0.0029, 0.0));
        assert!(touch.pressing_force() > 0.0);
        touch.normal = -touch.normal;
        assert_eq!(touch.pressing_force(), 0.0);
    }
}
