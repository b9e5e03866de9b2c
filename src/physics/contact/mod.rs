//! Contact with the world: which vertices touch which colliders, and the forces of that in the implicit step.
//!
//! [`Collider`] (a shape that moves from one pose to another), and its corners and edges (`features`) → which vertices and triangles
//! come near it (`detect`, `find`) → where a vertex meets its surface (`surface`, `meeting`) and a triangle what is between its
//! vertices (`between`) → a `Touch` that begins with what is remembered of it (`begin`, `memory`), with its law of force (`touch`) →
//! one [`Stencil`](crate::physics::assembly::Stencil) of A and b each (`term`), judged after every solve (`layer`); what ends inside all the same
//! is moved out (`guard`).

mod begin;
mod between;
mod collider;
mod detect;
mod features;
mod find;
mod guard;
mod known;
mod layer;
mod meeting;
mod memory;
mod sheet;
mod surface;
mod term;
mod touch;

use bevy::math::DVec3;
use parry3d::shape::SharedShape;

pub(crate) use collider::merged;
pub use collider::{Collider, ColliderError, Contact, ContactSettings, ContactSettingsError, Pose};
pub(crate) use layer::{ContactLayer, Surroundings};
pub(crate) use memory::Memory;
pub(crate) use sheet::is_sheet;

/// The distance (m) from a point to a shape, in its frame, and the outward unit normal there. Where the surface is further than `within`, that may
/// stand for the distance.
pub(crate) fn distance(shape: &SharedShape, point: DVec3, within: f64) -> (f64, DVec3) {
    let nearest = surface::Surface::new(shape).nearest(point, within);
    (nearest.distance, nearest.normal)
}
