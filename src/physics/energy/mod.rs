//! What the cloth resists: one file per energy. What acts on single vertices is in [`terms`](super::terms).
//!
//! An element file holds pure functions over [`Real`](crate::physics::math::Real): kinematics, energy, gradient, projected
//! Hessian. It knows nothing of meshes, matrices or solvers; `assembly` calls it for batches of elements.

pub mod hinge;
pub mod membrane;
pub mod mid_edge;
pub mod stress;
