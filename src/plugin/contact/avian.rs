//! Colliders of Avian, and cloth that pushes its bodies.

use avian3d::prelude::{Collider, ColliderOf, Forces, Friction, WriteRigidBodyForces};
use bevy::ecs::schedule::InternedScheduleLabel;
use bevy::prelude::*;

use super::collider::ClothCollider;
use super::engines::{ClothPhysicsCollider, take_over};
use super::error::ClothColliderError;
use crate::physics::StepOutcome;
use crate::plugin::id::ClothId;
use crate::plugin::state::ClothState;
use crate::plugin::{ClothSystems, budget};

/// On a dynamic rigid body of Avian: cloth that touches its colliders pushes it.
///
/// After each step of a cloth, the body receives the opposite of the impulses that its colliders gave to the cloth, where they
/// gave them. To the cloth a body is as heavy as can be during a step: one that is much lighter than the cloth on it may
/// jitter, the more so the longer the steps.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothPushes;

pub(in crate::plugin) fn plugin(app: &mut App, schedule: InternedScheduleLabel) {
    app.add_observer(end)
        .register_type::<ClothPushes>()
        .add_systems(
            schedule,
            adopt.before(super::track).in_set(ClothSystems::Collect).run_if(any_with_component::<ClothPhysicsCollider>),
        )
        .add_systems(
            schedule,
            push.after(super::tell)
                .after(budget::observe)
                .in_set(ClothSystems::Step)
                .run_if(any_with_component::<ClothPushes>),
        );
}

type Marked<'a> = (Entity, &'a Collider, Option<&'a Friction>, Option<&'a ColliderOf>, Option<&'a ClothCollider>);

/// Takes over shapes as they are before scale, which cloth applies itself; the friction of a body counts for its colliders.
fn adopt(mut commands: Commands, colliders: Query<Marked, With<ClothPhysicsCollider>>, frictions: Query<&Friction>) {
    for (entity, collider, friction, of, current) in &colliders {
        let of_body = || frictions.get(of?.body).ok();
        let friction = friction.or_else(of_body).map(|friction| friction.dynamic_coefficient);
        take_over(&mut commands, entity, current, collider.shape(), friction);
    }
}

/// Takes the collider of cloth away with that of the engine.
fn end(removed: On<Remove, Collider>, marked: Query<(), With<ClothPhysicsCollider>>, mut commands: Commands) {
    if marked.contains(removed.entity)
        && let Ok(mut entity) = commands.get_entity(removed.entity)
    {
        entity.try_remove::<(ClothCollider, ClothColliderError)>();
    }
}

/// Hands the impulses of this tick's steps to the bodies, in the same order in every run.
fn push(
    cloths: Query<(&ClothState, Option<&ClothId>)>,
    colliders: Query<&ColliderOf>,
    mut bodies: Query<Forces, With<ClothPushes>>,
) {
    let stepped =
        |state: &&ClothState| state.report_of_this_tick().is_some_and(|report| report.outcome == StepOutcome::Accepted);
    for state in cloths.iter().sort::<Option<&ClothId>>().map(|(state, _)| state).filter(stepped) {
        for contact in state.cloth.contacts() {
            let Some(collider) = state.collider(contact.collider) else { continue };
            let body = colliders.get(collider).map_or(collider, |of| of.body);
            if let Ok(mut forces) = bodies.get_mut(body) {
                let impulse = -contact.force * state.step_length();
                forces.apply_linear_impulse_at_point(impulse.as_vec3(), contact.point.as_vec3());
            }
        }
    }
}
