//! From elements to the linear system of an implicit step, A d = b.
//!
//! [`Ordering`] numbers the vertices; [`pattern`] finds which 3×3 blocks of A exist, and where each is stored; [`sliced_ell`]
//! holds their values, in [`group`]s of eight rows, and the scalars of [`far_pairs`]; `triangles` and `hinges` run the energies over
//! batches of elements, `triangles` add into precomputed slots, `hinges` to forces alone as `bending_hessian` is constant, with the
//! moments of `mid_edges` unless the cloth bends by hinges alone; [`System`] puts A and b together; [`Constraints`] take the
//! pinned vertices out.
//!
//! A new element energy is a file like `triangles.rs`, and three calls in `system.rs`. One that feels a translation puts its
//! part of the diagonal there itself, as `contacts` does: see `row_sums`.

mod batch;
mod bending_hessian;
mod colouring;
mod constraints;
mod contacts;
pub mod far_pairs;
pub mod group;
mod hinges;
mod implicit_step;
mod mid_edges;
mod ordering;
pub mod parts;
pub mod pattern;
mod row_sums;
pub(crate) mod slice;
pub mod sliced_ell;
mod system;
mod triangles;

pub(crate) use colouring::colour;
pub use constraints::{Constraints, constrain};
pub use contacts::ContactTerm;
pub use group::Group;
pub use implicit_step::{ImplicitStep, Projection};
pub use ordering::Ordering;
pub use parts::Part;
pub use pattern::{BlockPattern, Slicing};
pub use sliced_ell::BlockEll;
pub use system::{ElasticEnergy, System};
