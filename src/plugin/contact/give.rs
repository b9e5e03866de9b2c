//! The colliders that each cloth may touch in its next step.

use bevy::math::DVec3;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::bounds::Bounds;
use super::collider::ClothCollider;
use super::layers::{ClothCollidesWith, ClothLayers};
use super::track::Track;
use crate::physics::{Cloth, Collider};
use crate::plugin::budget::Keeper;
use crate::plugin::state::ClothState;

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
    colliders: Query<(&ClothCollider, &Track)>,
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
            let bounds = reach_of_step(&state.cloth, state.pace.pending + time.delta_secs_f64());
            let layers = layers.copied().unwrap_or_default();
            let wanted = |&(collider, its): &(Entity, ClothLayers)| {
                collider != entity && layers.interacts_with(its) && only.is_none_or(|only| only.contains(&collider))
            };
            given.extend(surroundings.near(bounds).filter(wanted).filter_map(|(entity, _)| {
                let (collider, track) = colliders.get(entity).ok()?;
                track.bounds_since(ticks)?.overlaps(&bounds).then_some(())?;
                let (shape, end) = track.present()?;
                Some(Collider {
                    id: entity.to_bits(),
                    shape: shape.clone(),
                    start: track.pose_before(ticks)?,
                    end,
                    friction: collider.friction.into(),
                })
            }));
        }
        let takes_away = due || surroundings.colliders.is_empty();
        if !given.is_empty() || (takes_away && !state.cloth.colliders().is_empty()) {
            // Their poses and friction were checked where they were tracked.
            let _ = state.cloth.set_colliders(given.drain(..));
        }
        surroundings.held |= !state.cloth.colliders().is_empty();
    }
    keeper.spent.collect += start.elapsed();
}

/// Around all places that a cloth can come to in a step of `dt` seconds: no vertex goes further than the fastest does, gravity
/// besides, or than a held one is taken.
fn reach_of_step(cloth: &Cloth, dt: f64) -> Bounds {
    let bounds = cloth.positions().iter().fold(Bounds::EMPTY, |bounds, &position| bounds.with(position));
    let speed = cloth.velocities().iter().map(|v| v.length_squared()).fold(0.0, f64::max).sqrt();
    let pulled = |(vertex, target): (u32, DVec3)| cloth.positions()[vertex as usize].distance(target);
    let pull = cloth.pinned().map(pulled).fold(0.0, f64::max);
    let fall = speed * dt + cloth.gravity().length() * dt * dt;
    bounds.grown(cloth.contact_settings().reach() + fall.max(pull))
}
