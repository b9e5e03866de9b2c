//! The physics, free of any ECS: a mesh in, [`Cloth::step`], positions out.
//!
//! mesh → [`mesh`] (rest shape) → [`terms`] (what pulls on the cloth: each [`energy`], [`contact`]) → [`assembly`] (A and b) →
//! [`solve`] (A d = b) → `step` (what a substep does, in order) → [`cloth`] (state).

pub mod assembly;
pub mod cloth;
pub mod contact;
pub mod energy;
pub mod material;
pub mod math;
pub mod mesh;
pub mod solve;
mod step;
pub mod terms;

pub use cloth::{
    Cloth, ClothFault, Energy, Integrator, NewClothError, Precision, Quality, SettingsError, Snapshot, SnapshotError,
    SolverSettings, StepOutcome, StepReport, Stretch, Watch,
};
pub use contact::{Collider, ColliderError, Contact, ContactSettings, ContactSettingsError, Pose};
pub use material::{Fabric, MaterialError};
pub use mesh::{BendingModel, MeshError, RestShape, RestShapeOptions, SurfaceMesh};
pub use solve::{PreconditionerKind, SolverKind};
