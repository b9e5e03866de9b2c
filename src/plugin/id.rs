//! Numbers that tell cloths and colliders apart, the same in every run.

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

use super::components::ClothMesh;
use super::contact::ClothCollider;

/// Tells a cloth or a collider apart from others, in this run and in every other.
///
/// A cloth remembers its touches by the ids of colliders, colliders go to the physics in the order of their ids, and with
/// [`ClothQuality::Low`](super::ClothQuality::Low) or `Crowd` the id of a cloth decides in which ticks it is stepped. So the motion
/// depends on no [`Entity`], whose bits differ from run to run.
///
/// Every entity with a [`ClothMesh`] or [`ClothCollider`] that has none gets one: they are numbered in the order that they are
/// spawned in. It is saved with a world and loaded again; a clone gets one of its own. Insert your own, of a network or a save
/// game, where the order of spawning is not the same everywhere, as after loading assets: each must be given once only.
///
/// It cannot be changed in place: insert another.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Clone, Debug, PartialEq)]
#[component(immutable, on_insert = note, on_remove = give_later, clone_behavior = Custom(|_, _| {}))]
pub struct ClothId(pub u64);

impl ClothId {
    /// A number below `interval`: those of entities spawned one after another differ evenly.
    pub(super) fn phase(self, interval: u32) -> u32 {
        (self.0 % u64::from(interval)) as u32
    }
}

/// The next id that nobody has. Saved with a world, so that what is spawned after loading is numbered as it would have been.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Resource, Default, Clone, PartialEq)]
pub(super) struct NextClothId(u64);

/// Ids that are given are above those that are known.
fn note(mut world: DeferredWorld, HookContext { entity, .. }: HookContext) {
    let Some(&ClothId(id)) = world.get(entity) else { return };
    world.commands().queue(move |world: &mut World| {
        let mut next = world.get_resource_or_init::<NextClothId>();
        if id >= next.0 {
            next.0 = id.wrapping_add(1);
        }
    });
}

/// Hook of what needs an id: gives one, if the entity has none once all of it is there.
pub(super) fn give_later(mut world: DeferredWorld, HookContext { entity, .. }: HookContext) {
    world.commands().queue(move |world: &mut World| give(world, entity));
}

fn give(world: &mut World, entity: Entity) {
    let needs = world.get_entity(entity).is_ok_and(|entity| {
        !entity.contains::<ClothId>() && (entity.contains::<ClothMesh>() || entity.contains::<ClothCollider>())
    });
    if needs {
        let NextClothId(id) = *world.get_resource_or_init::<NextClothId>();
        world.entity_mut(entity).insert(ClothId(id));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_follow_the_order_of_spawning_and_those_given() {
        let mut world = World::new();
        let spawn = |world: &mut World| world.spawn(ClothCollider::sphere(1.0)).id();
        let id = |world: &World, entity| world.get::<ClothId>(entity).copied().map(|id| id.0);
        let first = spawn(&mut world);
        (0..5).for_each(|_| _ = world.spawn_empty());
        let second = spawn(&mut world);
        let given = world.spawn((ClothCollider::sphere(1.0), ClothId(41))).id();
        let third = spawn(&mut world);
        assert_eq!([first, second, given, third].map(|e| id(&world, e)), [Some(0), Some(1), Some(41), Some(42)]);
        let clone = world.entity_mut(second).clone_and_spawn();
        assert_eq!(id(&world, clone), Some(43));
        world.entity_mut(clone).remove::<ClothId>();
        assert_eq!(id(&world, clone), Some(44));
        world.despawn(clone);
    }
}
