//! Cloth that pushes bodies of Avian.

use avian3d::prelude::{
    ColliderOf, ComputedMass, Forces, Gravity, GravityScale, ReadRigidBodyForces, WriteRigidBodyForces,
};
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::schedule::InternedScheduleLabel;
use bevy::math::DVec3;
use bevy::prelude::*;

use crate::physics::{Cloth, StepOutcome};
use crate::plugin::id::ClothId;
use crate::plugin::state::ClothState;
use crate::plugin::{ClothSystems, budget, step};

/// On a dynamic rigid body of Avian: cloth that touches its colliders pushes it.
///
/// After each step of a cloth, each contact pushes the body with the opposite of the impulse that the cloth received, at the place of
/// the contact. The sum of these impulses is limited, because a step of the cloth treats every body as infinitely heavy: the impulse
/// computed for a light body may be far too large. The body receives at most the impulse that
///
/// 1. stops it against the cloth,
/// 2. carries its weight,
/// 3. returns the energy that the cloth took from the body since they met.
///
/// So a body leaves a cloth no faster than it came. Its speed is measured against the held vertices of the cloth, because these are
/// moved by the game; against the average of all vertices if none is held.
///
/// Weight and speed of a body are those of the coming step of Avian. Give bodies their real masses: a body that is much lighter than
/// the cloth beside it is carried, but follows the cloth less closely.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Accounts)]
pub struct ClothPushes;

/// Time in which a cloth forgets what it took from a body, s. A ball of 20 kg is in a hammock for half a second; what lies in it for long
/// should not be thrown by what was lost to damping.
const FORGETS: f64 = 2.0;

/// What cloths took from a body since they met, by cloth, J.
#[derive(Component, Default)]
struct Accounts(EntityHashMap<Account>);

#[derive(Default)]
struct Account {
    energy: f64,
    /// Whether they touch in this tick.
    touches: bool,
}

/// Velocities of each cloth before the step of this tick, m/s.
#[derive(Resource, Default)]
struct Before(EntityHashMap<Vec<DVec3>>);

/// What a contact gives to a body.
struct Push {
    body: Entity,
    /// N s.
    impulse: Vec3,
    /// In the world, m.
    point: Vec3,
    vertices: [u32; 3],
    weights: [f64; 3],
}

pub(in crate::plugin) fn plugin(app: &mut App, schedule: InternedScheduleLabel) {
    app.register_type::<ClothPushes>().init_resource::<Before>().add_systems(
        schedule,
        (
            remember.before(step::step).in_set(ClothSystems::Step),
            push.after(super::tell).after(budget::observe).in_set(ClothSystems::Step),
        )
            .run_if(any_with_component::<ClothPushes>),
    );
}

fn remember(cloths: Query<(Entity, &ClothState)>, mut before: ResMut<Before>) {
    before.0.retain(|&cloth, _| cloths.contains(cloth));
    for (entity, state) in &cloths {
        let velocities = before.0.entry(entity).or_default();
        velocities.clear();
        velocities.extend_from_slice(state.cloth.velocities());
    }
}

type Pushed<'a> = (Forces, &'a ComputedMass, Option<&'a GravityScale>, &'a mut Accounts);

/// Hands the impulses of this tick's steps to the bodies.
fn push(
    time: Res<Time>,
    gravity: Res<Gravity>,
    before: Res<Before>,
    cloths: Query<(Entity, &ClothState, Option<&ClothId>)>,
    colliders: Query<&ColliderOf>,
    mut bodies: Query<Pushed, With<ClothPushes>>,
) {
    let mut pushes = Vec::new();
    // In the same order in every run.
    for (cloth, state, _) in cloths.iter().sort::<Option<&ClothId>>() {
        let accepted = |outcome: &StepOutcome| *outcome == StepOutcome::Accepted;
        if !state.report_of_this_tick().is_some_and(|report| accepted(&report.outcome)) {
            continue;
        }
        pushes.extend(state.cloth.contacts().filter_map(|contact| {
            let collider = state.collider(contact.collider)?;
            let body = colliders.get(collider).map_or(collider, |of| of.body);
            bodies.contains(body).then_some(Push {
                body,
                impulse: (-contact.force * state.step_length()).as_vec3(),
                point: contact.point.as_vec3(),
                vertices: contact.vertices,
                weights: contact.weights,
            })
        }));
        pushes.sort_by_key(|push| push.body);
        for of_body in pushes.chunk_by(|a, b| a.body == b.body) {
            let Ok((mut forces, mass, scale, mut accounts)) = bodies.get_mut(of_body[0].body) else { continue };
            let fall = gravity.0 * scale.map_or(1.0, |scale| scale.0) * time.delta_secs();
            let account = accounts.0.entry(cloth).or_default();
            account.touches = true;
            let against = Against {
                fall: fall - velocity_of(&state.cloth).as_vec3(),
                swung: before
                    .0
                    .get(&cloth)
                    .map_or(0.0, |before| swing(of_body, &state.cloth, before, &forces, fall, mass)),
            };
            apply(&mut forces, of_body, against, account);
        }
        pushes.clear();
    }
    let kept = (-time.delta_secs_f64() / FORGETS).exp();
    for (.., mut accounts) in &mut bodies {
        accounts.0.retain(|cloth, account| {
            account.energy *= kept;
            // In ticks between the steps of a cloth nothing is known.
            let stepped = cloths.get(*cloth).map_or(true, |(_, state, _)| state.report_of_this_tick().is_some());
            core::mem::replace(&mut account.touches, !stepped) || !stepped
        });
    }
}

/// What a body is pushed against.
struct Against {
    /// What is added to the velocity of the body, m/s: that of gravity in the coming step, against that of the cloth.
    fall: Vec3,
    /// Energy that the touching part of the cloth came with, J.
    swung: f64,
}

/// Gives a body as much of the impulses as it may have.
///
/// A share s of them does the work `s A + s² B` on its way through the coming step, with A = Σ J·v, where v is the velocity of the
/// body at each of them with that of gravity, and B = Σ J·Δv, with Δv what the whole of them changes it by. Where A + B is not
/// positive, the body is slowed down, and at most stopped. Else only what the cloth took before is given back.
fn apply(forces: &mut impl WriteAndRead, pushes: &[Push], against: Against, account: &mut Account) {
    let power = |forces: &dyn Fn(Vec3) -> Vec3| -> f64 {
        pushes.iter().map(|push| f64::from(push.impulse.dot(forces(push.point)))).sum()
    };
    let start = power(&|point| forces.at(point) + against.fall);
    pushes.iter().for_each(|push| forces.push(push.impulse, push.point));
    let gained = power(&|point| forces.at(point) + against.fall) - start;
    let most = account.energy + against.swung;
    let share = share(start, gained, most);
    if share < 1.0 {
        pushes.iter().for_each(|push| forces.push(-(1.0 - share) as f32 * push.impulse, push.point));
    }
    account.energy = (account.energy - share * (start + share * gained)).max(0.0);
}

/// The largest share s, at most 1, for which `s a + s² b` is not more than `most`.
fn share(a: f64, b: f64, most: f64) -> f64 {
    if a + b <= most || b <= 0.0 {
        return 1.0;
    }
    (((a * a + 4.0 * b * most).sqrt() - a) / (2.0 * b)).clamp(0.0, 1.0)
}

/// What [`apply`] needs of a body.
trait WriteAndRead {
    /// Velocity of the body at a place of the world, m/s.
    fn at(&self, point: Vec3) -> Vec3;
    /// Gives it an impulse there, N s.
    fn push(&mut self, impulse: Vec3, point: Vec3);
}

impl<F: ReadRigidBodyForces + WriteRigidBodyForces> WriteAndRead for F {
    fn at(&self, point: Vec3) -> Vec3 {
        self.velocity_at_point(point)
    }

    fn push(&mut self, impulse: Vec3, point: Vec3) {
        self.apply_linear_impulse_at_point(impulse, point);
    }
}

/// Velocity that counts as that of the cloth, m/s.
fn velocity_of(cloth: &Cloth) -> DVec3 {
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for (vertex, _) in cloth.pinned() {
        sum += cloth.velocities()[vertex as usize];
        count += 1.0;
    }
    if count > 0.0 {
        return sum / count;
    }
    let masses = cloth.masses();
    let momentum: DVec3 = masses.iter().zip(cloth.velocities()).map(|(&mass, &velocity)| mass * velocity).sum();
    momentum / masses.iter().sum::<f64>()
}

/// Energy that vertices and body would lose together if they had no more speed against each other, along the impulses, J: what cloth
/// that is at rest but for that part may give.
fn swing(
    pushes: &[Push],
    cloth: &Cloth,
    before: &[DVec3],
    forces: &impl ReadRigidBodyForces,
    fall: Vec3,
    mass: &ComputedMass,
) -> f64 {
    let mut vertices: Vec<u32> = pushes.iter().flat_map(|push| push.vertices).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let patch: f64 = vertices.iter().map(|&vertex| cloth.masses()[vertex as usize]).sum();
    let (mut closing, mut all) = (0.0, f64::MIN_POSITIVE);
    for push in pushes {
        let places = push.vertices.iter().zip(push.weights);
        let velocity: DVec3 = places.map(|(&vertex, weight)| weight * before[vertex as usize]).sum();
        let against = velocity.as_vec3() - forces.velocity_at_point(push.point) - fall;
        closing += f64::from(push.impulse.dot(against).max(0.0));
        all += f64::from(push.impulse.length());
    }
    let speed = closing / all;
    let reduced = 1.0 / (1.0 / patch + f64::from(mass.inverse()));
    0.5 * reduced * speed * speed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of 1 kg that cannot turn.
    struct Ball(Vec3);

    impl WriteAndRead for Ball {
        fn at(&self, _: Vec3) -> Vec3 {
            self.0
        }

        fn push(&mut self, impulse: Vec3, _: Vec3) {
            self.0 += impulse;
        }
    }

    fn pushed(velocity: f32, impulse: f32, fall: f32, account: &mut Account) -> f32 {
        let mut ball = Ball(Vec3::Y * velocity);
        let push = Push {
            body: Entity::PLACEHOLDER,
            impulse: Vec3::Y * impulse,
            point: Vec3::ZERO,
            vertices: [0; 3],
            weights: [1.0, 0.0, 0.0],
        };
        apply(&mut ball, &[push], Against { fall: Vec3::Y * fall, swung: 0.0 }, account);
        ball.0.y
    }

    #[test]
    fn too_much_stops_a_body_and_no_more() {
        assert!(pushed(-3.0, 1000.0, 0.0, &mut Account::default()).abs() < 1e-3);
        assert_eq!(pushed(-3.0, 1.0, 0.0, &mut Account::default()), -2.0);
        assert_eq!(pushed(0.5, 1000.0, 0.0, &mut Account::default()), 0.5, "it goes away already");
    }

    #[test]
    fn weight_is_carried() {
        let mut account = Account::default();
        for _ in 0..1000 {
            assert!((pushed(0.0, 0.16, -0.16, &mut account) - 0.16).abs() < 1e-6);
            assert!((pushed(0.0, 50.0, -0.16, &mut account) - 0.16).abs() < 1e-3);
        }
        assert!(account.energy < 1e-6, "{}", account.energy);
    }

    #[test]
    fn what_was_taken_is_given_back_but_once() {
        let mut account = Account::default();
        let mut velocity = -4.0;
        for _ in 0..100 {
            velocity = pushed(velocity, 0.5, 0.0, &mut account);
        }
        assert!(velocity <= 4.0 && velocity > 3.0, "{velocity}");
        assert!(account.energy < 1e-3);
    }
}
