//! Cloth for Bevy by implicit finite elements: fabrics in real units that hang, swing and drape the same at every mesh
//! resolution, time step and solver setting.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_cloth::prelude::*;
//!
//! fn spawn_flag(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
//!     let sheet = Plane3d::new(Vec3::Y, Vec2::splat(0.5)).mesh().subdivisions(30);
//!     commands.spawn((
//!         Mesh3d(meshes.add(sheet)),
//!         Transform::from_xyz(0.0, 2.0, 0.0),
//!         ClothMesh::default(),
//!         ClothMaterial::cotton(),
//!         ClothPins::where_position(|p| p.z < -0.49 && p.x.abs() > 0.49), // two of its corners
//!     ));
//! }
//!
//! App::new()
//!     .add_plugins(ClothPlugin::default()) // beside DefaultPlugins
//!     .add_systems(Startup, spawn_flag);
//! ```
//!
//! # Where things are
//! A mesh becomes elements, elements become A and b, A is solved, positions go back to the mesh:
//!
//! 1. [`physics::mesh`]: triangle mesh → [`RestShape`](physics::RestShape): welded vertices, triangles with warp and weft,
//!    hinges, and how it bends.
//! 2. [`physics::energy`]: one file per energy, written over a number type: one number, or eight elements side by side.
//! 3. [`physics::assembly`]: vertices in an order that suits the solver, elements in batches → the system A d = b of an implicit
//!    step.
//! 4. [`physics::contact`]: where vertices and triangles meet colliders, and the forces of that as terms of A and b.
//! 5. [`physics::solve`]: solvers of that system.
//! 6. [`physics::Cloth`]: state and step. All of `physics` works without an App.
//! 7. [`plugin`]: the ECS side: reads meshes, carries transforms and pins in, steps all cloths, writes meshes back; it says
//!    which system runs when.
//!
//! A new energy goes beside [`physics::energy::membrane`], a new solver or preconditioner beside
//! [`physics::solve::ConjugateGradient`], a new fabric into [`physics::material`], a
//! shape with a closed form into `surface.rs` of [`physics::contact`].

#![warn(missing_docs)]

pub mod physics;
pub mod plugin;

/// Shapes of colliders.
pub use parry3d;

/// What a game needs.
pub mod prelude {
    pub use crate::physics::{
        BendingModel, Fabric, Integrator, Precision, PreconditionerKind, SolverKind, SolverSettings,
    };
    #[cfg(any(feature = "avian3d", feature = "rapier3d"))]
    pub use crate::plugin::ClothPhysicsCollider;
    #[cfg(feature = "avian3d")]
    pub use crate::plugin::ClothPushes;
    pub use crate::plugin::{
        ATTRIBUTE_CLOTH_PIN, ClothBudget, ClothBudgetReport, ClothCollider, ClothColliderError, ClothColliderKind,
        ClothCollidesWith, ClothContact, ClothContacts, ClothDefaultQuality, ClothDiagnosticsPlugin, ClothDisabled,
        ClothError, ClothGravity, ClothId, ClothImportance, ClothInertia, ClothLayers, ClothMaterial, ClothMesh,
        ClothMeshCollider, ClothMeshShape, ClothPart, ClothPinTargets, ClothPins, ClothPlugin, ClothQuality,
        ClothReset, ClothRestore, ClothShape, ClothShapeError, ClothShapePart, ClothSnapshot, ClothSolver, ClothSource,
        ClothState, ClothSystems, ClothTeleport, ClothTouch, PinChannel, PinRule, PinVertex,
    };
    #[cfg(feature = "debug")]
    pub use crate::plugin::{ClothDebugPlugin, ClothGizmos};
}
