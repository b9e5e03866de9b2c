//! Cloth as Bevy components: from a mesh asset to the picture, and back each frame.
//!
//! # What happens when
//!
//! Around the fixed loop, once per frame (`motion`): where the last frame left what holds cloth or touches it is noted, and how its
//! ticks moved it. So each tick can see these at its own time.
//!
//! In the schedule of [`ClothPlugin`] (`FixedUpdate`), once per tick:
//! 1. [`ClothSystems::Collect`]: the time that the tick sees is set. Transforms at that time (`motion`, `follow`), [`ClothPins`],
//!    [`ClothPinTargets`], [`ClothMaterial`], [`ClothQuality`] or [`ClothSolver`], [`ClothContact`], [`ClothInertia`] and
//!    [`ClothGravity`] go to the physics; with them, each [`ClothCollider`] near the cloth. What a cloth does not feel of the motion of
//!    its entity (jumps, and what [`ClothInertia`] leaves out) carries it.
//! 2. [`ClothSystems::Step`]: every cloth takes a step, side by side. [`ClothContacts`] are filled.
//!
//! In `PostUpdate`, once per frame:
//! 1. [`ClothSystems::Initialise`]: an entity with [`ClothMesh`] and a loaded [`Mesh3d`] gets a copy of the mesh of its own
//!    and a [`ClothState`], which holds the physics. Likewise when its description or its mesh changes. Without a mesh of its own, it
//!    takes those of its children ([`ClothPart`]).
//!    [`ClothMeshCollider`]s become [`ClothCollider`]s.
//! 2. [`ClothSystems::WriteBack`]: positions between the last two steps, in the space of the entity and led around the colliders that
//!    are drawn (`picture`), go to that copy, or those copies, with normals, tangents and the [`Aabb`](bevy::camera::primitives::Aabb), if they changed.
//!    [`ClothError`]s are shown.
//!
//! With a [`ClothBudget`], `Collect` begins by deciding how accurate each cloth may be and whether it is stepped in this
//! run, and `Step` and `WriteBack` end by taking note of what that took.
//!
//! # Who may move what, and when
//!
//! Whatever holds cloth or touches it may be moved in any schedule, at any frame rate, each bone of a hierarchy in another one:
//! - In a fixed schedule, before `Collect`: cloth sees it in the same tick.
//! - In `Update`, `PreUpdate`, or by animation in `PostUpdate`: cloth sees it about one frame late, at the times of its ticks. This is not
//!   visible: pins are drawn exactly where they are held, and cloth that touches something is drawn beside it.
//! - By a physics engine, eased between its ticks or not: as in a fixed schedule. An engine that runs after the cloth is seen a tick late.
//!
//! Systems that read the cloth belong after `Step`. A jump is recognized where it changes the speed of what holds the cloth by more than
//! [`ClothInertia::jump_speed`]; smaller ones can be told by [`ClothTeleport`]. What moves while the time stands still has jumped.
//!
//! With a schedule that is not fixed (`ClothPlugin::new(Update)`), a frame is a step, and only what was moved before `Collect` in that frame is
//! seen in it.
//!
//! # The same motion every time
//!
//! The same input gives the same bits: in every run, with any number of threads, wherever entities are in memory. A game that needs
//! that, for rollback, replays or lockstep, sees to this:
//! - Cloth is stepped in a fixed schedule, and what moves it, its pins and its colliders moves in that schedule too, before
//!   [`ClothSystems::Collect`]. What is moved once per frame is not where it was when frames are of other lengths.
//! - There is no [`ClothBudget`]: it reads the clock.
//! - Cloths and colliders have the same [`ClothId`] everywhere. Without any given, that needs spawning in the same order.
//! - The build and the kind of machine are the same: instructions that only some machines have round differently.
//!
//! To go back in time, see [`ClothSnapshot`] and [`ClothRestore`].
//!
//! # Saving worlds
//!
//! All components that a game inserts are reflected, and serialised with the feature `serialize`. [`ClothSource`] says what is saved
//! of a running cloth and what is not, [`ClothSnapshot`] how its motion is kept.
//!
//! The physics ([`crate::physics`]) knows world space and metres only: an entity's scale makes its cloth larger, heavier
//! and wider-folded, as real cloth of that size.

mod advice;
mod budget;
mod build;
mod collect;
mod components;
mod contact;
#[cfg(feature = "debug")]
mod debug;
mod diagnostics;
mod error;
mod follow;
mod geometry;
mod id;
mod imperfection;
mod inertia;
mod initialise;
mod lifecycle;
mod material;
mod mesh_io;
mod motion;
mod pace;
mod parts;
mod picture;
mod pins;
mod quality;
mod rescale;
mod saving;
mod seams;
mod sets;
mod shading;
mod snapshot;
mod sources;
mod state;
mod step;
mod winding;
mod write_back;

use bevy::app::{FixedFirst, FixedLast, FixedPostUpdate, FixedPreUpdate, RunFixedMainLoop, RunFixedMainLoopSystems};
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
    ClothMeshCollider, ClothMeshShape, ClothShape, ClothShapeError, ClothShapePart, ClothTouch,
};
#[cfg(feature = "debug")]
pub use debug::{ClothDebugPlugin, ClothGizmos};
pub use diagnostics::ClothDiagnosticsPlugin;
pub use error::ClothError;
pub use id::ClothId;
pub use inertia::ClothInertia;
pub use lifecycle::ClothReset;
pub use material::ClothMaterial;
pub use motion::ClothTeleport;
pub use parts::ClothPart;
pub use pins::{ATTRIBUTE_CLOTH_PIN, ClothPins, PinChannel, PinRule, PinVertex};
pub use quality::{ClothDefaultQuality, ClothQuality, ClothSolver};
pub use saving::ClothSource;
pub use snapshot::{ClothRestore, ClothSnapshot};
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
            .insert_resource(motion::Motions::new(self.is_fixed()))
            .init_resource::<sources::Sources>()
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
                        motion::begin_tick,
                        budget::plan.run_if(resource_exists::<ClothBudget>),
                        budget::release.run_if(budget::is_left_over),
                        collect::collect,
                        (contact::rebuild, contact::track, contact::give).chain().run_if(contact::is_wanted),
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
                RunFixedMainLoop,
                (
                    (motion::before_ticks, follow::note_targets)
                        .chain()
                        .after(RunFixedMainLoopSystems::BeforeFixedMainLoop)
                        .before(RunFixedMainLoopSystems::FixedMainLoop),
                    // Before what eases transforms for the eye.
                    (motion::after_ticks, follow::note_targets_of_ticks)
                        .chain()
                        .after(RunFixedMainLoopSystems::FixedMainLoop)
                        .before(RunFixedMainLoopSystems::AfterFixedMainLoop),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    (
                        contact::shape_meshes.run_if(any_with_component::<ClothMeshCollider>),
                        saving::take.run_if(any_with_component::<ClothSource>),
                        initialise::initialise,
                        snapshot::begin,
                    )
                        .chain()
                        .in_set(ClothSystems::Initialise),
                    (
                        write_back::write_back,
                        error::report_faults,
                        advice::advise,
                        seams::tell_of_seams,
                        budget::close_frame.run_if(resource_exists::<ClothBudget>),
                    )
                        .chain()
                        .in_set(ClothSystems::WriteBack),
                ),
            )
            .add_observer(lifecycle::reset)
            .add_observer(motion::teleport)
            .add_observer(lifecycle::end)
            .add_observer(saving::note)
            .add_observer(snapshot::restore)
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
            .register_type::<ClothShape>()
            .register_type::<ClothCollidesWith>()
            .register_type::<ClothContact>()
            .register_type::<ClothContacts>()
            .register_type::<ClothLayers>()
            .register_type::<ClothMeshCollider>()
            .register_type::<ClothDisabled>()
            .register_type::<ClothError>()
            .register_type::<ClothGravity>()
            .register_type::<ClothInertia>()
            .register_type::<ClothReset>()
            .register_type::<ClothTeleport>()
            .register_type::<ClothTouch>()
            .register_type::<PinRule>()
            .register_type::<PinChannel>()
            .register_type::<ClothId>()
            .register_type::<id::NextClothId>()
            .register_type::<ClothSnapshot>()
            .register_type::<ClothSource>();
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
