//! Colliders of physics engines as colliders of cloth.

use std::sync::Arc;

use bevy::prelude::*;
use parry3d::shape::SharedShape;

use super::collider::ClothCollider;
use super::error::ClothColliderError;

/// Beside a collider of Avian or Rapier: makes it a [`ClothCollider`] too, with its shape and friction, and keeps it one as
/// that changes. [`ClothCollider::teleport_speed`] may be set on what is made.
///
/// A collider that is a child of a rigid body is marked itself, and has its own transform. While it is a sensor, or it or its body is
/// disabled, it is no collider of cloth either. A mesh of triangles is taken over as [`ClothCollider::trimesh`] would make it, whatever
/// flags the engine has it with.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform)]
pub struct ClothPhysicsCollider;

/// The [`ClothCollider::teleport_speed`] of a collider that is none for now, m/s.
#[derive(Component)]
pub(super) struct Suspended(f32);

/// Brings the collider of an entity up to date.
pub(super) fn take_over(
    commands: &mut Commands,
    entity: Entity,
    current: Option<&ClothCollider>,
    suspended: Option<&Suspended>,
    shape: &SharedShape,
    friction: Option<f32>,
) {
    let friction = friction.unwrap_or(ClothCollider::FRICTION);
    let same = |current: &ClothCollider| Arc::ptr_eq(&current.shape().0, &shape.0) && current.friction == friction;
    if current.is_some_and(same) {
        return;
    }
    let teleport_speed = current.map(|current| current.teleport_speed).or(suspended.map(|suspended| suspended.0));
    if let Ok(mut entity) = commands.get_entity(entity) {
        let collider = ClothCollider::undescribed(shape.clone()).with_friction(friction);
        let teleport_speed = teleport_speed.unwrap_or(ClothCollider::TELEPORT_SPEED);
        entity.try_insert(collider.with_teleport_speed(teleport_speed)).try_remove::<Suspended>();
    }
}

/// Takes the collider of an entity away that is a sensor or disabled.
pub(super) fn suspend(commands: &mut Commands, entity: Entity, current: Option<&ClothCollider>) {
    if let Some(current) = current
        && let Ok(mut entity) = commands.get_entity(entity)
    {
        let suspended = Suspended(current.teleport_speed);
        entity.try_insert(suspended).try_remove::<(ClothCollider, ClothColliderError)>();
    }
}

/// Takes the collider away with its mark.
pub(in crate::plugin) fn end_mark(removed: On<Remove, ClothPhysicsCollider>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<(ClothCollider, ClothColliderError, Suspended)>();
    }
}
