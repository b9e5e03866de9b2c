//! Colliders under a transform that is sheared: turned under a parent that is not scaled evenly.

use crate::common::*;
use bevy::math::{Affine3A, DVec3};
use bevy::prelude::*;
use bevy_cloth::plugin::*;

/// What a shape of the step is in the world: from a place in the frame of the entity, as it is drawn.
fn is_inside(app: &mut App, cloth: Entity, local: Vec3, drawn: Affine3A) -> bool {
    let given = take_given(app, cloth).pop().expect("a step").pop().expect("a collider");
    let world: DVec3 = drawn.transform_point3(local).as_dvec3();
    given.shape.contains_local_point(given.end.local(world).as_vec3())
}

/// It lay 298 mm from the corner that is drawn.
#[test]
fn a_sheared_collider_is_where_it_is_drawn() {
    let ball: Mesh = Sphere::new(0.3).mesh().uv(16, 8);
    let colliders = [
        (ClothCollider::cuboid(0.6, 0.6, 0.6), Vec3::splat(0.3)),
        (ClothCollider::from_mesh(&ball).unwrap(), Vec3::new(0.0, 0.3, 0.0)),
        (ClothCollider::sphere(0.3), Vec3::new(0.0, 0.3, 0.0)),
    ];
    for (collider, on) in colliders {
        for scale in [Vec3::new(1.0, 3.0, 1.0), Vec3::new(-2.0, 1.0, 1.0)] {
            let mut app = app_with_notes();
            let cloth = spawn(&mut app, sheet(), top_edge());
            let parent = app.world_mut().spawn(Transform::from_xyz(0.5, -0.5, 0.0).with_scale(scale)).id();
            let turned = Transform::from_rotation(Quat::from_rotation_z(0.6));
            let child = app.world_mut().spawn((collider.clone(), turned, ChildOf(parent))).id();
            run(&mut app, 3);
            let drawn = app.world().get::<GlobalTransform>(child).unwrap().affine();
            assert!(is_inside(&mut app, cloth, 0.93 * on, drawn), "{scale} {collider:?}");
            run(&mut app, 1);
            assert!(!is_inside(&mut app, cloth, 1.05 * on, drawn), "{scale} {collider:?}");
        }
    }
}

#[test]
fn what_only_turns_and_moves_keeps_its_shape() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let parent = app.world_mut().spawn(Transform::from_scale(Vec3::new(1.0, 2.0, 1.0))).id();
    let turned = Transform::from_rotation(Quat::from_rotation_z(0.6));
    app.world_mut().spawn((ClothCollider::cuboid(0.6, 0.6, 0.6), turned, ChildOf(parent)));
    run(&mut app, 2);
    take_given(&mut app, cloth);
    let mut shapes = Vec::new();
    for tick in 0..10 {
        let turn = Quat::from_rotation_y(0.02 * tick as f32);
        set_transform(&mut app, parent, Transform::from_rotation(turn).with_scale(Vec3::new(1.0, 2.0, 1.0)));
        run(&mut app, 1);
        shapes.push(take_given(&mut app, cloth).pop().expect("a step").pop().expect("a collider").shape);
    }
    assert!(shapes.iter().all(|shape| std::sync::Arc::ptr_eq(&shape.0, &shapes[0].0)));
}

#[test]
fn what_cannot_be_sheared_is_told() {
    let mut app = app();
    let parent = app.world_mut().spawn(Transform::from_scale(Vec3::new(1.0, 3.0, 1.0))).id();
    let round = ClothCollider::new(bevy_cloth::parry3d::shape::SharedShape::round_cuboid(0.1, 0.1, 0.1, 0.01));
    let turned = Transform::from_rotation(Quat::from_rotation_z(0.6));
    let child = app.world_mut().spawn((round, turned, ChildOf(parent))).id();
    spawn(&mut app, sheet(), top_edge());
    run(&mut app, 2);
    let error = collider_error(&app, child).expect("an error").to_string();
    assert!(error.contains("RoundCuboid") && error.contains("sheared"), "{error}");
    set_transform(&mut app, parent, Transform::IDENTITY);
    run(&mut app, 2);
    assert!(collider_error(&app, child).is_none());
}
