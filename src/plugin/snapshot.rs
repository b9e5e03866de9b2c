//! Cloth put into a state: of its own past, of a save game, or as a game likes.

use bevy::math::{DAffine3, DMat3, DQuat, DVec3};
use bevy::prelude::*;

use super::components::ClothMesh;
use super::contact::{Met, Track};
use super::error::ClothError;
use super::follow::Following;
use super::id::ClothId;
use super::motion::Motions;
use super::pace::Pace;
use super::state::{ClothState, representatives, rest_shape};
use crate::physics::cloth::Shared;
use crate::physics::{Cloth, Pose, Snapshot};

/// A running cloth as it was, from [`ClothState::snapshot`]: put back, it goes on to the last bit.
///
/// Positions and velocities are in it, and all that the next step depends on: what is remembered of touches and of the step
/// before, the fabric and settings, the rhythm of its steps, and where its entity was. Not in it are the transforms of entities,
/// of the cloth and of colliders, and the components beside it: a game puts back those of its own that it changes. A clone is
/// cheap, as it shares the numbers.
///
/// **Rollback**: take a snapshot at the end of each tick, keep it with the transforms, and to go back, put the transforms back
/// first and then trigger [`ClothRestore`]. The snapshot may be kept as a component of the cloth, as `bevy_ggrs` does with
/// `rollback_component_with_clone`. See [the plugin](crate::plugin#the-same-motion-every-time) on what makes runs the same.
///
/// **Saving a world**: insert it beside the cloth before the world is saved by reflection, which needs the feature `serialize`.
/// A cloth that starts beside a `ClothSnapshot` begins in that state, and the component is taken away. See
/// [`ClothSource`](super::ClothSource) for the mesh.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_cloth::plugin::ClothState;
/// fn before_saving(cloths: Query<(Entity, &ClothState)>, mut commands: Commands) {
///     for (entity, state) in &cloths {
///         commands.entity(entity).insert(state.snapshot());
///     }
/// }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(opaque)]
#[reflect(Component, Clone, Debug, PartialEq)]
pub struct ClothSnapshot {
    physics: Snapshot,
    /// See [`Binding::rest_linear`](super::state::Binding::rest_linear).
    rest_linear: DMat3,
    /// Present, previous and seen.
    anchors: [DAffine3; 3],
    /// `None` if they are those that the physics goes on from.
    previous_positions: Option<Shared<DVec3>>,
    pace: Pace,
    ticks: Option<u32>,
    stepped: bool,
    suspended: bool,
    step_length: f64,
    /// What it felt of the motion of its entity, and what is held.
    follower: Following,
    placed: bool,
    /// Ids of colliders, and where they were in the last step.
    colliders: Shared<(u64, DVec3, DQuat)>,
    /// The same of all that the picture is led around, from the start of the step to its end.
    met: Shared<(u64, [DVec3; 2], [DQuat; 2])>,
}

impl ClothSnapshot {
    /// World positions of the simulated vertices, m.
    pub fn positions(&self) -> &[DVec3] {
        self.physics.positions()
    }

    /// Velocities of the simulated vertices, m/s.
    pub fn velocities(&self) -> &[DVec3] {
        self.physics.velocities()
    }

    /// The part of it that the physics knows.
    pub fn physics(&self) -> &Snapshot {
        &self.physics
    }
}

/// Trigger it to put a cloth back into a state that it was in: `commands.trigger(ClothRestore { entity, snapshot })`.
///
/// What moves the cloth and its colliders must be where it was before that: colliders count as standing where they are now, and
/// meet the cloth from there in the next step. A cloth that has not started yet begins in the state. If the snapshot does not
/// fit, [`ClothError::State`] says why, and the cloth goes on as it is.
#[derive(EntityEvent, Clone, Debug)]
pub struct ClothRestore {
    /// The cloth.
    pub entity: Entity,
    /// Its state.
    pub snapshot: ClothSnapshot,
}

impl ClothState {
    /// The cloth as it is, see [`ClothSnapshot`]. Takes as long as copying about 120 bytes for each simulated vertex, and 100 more for
    /// each touch.
    pub fn snapshot(&self) -> ClothSnapshot {
        let physics = self.cloth.snapshot();
        let known = physics.earlier_positions() == Some(&self.previous_positions[..]);
        ClothSnapshot {
            rest_linear: self.binding.rest_linear,
            anchors: [self.anchor, self.previous_anchor, self.seen_anchor],
            previous_positions: (!known).then(|| self.previous_positions.as_slice().into()),
            pace: self.pace,
            ticks: self.ticks,
            stepped: self.stepped,
            suspended: self.suspended,
            step_length: self.step_length,
            follower: self.follower.following(),
            placed: self.placed,
            colliders: self.cloth.colliders().iter().map(|c| (c.id, c.end.translation, c.end.rotation)).collect(),
            met: self.met.iter().map(ways).collect(),
            physics,
        }
    }

    /// Puts the cloth back into a state. Trigger [`ClothRestore`] instead where colliders move: they are not told here that they are
    /// back.
    ///
    /// # Errors
    /// [`ClothError::State`] if the snapshot is of another mesh or damaged: the cloth then stays as it is.
    pub fn restore(&mut self, snapshot: &ClothSnapshot) -> Result<(), ClothError> {
        let count = self.binding.representatives.len();
        let previous = snapshot.previous_positions.as_deref().or_else(|| snapshot.physics.earlier_positions());
        let previous = previous.unwrap_or_else(|| snapshot.positions());
        let usable = |anchor: &DAffine3| anchor.is_finite() && anchor.matrix3.determinant() != 0.0;
        let fits = previous.len() == count
            && previous.iter().all(|position| position.is_finite())
            && snapshot.anchors.iter().all(usable)
            && snapshot.colliders.iter().all(|(_, place, turn)| place.is_finite() && turn.is_normalized())
            && snapshot.pace.pending.is_finite()
            && snapshot.step_length.is_finite();
        if !fits {
            return Err(ClothError::State { reason: "it is of another mesh, or damaged".into() });
        }
        self.restore_physics(snapshot)?;
        [self.anchor, self.previous_anchor, self.seen_anchor] = snapshot.anchors;
        self.previous_positions.clear();
        self.previous_positions.extend_from_slice(previous);
        self.pace = snapshot.pace;
        self.ticks = snapshot.ticks;
        self.stepped = snapshot.stepped;
        self.suspended = snapshot.suspended;
        self.step_length = snapshot.step_length;
        self.follower.go_on(&snapshot.follower);
        self.placed = snapshot.placed;
        self.met.clear();
        let pose = |&(id, translation, rotation)| (id, Pose { translation, rotation });
        self.resumed = snapshot.colliders.iter().map(pose).collect();
        self.report = None;
        self.faults.state = None;
        self.faults.diverged = None;
        self.revision += 1;
        Ok(())
    }

    /// The rest shape is measured again if it was under another transform: a turn alone changes its last digits.
    fn restore_physics(&mut self, snapshot: &ClothSnapshot) -> Result<(), ClothError> {
        let Self { cloth, binding, .. } = self;
        if snapshot.rest_linear == binding.rest_linear {
            return Ok(cloth.restore(&snapshot.physics)?);
        }
        let shape = rest_shape(&binding.mesh, snapshot.rest_linear, &binding.options)?;
        let representatives = representatives(&shape);
        let mut measured = Cloth::new(shape, *cloth.fabric(), *cloth.settings())?;
        measured.restore(&snapshot.physics)?;
        *cloth = measured;
        binding.representatives = representatives;
        binding.rest_linear = snapshot.rest_linear;
        Ok(())
    }

    /// Puts the simulated vertices where a game wants them, in the world, m, with velocities, m/s: a draped start, say, worked out
    /// beforehand. [`simulated_vertex`](Self::simulated_vertex) says which vertex of the mesh is which. Held vertices go back to where
    /// they are held in the next step.
    ///
    /// ```
    /// # use bevy::math::DVec3;
    /// # use bevy::prelude::*;
    /// # use bevy_cloth::plugin::{ClothError, ClothState};
    /// # fn drape(mut state: Mut<ClothState>, draped: &[DVec3]) -> Result<(), ClothError> {
    /// state.set_positions_and_velocities(draped, &vec![DVec3::ZERO; draped.len()])?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`ClothError::State`] if there is not one of each for every simulated vertex, or one is not finite: the cloth then stays as it
    /// is.
    pub fn set_positions_and_velocities(
        &mut self,
        positions: &[DVec3],
        velocities: &[DVec3],
    ) -> Result<(), ClothError> {
        self.cloth.try_set_state(positions, velocities)?;
        self.settle();
        self.faults.state = None;
        Ok(())
    }
}

fn ways(Met { id, start, end, .. }: &Met) -> (u64, [DVec3; 2], [DQuat; 2]) {
    (*id, [start.translation, end.translation], [start.rotation, end.rotation])
}

/// What the picture was led around, of those that are there still.
fn meet_again(snapshot: &ClothSnapshot, tracks: &Query<Tracked>) -> Vec<Met> {
    let pose = |translation, rotation| Pose { translation, rotation };
    let again = |&(id, [a, b], [q, r]): &(u64, [DVec3; 2], [DQuat; 2])| {
        let (entity, _, track) = tracks.iter().find(|(_, known, _)| known.0 == id)?;
        let (shape, _) = track.present()?;
        Some(Met { entity, id, shape: shape.clone(), start: pose(a, q), end: pose(b, r) })
    };
    snapshot.met.iter().filter_map(again).collect()
}

type Tracked<'a> = (Entity, &'a ClothId, &'a Track);
type Standing<'a> = (Entity, &'a mut Track, &'a GlobalTransform);

/// Observer of [`ClothRestore`].
pub(super) fn restore(
    restore: On<ClothRestore>,
    mut commands: Commands,
    transforms: TransformHelper,
    mut cloths: Query<Option<&mut ClothState>, With<ClothMesh>>,
    mut tracks: ParamSet<(Query<Standing>, Query<Tracked>)>,
    mut motions: ResMut<Motions>,
    places: Query<&Transform>,
) {
    let ClothRestore { entity, snapshot } = restore.event();
    let Ok(state) = cloths.get_mut(*entity) else { return };
    let Some(mut state) = state else {
        if let Ok(mut entity) = commands.get_entity(*entity) {
            entity.try_insert(snapshot.clone());
        }
        return;
    };
    let restored = state.restore(snapshot);
    if restored.is_ok() {
        motions.forget_all(&places);
        state.met = meet_again(snapshot, &tracks.p1());
        for (entity, mut track, propagated) in &mut tracks.p0() {
            track.stand(&transforms.compute_global_transform(entity).unwrap_or(*propagated));
        }
    }
    state.faults.state = restored.err();
}

/// What starts beside a snapshot begins in its state.
pub(super) fn begin(
    mut commands: Commands,
    mut cloths: Query<(Entity, &mut ClothState, &ClothSnapshot), Added<ClothState>>,
    tracks: Query<Tracked>,
) {
    for (entity, mut state, snapshot) in &mut cloths {
        state.faults.state = state.restore(snapshot).err();
        state.met = meet_again(snapshot, &tracks);
        if let Ok(mut entity) = commands.get_entity(entity) {
            entity.try_remove::<ClothSnapshot>();
        }
    }
}
