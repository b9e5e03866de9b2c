//! Back to rest, and the end of a cloth.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::prelude::*;

use super::components::ClothMesh;
use super::error::ClothError;
use super::parts::release;
use super::saving::ClothSource;
use super::sources::Sources;
use super::state::{ClothState, usable};

/// Trigger it to put a cloth back to rest, undeformed, where its entity is now:
/// `commands.trigger(ClothReset { entity })`.
#[derive(EntityEvent, Clone, Copy, Debug, Reflect)]
pub struct ClothReset {
    /// The cloth.
    pub entity: Entity,
}

pub(super) fn reset(
    reset: On<ClothReset>,
    transforms: TransformHelper,
    mut cloths: Query<(&mut ClothState, &GlobalTransform)>,
) {
    let Ok((mut state, propagated)) = cloths.get_mut(reset.entity) else { return };
    let transform = transforms.compute_global_transform(reset.entity).unwrap_or(*propagated);
    let anchor = usable(&transform).unwrap_or(state.anchor);
    state.faults.state = None;
    state.rest_at(anchor);
}

/// The mesh stays as it was draped, and is that of no cloth any more. With the whole entity gone, clones of it may still show
/// the mesh: for them it stands for its source.
pub(super) fn end(removed: On<Remove, ClothMesh>, cloths: Query<&ClothState>, mut commands: Commands) {
    let entity = removed.entity;
    let parts = cloths.get(entity).into_iter().flat_map(|state| state.parts());
    let parts: Vec<_> = parts.map(|part| (part.entity(), part.own_mesh().id())).collect();
    commands.queue(move |world: &mut World| {
        let Ok(mut cloth) = world.get_entity_mut(entity) else { return };
        cloth.remove::<(ClothState, ClothSource, ClothError, NoAutoAabb)>();
        for (part, own) in parts {
            world.resource_mut::<Sources>().forget(own);
            if part != entity {
                world.entity_mut(entity).remove::<Aabb>();
                if let Ok(part) = world.get_entity_mut(part) {
                    release(part);
                }
            }
        }
    });
}
