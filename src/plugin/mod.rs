//! Cloth as Bevy components: from a mesh asset to the picture, and back each frame.
//!
//! # What happens when
//!
//! In `PostUpdate`, once per frame:
//! 1. [`ClothSystems::Initialise`]: an entity with [`ClothMesh`] and a loaded [`Mesh3d`] gets a copy of the mesh of its own
//!    and a [`ClothState`], which holds the physics. Likewise when its description or its mesh changes.
//!    [`ClothMeshCollider`]s become [`ClothCollider`]s.
//! 2. [`ClothSystems::WriteBack`]: positions between the last two steps, in the space of the entity, go to that copy with
//!    normals, tangents and the [`Aabb`](bevy::camera::primitives::Aabb), if they changed. [`ClothError`]s are shown.
//!
//! In the schedule of [`ClothPlugin`] (`FixedUpdate`), once per step:
//! 1. [`ClothSystems::Collect`]: transforms, [`ClothPins`], [`ClothPinTargets`], [`ClothMaterial`], [`ClothQuality`] or
//!    [`ClothSolver`], [`ClothContact`] and [`ClothGravity`] go to the physics; with them, each [`ClothCollider`] near the cloth.
//! 2. [`ClothSystems::Step`]: every cloth takes a step, side by side. [`ClothContacts`] are filled.
//!
//! With a [`ClothBudget`], `Collect` begins by deciding how accurate each cloth may be and whether it is stepped in this
//! run, and `Step` and `WriteBack` end by taking note of what that took.
//!
//! Systems that move what holds a cloth belong before `Collect`; those that read the cloth, after `Step`.
//!
//! The physics ([`crate::physics`]) knows world space and metres only: an entity's scale makes its cloth larger, heavier
//! and wider-folded, as real cloth of that size.

mod budget;
mod collect;
mod components;
mod contact;
#[cfg(feature = "debug")]
mod debug;
mod diagnostics;
mod error;
mod initialise;
mod lifecycle;
mod material;
mod mesh_io;
mod pace;
mod pins;
mod quality;
mod shading;
mod state;
mod step;
mod write_back;

use bevy::app::{FixedFirst, FixedLast, FixedPostUpdate, FixedPreUpdate};
use bevy::asset::AssetEventSystems;
use bevy::camera::visibility::VisibilitySystems;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel};
use bevy::prelude::*;

pub use budget::{ClothBudget, ClothBudgetReport, ClothImportance};
pub use components::{ClothDisabled, ClothGravity, ClothMesh, ClothPinTargets};
#[cfg(any(feature = "avian3d", feature = "rapier3d"))]
pub use contact::ClothPhysicsCollider;
#[cfg(feature = "avian3d")]
pub use contact::ClothPushes;
pub use contact::{
    ClothCollider, ClothColliderError, ClothColliderKind, ClothCollidesWith, ClothContact, ClothContacts, ClothLayers,
    ClothMeshCollider, ClothMeshShape, ClothShapeError, ClothTouch,
};
#[cfg(feature = "debug")]
pub use debug::{ClothDebugPlugin, ClothGizmos};
pub use diagnostics::ClothDiagnosticsPlugin;
pub use error::ClothError;
pub use lifecycle::ClothReset;
pub use material::ClothMaterial;
pub use pins::{ATTRIBUTE_CLOTH_PIN, ClothPins, PinChannel, PinRule, PinVertex};
pub use quality::{ClothDefaultQuality, ClothQuality, ClothSolver};
pub use state::ClothState;

/// Simulates every entity that has a [`ClothMesh`].
///
/// Needs Bevy's `TimePlugin`, `TransformPlugin`, `AssetPlugin` and `MeshPlugin`, which are in `DefaultPlugins`.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy::app::FixedPostUpdate;
/// # use bevy_cloth::plugin::ClothPlugin;
/// # let mut app = App::new();
/// app.add_plugins(ClothPlugin::default()); // in FixedUpdate
/// # let mut app = App::new();
/// app.add_plugins(ClothPlugin::new(FixedPostUpdate).without_interpolation());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ClothPlugin {
    /// Where cloth is collected and stepped. One of the `Fixed…` schedules, so that steps are of one length; in any
    /// other, one frame is one step.
    pub schedule: InternedScheduleLabel,
    /// Show positions between the last two fixed steps, so that motion is smooth at any frame rate. It is shown up to one
    /// step late.
    pub interpolate: bool,
}

impl Default for ClothPlugin {
    fn default() -> Self {
        Self::new(FixedUpdate)
    }
}

impl ClothPlugin {
    /// Steps cloth in `schedule`: with a physics engine, the one it runs in or a later one.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern(), interpolate: true }
    }

    /// Shows the last step as it is.
    pub fn without_interpolation(self) -> Self {
        Self { interpolate: false, ..self }
    }

    fn is_fixed(&self) -> bool {
        let fixed = [
            FixedFirst.intern(),
            FixedPreUpdate.intern(),
            FixedUpdate.intern(),
            FixedPostUpdate.intern(),
            FixedLast.intern(),
        ];
        fixed.contains(&self.schedule)
    }
}

/// The stages of cloth, see [the module](self).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClothSystems {
    /// Reads components and transforms into the physics, in the schedule of [`ClothPlugin`].
    Collect,
    /// Steps every cloth, in the schedule of [`ClothPlugin`], after `Collect`.
    Step,
    /// Turns meshes into cloth, in `PostUpdate`, after the transforms are propagated.
    Initialise,
    /// Writes meshes, in `PostUpdate`, after `Initialise`; before assets send their events, so that the mesh is drawn in
    /// the same frame.
    WriteBack,
}

impl Plugin for ClothPlugin {
    fn build(&self, app: &mut App) {
        let time_passes = |time: Res<Time>| !time.delta().is_zero();
        app.init_resource::<ClothGravity>()
            .init_resource::<ClothDefaultQuality>()
            .init_resource::<ClothBudgetReport>()
            .init_resource::<budget::Keeper>()
            .init_resource::<contact::Surroundings>()
            .insert_resource(write_back::Interpolate(self.interpolate && self.is_fixed()))
            .configure_sets(self.schedule, (ClothSystems::Collect, ClothSystems::Step).chain())
            .configure_sets(
                PostUpdate,
                (ClothSystems::Initialise, ClothSystems::WriteBack)
                    .chain()
                    .after(TransformSystems::Propagate)
                    .before(AssetEventSystems)
                    .before(VisibilitySystems::CalculateBounds),
            )
            .add_systems(
                self.schedule,
                (
                    (
                        budget::plan.run_if(resource_exists::<ClothBudget>),
                        budget::release.run_if(budget::is_left_over),
                        collect::collect,
                        (contact::track, contact::give).chain().run_if(contact::is_wanted),
                    )
                        .chain()
                        .in_set(ClothSystems::Collect)
                        .run_if(time_passes),
                    (step::step, contact::tell, budget::observe.run_if(resource_exists::<ClothBudget>))
                        .chain()
                        .in_set(ClothSystems::Step)
                        .run_if(time_passes),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    (contact::shape_meshes.run_if(any_with_component::<ClothMeshCollider>), initialise::initialise)
                        .chain()
                        .in_set(ClothSystems::Initialise),
                    (
                        write_back::write_back,
                        error::report_faults,
                        budget::close_frame.run_if(resource_exists::<ClothBudget>),
                    )
                        .chain()
                        .in_set(ClothSystems::WriteBack),
                ),
            )
            .add_observer(lifecycle::reset)
            .add_observer(lifecycle::end)
            .add_observer(contact::end)
            .add_observer(contact::end_mesh)
            .register_type::<ClothMesh>()
            .register_type::<ClothMaterial>()
            .register_type::<ClothPins>()
            .register_type::<ClothPinTargets>()
            .register_type::<ClothQuality>()
            .register_type::<ClothDefaultQuality>()
            .register_type::<ClothSolver>()
            .register_type::<ClothImportance>()
            .register_type::<ClothBudget>()
            .register_type::<ClothBudgetReport>()
            .register_type::<ClothCollider>()
            .register_type::<ClothColliderError>()
            .register_type::<ClothCollidesWith>()
            .register_type::<ClothContact>()
            .register_type::<ClothContacts>()
            .register_type::<ClothLayers>()
            .register_type::<ClothMeshCollider>()
            .register_type::<ClothDisabled>()
            .register_type::<ClothError>()
            .register_type::<ClothGravity>()
            .register_type::<ClothReset>();
        #[cfg(any(feature = "avian3d", feature = "rapier3d"))]
        app.add_observer(contact::end_mark).register_type::<ClothPhysicsCollider>();
        #[cfg(feature = "avian3d")]
        {
            contact::avian::plugin(app, self.schedule);
            contact::pushes::plugin(app, self.schedule);
        }
        #[cfg(feature = "rapier3d")]
        contact::rapier::plugin(app, self.schedule);
    }
}
