//! Colliders of Avian.

use std::sync::Arc;

use avian3d::prelude::{Collider, ColliderDisabled, ColliderOf, Friction, PhysicsSystems, RigidBodyDisabled, Sensor};
use bevy::ecs::schedule::InternedScheduleLabel;
use bevy::prelude::*;
use parry3d::shape::SharedShape;

use super::collider::ClothCollider;
use super::engines::{ClothPhysicsCollider, Suspended, suspend, take_over};
use super::error::ClothColliderError;
use super::surface::surface;
use crate::plugin::ClothSystems;

pub(in crate::plugin) fn plugin(app: &mut App, schedule: InternedScheduleLabel) {
    app.add_observer(end)
        // In the schedule of Avian, cloth meets bodies where they have come to.
        .configure_sets(schedule, ClothSystems::Collect.after(PhysicsSystems::Last))
        .add_systems(
            schedule,
            adopt
                .before(super::rebuild)
                .in_set(ClothSystems::Collect)
                .run_if(any_with_component::<ClothPhysicsCollider>),
        );
}

/// A mesh of triangles as Avian has it, and what was made of it.
#[derive(Component)]
struct Rebuilt {
    theirs: SharedShape,
    ours: SharedShape,
}

type Marked<'a> = (
    Entity,
    &'a Collider,
    Option<&'a Friction>,
    Option<&'a ColliderOf>,
    Option<&'a ClothCollider>,
    Option<&'a Suspended>,
    Option<&'a Rebuilt>,
    Has<Sensor>,
    Has<ColliderDisabled>,
);

/// Takes over shapes as they are before scale, which cloth applies itself; the friction of a body counts for its colliders.
fn adopt(
    mut commands: Commands,
    colliders: Query<Marked, With<ClothPhysicsCollider>>,
    frictions: Query<&Friction>,
    disabled_bodies: Query<(), With<RigidBodyDisabled>>,
) {
    for (entity, collider, friction, of, current, suspended, rebuilt, sensor, disabled) in &colliders {
        let body = of.map_or(entity, |of| of.body);
        if sensor || disabled || disabled_bodies.contains(body) {
            suspend(&mut commands, entity, current);
            continue;
        }
        let friction = friction.or_else(|| frictions.get(body).ok()).map(|friction| friction.dynamic_coefficient);
        let theirs = collider.shape();
        let known = rebuilt.filter(|rebuilt| Arc::ptr_eq(&rebuilt.theirs.0, &theirs.0));
        let shape = known.map(|known| known.ours.clone()).or_else(|| {
            let ours = with_sides(theirs)?;
            if let Ok(mut entity) = commands.get_entity(entity) {
                entity.try_insert(Rebuilt { theirs: theirs.clone(), ours: ours.clone() });
            }
            Some(ours)
        });
        take_over(&mut commands, entity, current, suspended, shape.as_ref().unwrap_or(theirs), friction);
    }
}

/// A mesh of triangles that does not say which side of it is outside, made anew so that it does.
fn with_sides(shape: &SharedShape) -> Option<SharedShape> {
    let mesh = shape.as_trimesh().filter(|mesh| mesh.pseudo_normals_if_oriented().is_none())?;
    surface(mesh.vertices(), mesh.indices()).ok()
}

/// Takes the collider of cloth away with that of the engine.
fn end(removed: On<Remove, Collider>, marked: Query<(), With<ClothPhysicsCollider>>, mut commands: Commands) {
    if marked.contains(removed.entity)
        && let Ok(mut entity) = commands.get_entity(removed.entity)
    {
        entity.try_remove::<(ClothCollider, ClothColliderError, Rebuilt)>();
    }
}
