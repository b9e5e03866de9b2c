//! Which colliders a cloth is given: those near it that it may touch.

use crate::common::*;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

const NEAR: Transform = Transform::from_xyz(0.5, -0.5, 0.1);

fn ball(app: &mut App, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn((ClothCollider::sphere(0.2), bundle)).id()
}

fn sorted(mut entities: Vec<Entity>) -> Vec<Entity> {
    entities.sort();
    entities
}

#[test]
fn those_that_are_far_are_left_out() {
    let mut app = app_with_notes();
    app.insert_resource(ClothGravity(Vec3::new(0.0, -1.0, 0.0)));
    let cloth = spawn(&mut app, sheet(), top_edge());
    let near = ball(&mut app, NEAR);
    let touching = ball(&mut app, Transform::from_xyz(-0.2, 0.0, 0.0));
    for i in 0..1000 {
        ball(&mut app, Transform::from_xyz(5.0 + i as f32, 0.0, 0.0));
    }
    let above = ball(&mut app, Transform::from_xyz(0.5, 0.3, 0.0));
    run(&mut app, 1);
    assert_eq!(given_in_last_step(&mut app, cloth), sorted(vec![near, touching]));
    set_transform(&mut app, above, Transform::from_xyz(0.5, 0.1, 0.0));
    run(&mut app, 1);
    assert_eq!(given_in_last_step(&mut app, cloth), sorted(vec![near, touching, above]));
    set_transform(&mut app, near, NEAR.with_translation(Vec3::splat(50.0)));
    run(&mut app, 2);
    assert_eq!(given_in_last_step(&mut app, cloth), sorted(vec![touching, above]));
}

#[test]
fn those_that_come_by_are_kept() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), (top_edge(), ClothQuality::Crowd));
    let bullet = ball(&mut app, Transform::from_xyz(0.5, -0.5, 4.0));
    run(&mut app, 16);
    take_given(&mut app, cloth);
    for tick in 1..=8 {
        set_transform(&mut app, bullet, Transform::from_xyz(0.5, -0.5, 4.0 - tick as f32));
        app.update();
    }
    let steps = take_given(&mut app, cloth);
    assert_eq!(steps.len(), 2);
    assert!(steps.iter().any(|step| step.len() == 1), "it went through the cloth between two steps");
}

#[test]
fn a_fast_cloth_is_given_what_it_comes_to() {
    let mut app = app_with_notes();
    app.insert_resource(ClothGravity(Vec3::new(0.0, -64.0 * 64.0, 0.0)));
    let cloth = spawn(&mut app, sheet(), ());
    let below = ball(&mut app, Transform::from_xyz(0.5, -1.5, 0.0));
    run(&mut app, 1);
    assert_eq!(given_in_last_step(&mut app, cloth), [below], "1 m in a step");
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let held = spawn(&mut app, sheet(), ClothInertia::unlimited());
    let aside = ball(&mut app, Transform::from_xyz(2.5, 0.0, 0.0));
    app.world_mut().entity_mut(held).insert(ClothPinTargets([(4, Vec3::new(2.5, 0.0, 0.0))].into()));
    run(&mut app, 1);
    assert!(given_in_last_step(&mut app, held).contains(&aside), "dragged to it");
}

#[test]
fn a_half_space_is_near_wherever_it_is() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let floor = Transform::from_xyz(0.0, -300.0, 0.0).with_rotation(Quat::from_rotation_z(0.2));
    let floor = app.world_mut().spawn((ClothCollider::half_space(Dir3::Y), floor)).id();
    run(&mut app, 2);
    assert_eq!(given_in_last_step(&mut app, cloth), [floor]);
}

#[test]
fn layers_say_who_touches_whom() {
    let mut app = app_with_notes();
    let plain = spawn(&mut app, sheet(), top_edge());
    let cape = spawn(&mut app, sheet(), (top_edge(), ClothLayers::new(0b1, 0b110)));
    let all = ball(&mut app, NEAR);
    let body = ball(&mut app, (NEAR, ClothLayers::new(0b10, 0b1)));
    let shy = ball(&mut app, (NEAR, ClothLayers::new(0b100, 0b1000)));
    let ghost = ball(&mut app, (NEAR, ClothLayers::new(0, u32::MAX)));
    run(&mut app, 1);
    assert_eq!(given_in_last_step(&mut app, plain), sorted(vec![all, body, shy]));
    assert_eq!(given_in_last_step(&mut app, cape), sorted(vec![all, body]));
    app.world_mut().entity_mut(ghost).remove::<ClothLayers>();
    app.world_mut().get_mut::<ClothLayers>(shy).unwrap().filters = 0b1;
    run(&mut app, 1);
    assert_eq!(given_in_last_step(&mut app, cape), sorted(vec![all, body, shy, ghost]));
}

#[test]
fn a_list_limits_them() {
    let mut app = app_with_notes();
    let balls: [Entity; 3] = core::array::from_fn(|_| ball(&mut app, NEAR));
    let cloth = spawn(&mut app, sheet(), (top_edge(), ClothCollidesWith(vec![balls[1]])));
    run(&mut app, 1);
    assert_eq!(given_in_last_step(&mut app, cloth), [balls[1]]);
    app.world_mut().entity_mut(cloth).insert(ClothCollidesWith::default());
    run(&mut app, 1);
    assert!(given_in_last_step(&mut app, cloth).is_empty());
    app.world_mut().entity_mut(cloth).remove::<ClothCollidesWith>();
    run(&mut app, 1);
    assert_eq!(given_in_last_step(&mut app, cloth), sorted(balls.to_vec()));
}

#[test]
fn a_cloth_is_no_collider_for_itself() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), (top_edge(), ClothCollider::sphere(0.2)));
    let other = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 2);
    assert!(given_in_last_step(&mut app, cloth).is_empty());
    assert_eq!(given_in_last_step(&mut app, other), [cloth]);
}
