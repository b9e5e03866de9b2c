//! The colliders that each cloth may touch in its next step.

use std::sync::Once;

use bevy::math::{DAffine3, DQuat, DVec3};
use bevy::platform::time::Instant;
use bevy::prelude::*;
use parry3d::shape::SharedShape;

use super::bounds::Bounds;
use super::collider::ClothCollider;
use super::layers::{ClothCollidesWith, ClothLayers};
use super::track::Track;
use crate::physics::{Cloth, Collider, Pose};
use crate::plugin::budget::Keeper;
use crate::plugin::follow::Carried;
use crate::plugin::id::ClothId;
use crate::plugin::state::ClothState;

/// A collider near a cloth, and its way through the last step.
pub(in crate::plugin) struct Met {
    pub entity: Entity,
    pub id: u64,
    pub shape: SharedShape,
    pub start: Pose,
    pub end: Pose,
}

/// All colliders of a tick, laid out so that those far from a cloth are passed over quickly.
#[derive(Resource, Default)]
pub(in crate::plugin) struct Surroundings {
    /// Around each collider on its way through the last ticks.
    reaches: Vec<Bounds>,
    colliders: Vec<(Entity, ClothLayers)>,
    /// Some cloth has colliders.
    pub held: bool,
}

impl Surroundings {
    pub(super) fn clear(&mut self) {
        self.reaches.clear();
        self.colliders.clear();
    }

    pub(super) fn add(&mut self, entity: Entity, layers: ClothLayers, reach: Bounds) {
        self.reaches.push(reach);
        self.colliders.push((entity, layers));
    }

    /// Colliders that may come near something in this tick.
    fn near(&self, bounds: Bounds) -> impl Iterator<Item = (Entity, ClothLayers)> {
        let reaches = self.reaches.iter().zip(&self.colliders);
        reaches.filter(move |(reach, _)| reach.overlaps(&bounds)).map(|(_, collider)| *collider)
    }
}

/// Hands the colliders near each cloth that is about to be stepped to its physics.
pub(in crate::plugin) fn give(
    time: Res<Time>,
    mut surroundings: ResMut<Surroundings>,
    mut keeper: ResMut<Keeper>,
    colliders: Query<(&ClothCollider, &Track, &ClothId)>,
    mut cloths: Query<(Entity, &mut ClothState, Option<&ClothLayers>, Option<&ClothCollidesWith>)>,
) {
    let start = Instant::now();
    let surroundings = &mut *surroundings;
    surroundings.held = false;
    let mut given = Vec::new();
    for (entity, mut state, layers, only) in &mut cloths {
        let due = !state.suspended && state.pace.is_due();
        if due && !surroundings.colliders.is_empty() {
            let ticks = state.pace.since + 1;
            let (bounds, seen) = reach_of_step(&state.cloth, state.pace.pending + time.delta_secs_f64());
            let carried = state.follower.carried;
            let middle = 0.5 * (bounds.min + bounds.max);
            let mut met = core::mem::take(&mut state.met);
            met.clear();
            let layers = layers.copied().unwrap_or_default();
            let before = core::mem::take(&mut state.resumed);
            let resumed = |id: u64| Some(before.iter().find(|(known, _)| *known == id)?.1);
            let wanted = |&(collider, its): &(Entity, ClothLayers)| {
                collider != entity && layers.interacts_with(its) && only.is_none_or(|only| only.contains(&collider))
            };
            given.extend(surroundings.near(seen).filter(wanted).filter_map(|(entity, _)| {
                let (collider, track, &ClothId(id)) = colliders.get(entity).ok()?;
                let (shape, end) = track.present()?;
                let start = match resumed(id) {
                    Some(start) => start,
                    None => carried.start(track.pose_before(ticks)?, end, middle),
                };
                let way = track.bounds()?.swept(&start, &end);
                if way.grown(track.lead()).overlaps(&seen) {
                    met.push(Met { entity, id, shape: shape.clone(), start, end });
                }
                way.overlaps(&bounds).then_some(())?;
                let given = Collider { id, shape: shape.clone(), start, end, friction: collider.friction.into() };
                Some((entity, given))
            }));
            state.met = met;
            // In an order that does not depend on where the entities are in memory.
            given.sort_by_key(|(_, collider)| collider.id);
            tell_twins(&given);
            state.near.clear();
            state.near.extend(given.iter().map(|(entity, collider)| (collider.id, *entity)));
        }
        let takes_away = due || surroundings.colliders.is_empty();
        if !given.is_empty() || (takes_away && !state.cloth.colliders().is_empty()) {
            // Their poses and friction were checked where they were tracked.
            let _ = state.cloth.set_colliders(given.drain(..).map(|(_, collider)| collider));
        }
        surroundings.held |= !state.cloth.colliders().is_empty();
    }
    keeper.spent.collect += start.elapsed();
}

impl Carried {
    /// Where a collider began its way to `end`, seen from a cloth that was carried meanwhile and is around `middle` now.
    fn start(&self, start: Pose, end: Pose, middle: DVec3) -> Pose {
        if self.map == DAffine3::IDENTITY {
            return start;
        }
        let carried = Pose {
            translation: self.map.transform_point3(start.translation),
            rotation: (DQuat::from_mat3(&self.map.matrix3) * start.rotation).normalize(),
        };
        let way = |start: &Pose| end.place(start.local(middle)).distance(middle);
        // What did not jump along has not moved against the cloth by as much.
        if self.jumped && way(&start) < way(&carried) { start } else { carried }
    }
}

/// How many times further than the physics the picture looks for colliders: it is up to a frame and a tick ahead of the step, and is led
/// around what is within three times the way from there.
const AHEAD: f64 = 8.0;

/// Two colliders of one id share what cloth remembers of them.
fn tell_twins(given: &[(Entity, Collider)]) {
    for pair in given.windows(2).filter(|pair| pair[0].1.id == pair[1].1.id) {
        let ((a, Collider { id, .. }), (b, _)) = (&pair[0], &pair[1]);
        static TOLD: Once = Once::new();
        TOLD.call_once(|| {
            tracing::warn!("cloth colliders {a} and {b} have the same `ClothId({id})`: give each its own, or none");
        });
    }
}

/// Around all places that a cloth can come to in a step of `dt` seconds: no vertex goes further than the fastest does, gravity
/// besides, or than a held one is taken. Then the same for its picture.
fn reach_of_step(cloth: &Cloth, dt: f64) -> (Bounds, Bounds) {
    let bounds = cloth.positions().iter().fold(Bounds::EMPTY, |bounds, &position| bounds.with(position));
    let speed = cloth.velocities().iter().map(|v| v.length_squared()).fold(0.0, f64::max).sqrt();
    let pulled = |(vertex, target): (u32, DVec3)| cloth.positions()[vertex as usize].distance(target);
    let pull = cloth.pinned().map(pulled).fold(0.0, f64::max);
    let way = (speed * dt + cloth.gravity().length() * dt * dt).max(pull);
    let reach = cloth.contact_settings().reach();
    (bounds.grown(reach + way), bounds.grown(reach + AHEAD * way))
}
