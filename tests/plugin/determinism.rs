//! The same bits in every run, wherever entities are in memory.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

use crate::common::*;

fn dummies(app: &mut App, count: usize) {
    (0..count).for_each(|_| _ = app.world_mut().spawn(Name::new("dummy")));
}

/// Two cloths among three colliders, with so many other entities before and between.
fn motion(before: usize, between: usize, far: usize, reorder: bool) -> Vec<Vec<DVec3>> {
    let mut app = app();
    dummies(&mut app, before);
    // What is despawned leaves room that others are put into, the last first.
    let gaps: Vec<_> = (0..between).map(|_| app.world_mut().spawn_empty().id()).collect();
    gaps.into_iter().for_each(|gap| _ = app.world_mut().despawn(gap));
    let shapes = [ClothCollider::sphere(0.3), ClothCollider::cuboid(0.3, 0.5, 0.4), ClothCollider::capsule(0.2, 0.4)];
    for (i, shape) in shapes.into_iter().enumerate() {
        let collider = app.world_mut().spawn((shape, Transform::from_xyz(0.2 + 0.3 * i as f32, -0.7, 0.1))).id();
        dummies(&mut app, between);
        if reorder && i == 0 {
            // Another table: it comes last in queries.
            app.world_mut().entity_mut(collider).insert(Name::new("first"));
        }
    }
    for i in 0..far {
        app.world_mut().spawn((ClothCollider::sphere(1.0), Transform::from_xyz(0.0, 100.0 + 3.0 * i as f32, 0.0)));
    }
    let cloths: Vec<_> = [(ClothQuality::Medium, 0.0), (ClothQuality::Crowd, 0.05)]
        .into_iter()
        .map(|(quality, z)| {
            dummies(&mut app, between);
            let transform = Transform::from_xyz(0.0, 0.0, z);
            let handle = Mesh3d(add_mesh(&mut app, sheet()));
            let bundle = (handle, ClothMesh::default(), top_edge(), quality, transform);
            app.world_mut().spawn(bundle).id()
        })
        .collect();
    run(&mut app, 90);
    cloths.into_iter().map(|cloth| state(&app, cloth).cloth().positions().to_vec()).collect()
}

#[test]
fn where_entities_are_in_memory_does_not_matter() {
    let alone = motion(0, 0, 0, false);
    for (before, between) in [(0, 0), (13, 0), (1, 3), (200, 7)] {
        for reorder in [false, true] {
            assert!(motion(before, between, 0, reorder) == alone, "{before} before, {between} between, {reorder}");
        }
    }
}

#[test]
fn far_colliders_change_nothing() {
    let ids_of_cloths_differ = motion(0, 0, 4, false)[0].clone();
    assert!(ids_of_cloths_differ == motion(0, 0, 0, false)[0]);
}

/// The ids say what is known from before, not the order.
#[test]
fn given_ids_are_kept_and_their_colliders_come_in_order() {
    let mut app = app_with_notes();
    let far = |i: usize| Transform::from_xyz(0.3 * i as f32, -0.5, 0.0);
    let balls: Vec<_> = [30, 10, 20]
        .into_iter()
        .enumerate()
        .map(|(i, id)| app.world_mut().spawn((ClothCollider::sphere(0.3), far(i), ClothId(id))).id())
        .collect();
    let cloth = spawn(&mut app, sheet(), top_edge());
    app.world_mut().entity_mut(cloth).insert(ClothContacts::default());
    run(&mut app, 2);
    let last = take_given(&mut app, cloth).pop().expect("a step");
    assert_eq!(last.iter().map(|collider| collider.id).collect::<Vec<_>>(), [10, 20, 30]);
    assert_eq!(id(&app, balls[0]), 30);
    assert!(id(&app, cloth) > 30);
    let touches = app.world().get::<ClothContacts>(cloth).unwrap();
    assert!(!touches.is_empty() && touches.iter().all(|touch| balls.contains(&touch.collider)));
    // Each at the collider that it names.
    for touch in touches.iter() {
        let centre = app.world().get::<Transform>(touch.collider).unwrap().translation;
        assert!((touch.point.distance(centre) - 0.3).abs() < 0.1);
    }
}
