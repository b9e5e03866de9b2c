//! What may happen to a cloth while it runs: other settings, another mesh, freezing, reset, removal.

use crate::common::*;
use bevy::camera::visibility::NoAutoAabb;
use bevy::prelude::*;
use bevy_cloth::physics::{SolverKind, SolverSettings};
use bevy_cloth::plugin::*;

/// A cloth held by one corner that has swung for a while.
fn swinging() -> (App, Entity) {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    run(&mut app, 30);
    (app, cloth)
}

fn rest() -> Vec<Vec3> {
    vectors(&sheet(), Mesh::ATTRIBUTE_POSITION)
}

#[test]
fn a_new_material_acts_at_once_and_the_motion_goes_on() {
    let (mut app, cloth) = swinging();
    let before = state(&app, cloth).cloth().positions()[20];
    *app.world_mut().get_mut::<ClothMaterial>(cloth).unwrap() = ClothMaterial::rubber();
    app.update();
    let running = state(&app, cloth).cloth();
    assert!((running.masses().iter().sum::<f64>() - 1.1).abs() < 1e-6);
    assert!(running.positions()[20].distance(before) < 0.2);
    // Gravity and solver likewise.
    app.insert_resource(ClothGravity(Vec3::X));
    let settings = SolverSettings { kind: SolverKind::conjugate_gradient(1e-6), substeps: 3, ..default() };
    app.world_mut().entity_mut(cloth).insert(ClothSolver(settings));
    app.update();
    assert_eq!(state(&app, cloth).cloth().gravity(), bevy::math::DVec3::X);
    assert_eq!(*state(&app, cloth).cloth().settings(), settings);
}

#[test]
fn a_disabled_cloth_freezes_moves_with_its_entity_and_goes_on_from_there() {
    let (mut app, cloth) = swinging();
    let speed = state(&app, cloth).cloth().velocities().iter().map(|v| v.length()).fold(0.0, f64::max) as f32;
    app.world_mut().entity_mut(cloth).insert(ClothDisabled);
    app.update();
    take_modified(&mut app, cloth);
    let frozen = local(&app, cloth);
    // Less than the distance of a teleport.
    let at = Transform::from_xyz(0.5, 1.5, 0.0);
    *app.world_mut().get_mut::<Transform>(cloth).unwrap() = at;
    run(&mut app, 20);
    assert_eq!(local(&app, cloth), frozen);
    assert_eq!(take_modified(&mut app, cloth), 0);

    app.world_mut().entity_mut(cloth).remove::<ClothDisabled>();
    app.update();
    for (now, frozen) in world(&app, cloth).iter().zip(&frozen) {
        assert_near(*now, at.transform_point(*frozen), 1.5 * speed / 64.0);
    }
    assert_near(world(&app, cloth)[0], at.translation, 1e-6);
    run(&mut app, 5);
    assert_ne!(local(&app, cloth), frozen);
}

#[test]
fn reset_puts_the_cloth_to_rest_where_its_entity_is() {
    let (mut app, cloth) = swinging();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.world_mut().trigger(ClothReset { entity: cloth });
    app.update();
    assert_eq!(local(&app, cloth), rest());

    app.world_mut().get_mut::<Transform>(cloth).unwrap().translation.x = 1.0;
    app.world_mut().trigger(ClothReset { entity: cloth });
    app.update();
    let running = state(&app, cloth).cloth();
    for (vertex, rest) in rest().iter().enumerate() {
        assert_near(running.positions()[vertex].as_vec3(), *rest + Vec3::X, 1e-6);
        assert_near(local(&app, cloth)[vertex], *rest, 1e-6);
    }
    assert_eq!(running.energy().kinetic, 0.0);
}

#[test]
fn a_removed_cloth_stays_as_it_was_draped() {
    let (mut app, cloth) = swinging();
    let draped = local(&app, cloth);
    app.world_mut().entity_mut(cloth).remove::<ClothMesh>();
    run(&mut app, 10);
    assert_eq!(local(&app, cloth), draped);
    assert_ne!(draped, rest());
    assert!(app.world().get::<ClothState>(cloth).is_none() && app.world().get::<NoAutoAabb>(cloth).is_none());
}

#[test]
fn the_source_mesh_can_be_put_back() {
    let (mut app, cloth) = swinging();
    let source = state(&app, cloth).source_mesh().clone();
    app.world_mut().entity_mut(cloth).remove::<ClothMesh>().insert(Mesh3d(source));
    app.update();
    assert_eq!(local(&app, cloth), rest());
}

#[test]
fn a_despawned_cloth_takes_its_mesh_along() {
    let (mut app, cloth) = swinging();
    let own = state(&app, cloth).own_mesh().id();
    assert!(app.world().resource::<Assets<Mesh>>().contains(own));
    app.world_mut().entity_mut(cloth).despawn();
    run(&mut app, 3);
    assert!(!app.world().resource::<Assets<Mesh>>().contains(own));
}

#[test]
fn another_mesh_starts_again_at_rest() {
    let (mut app, cloth) = swinging();
    let wide = sheet().scaled_by(Vec3::new(2.0, 1.0, 1.0));
    let other = add_mesh(&mut app, wide.clone());
    app.world_mut().entity_mut(cloth).insert(Mesh3d(other.clone()));
    app.update();
    assert_eq!(state(&app, cloth).source_mesh(), &other);
    assert_eq!(local(&app, cloth), vectors(&wide, Mesh::ATTRIBUTE_POSITION));
    run(&mut app, 30);
    assert_near(world(&app, cloth)[0], Vec3::ZERO, 1e-6);
    assert!(world(&app, cloth)[4].y < -0.5);
    assert_eq!(vectors(app.world().resource::<Assets<Mesh>>().get(&other).unwrap(), Mesh::ATTRIBUTE_POSITION), {
        vectors(&wide, Mesh::ATTRIBUTE_POSITION)
    });
}

#[test]
fn an_edited_source_mesh_starts_again_at_rest() {
    let (mut app, cloth) = swinging();
    let source = state(&app, cloth).source_mesh().clone();
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&source).unwrap() = sheet().translated_by(Vec3::Z);
    run(&mut app, 2);
    assert_near(local(&app, cloth)[24], rest()[24] + Vec3::Z, 1e-6);
    run(&mut app, 10);
    assert_ne!(local(&app, cloth)[24], rest()[24] + Vec3::Z, "built once, then it runs");
}

#[test]
fn another_description_starts_again_from_the_source() {
    let (mut app, cloth) = swinging();
    let source = state(&app, cloth).source_mesh().clone();
    app.world_mut().get_mut::<ClothMesh>(cloth).unwrap().warp_angle = 0.5;
    app.update();
    assert_eq!(local(&app, cloth), rest());
    assert_eq!(state(&app, cloth).source_mesh(), &source);
}
