//! Contact with the world: which vertices touch which colliders, and the forces of that in the implicit step.
//!
//! [`Collider`] (a shape that moves from one pose to another) → where a point meets it (`surface`, `meeting`) → a `Touch` with its
//! law of force (`touch`) → one [`ContactTerm`](crate::physics::assembly::ContactTerm) of A and b each (`layer`).

mod between;
mod collider;
mod features;
mod find;
mod layer;
mod meeting;
mod memory;
mod surface;
mod touch;

pub(crate) use collider::merged;
pub use collider::{Collider, Contact, ContactSettings, ContactSettingsError, Pose};
pub(crate) use layer::{ContactLayer, Moving, Surroundings};
