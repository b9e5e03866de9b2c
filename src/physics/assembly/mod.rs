//! From elements to the linear system of an implicit step, A d = b.
//!
//! [`Ordering`] numbers the vertices; [`pattern`] finds which 3×3 blocks of A exist, and where each is stored; [`block_csr`]
//! holds their values, in [`group`]s of eight rows; `triangles` and `hinges` run the energies over batches of elements and
//! add into precomputed slots, `hinges` with the moments of `mid_edges` unless the cloth bends by hinges alone; [`System`] puts A and b together; [`Constraints`] take the pinned vertices out.
//!
//! A new element energy is a file like `hinges.rs`, and three calls in `system.rs`. One that feels a translation puts its
//! part of the diagonal there itself, as `contacts` does: see `row_sums`.

mod batch;
pub mod block_csr;
mod colouring;
mod constraints;
mod contacts;
pub mod group;
mod hinges;
mod implicit_step;
mod mid_edges;
mod ordering;
pub mod parts;
pub mod pattern;
mod row_sums;
pub(crate) mod slice;
mod system;
mod triangles;

pub use block_csr::BlockCsr;
pub(crate) use colouring::colour;
pub use constraints::{Constraints, constrain};
pub use contacts::ContactTerm;
pub use group::Group;
pub use implicit_step::{ImplicitStep, Projection};
pub use ordering::Ordering;
pub use parts::Part;
pub use pattern::{BlockPattern, Slicing};
pub use system::{ElasticEnergy, System};
