//! The ball: thrown, falling, bouncing, and pushed back by the cloth that it meets.
//!
//! Cloth does not push a [`ClothCollider`]. What it would push with is in [`ClothContacts`], and any body can take that up.

use bevy::prelude::*;
use bevy_cloth::{plugin::ClothSystems, prelude::*};
use example_common::{
    clock::SceneClock,
    props::{solid, varnished},
};

/// In metres; with the mass, that of a basketball.
pub const RADIUS: f32 = 0.12;
/// In kilograms.
const MASS: f32 = 0.62;

/// Where it is thrown from, in metres.
const HAND: Vec3 = Vec3::new(0.10, 1.05, 2.3);
/// How it is thrown, in metres per second.
const THROW: Vec3 = Vec3::new(-0.2, 1.9, -6.0);
/// When, in seconds: the curtain has settled.
pub const THROWN_AT: f32 = 0.55;

/// Speed after a bounce, relative to that before it.
const BOUNCE: f32 = 0.7;
/// Share of the speed along the ground that a bounce leaves, and so does each step of rolling.
const ROLL: f32 = 0.985;

#[derive(Component)]
pub struct Ball {
    /// In metres per second.
    pub velocity: Vec3,
}

pub fn plugin(app: &mut App) {
    app.add_systems(FixedUpdate, (fly.before(ClothSystems::Collect), take_push.after(ClothSystems::Step)));
}

pub fn build(world: &mut World) {
    let rubber = varnished(world, Color::srgb(0.85, 0.32, 0.08));
    let mut ball = solid(world, Sphere::new(RADIUS), &rubber, Transform::from_translation(HAND));
    ball.insert((Name::new("Ball"), Ball { velocity: THROW }));
    if let Some(mut collider) = ball.get_mut::<ClothCollider>() {
        // Back to the hand it jumps.
        collider.teleport_speed = 30.0;
    }
}

fn fly(clock: Res<SceneClock>, time: Res<Time>, mut balls: Query<(&mut Ball, &mut Transform)>) {
    for (mut ball, mut transform) in &mut balls {
        if clock.0 < THROWN_AT {
            ball.velocity = THROW;
            transform.translation = HAND;
            continue;
        }
        ball.velocity += Vec3::new(0.0, -9.81, 0.0) * time.delta_secs();
        transform.translation += ball.velocity * time.delta_secs();
        if transform.translation.y < RADIUS {
            transform.translation.y = RADIUS;
            let rise = -BOUNCE * ball.velocity.y;
            ball.velocity *= ROLL;
            ball.velocity.y = rise.max(0.0);
        }
    }
}

/// The ball feels the opposite of what it does to the cloth.
fn take_push(time: Res<Time>, cloths: Query<&ClothContacts>, mut balls: Query<&mut Ball>) {
    for touch in cloths.iter().flat_map(|contacts| contacts.iter()) {
        if let Ok(mut ball) = balls.get_mut(touch.collider) {
            ball.velocity -= touch.force / MASS * time.delta_secs();
        }
    }
}
