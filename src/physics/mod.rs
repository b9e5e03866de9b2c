//! The physics, free of any ECS: a mesh in, [`Cloth::step`], positions out.
//!
//! mesh → [`mesh`] (rest shape) → [`assembly`] (A and b from the [`energy`] files and from [`contact`]) → [`solve`] (A d = b) →
//! [`cloth`] (state).

pub mod assembly;
pub mod cloth;
pub mod contact;
pub mod energy;
pub mod material;
pub mod math;
pub mod mesh;
pub mod solve;

pub use cloth::{
    Cloth, ClothFault, Energy, Integrator, NewClothError, Precision, Quality, SettingsError, Snapshot, SnapshotError,
    SolverSettings, StepOutcome, StepReport, Stretch, Watch,
};
pub use contact::{Collider, ColliderError, Contact, ContactSettings, ContactSettingsError, Pose};
pub use material::{Fabric, MaterialError};
pub use mesh::{BendingModel, MeshError, RestShape, RestShapeOptions, SurfaceMesh};
pub use solve::{PreconditionerKind, SolverKind};
