//! Colliders reach the physics where they are and as they move.

use std::f32::consts::FRAC_PI_2;
use std::time::Duration;

use crate::common::*;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::physics::{Collider, Pose};
use bevy_cloth::plugin::*;

/// Beside the sheet.
const AT: Transform = Transform::from_xyz(0.5, -0.5, 0.1);

fn ball(app: &mut App, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn((ClothCollider::sphere(0.2), bundle)).id()
}

#[track_caller]
fn assert_pose(pose: Pose, translation: DVec3, rotation: DQuat) {
    assert!(pose.translation.abs_diff_eq(translation, 1e-5), "{pose:?} is not at {translation}");
    assert!(pose.rotation.angle_between(rotation) < 1e-3, "{pose:?} is not turned by {rotation}");
}

/// The one collider of each step since the last call.
fn take_one(app: &mut App, cloth: Entity) -> Vec<Collider> {
    let steps = take_given(app, cloth);
    steps.into_iter().map(|step| <[Collider; 1]>::try_from(step).expect("one collider")).map(|[one]| one).collect()
}

#[test]
fn a_world_without_colliders_gives_none() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 5);
    assert!(take_given(&mut app, cloth).iter().all(Vec::is_empty));
}

#[test]
fn a_collider_at_rest_is_where_its_entity_is_and_goes_with_it() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let collider = ball(&mut app, AT.with_rotation(Quat::from_rotation_y(1.0)));
    run(&mut app, 25);
    let steps = take_one(&mut app, cloth);
    assert!(steps.len() >= 24);
    for given in &steps {
        assert_eq!((given.id, given.friction), (id(&app, collider), 0.5));
        assert_eq!(given.start, given.end, "it does not move");
        assert_pose(given.end, AT.translation.as_dvec3(), DQuat::from_rotation_y(1.0));
        assert_eq!(given.shape.as_ball().expect("a ball").radius, 0.2);
    }
    app.world_mut().entity_mut(collider).remove::<ClothCollider>();
    run(&mut app, 2);
    assert!(take_given(&mut app, cloth).iter().all(Vec::is_empty));
    app.world_mut().entity_mut(collider).insert(ClothCollider::sphere(0.1).with_friction(0.9));
    run(&mut app, 1);
    let given = take_one(&mut app, cloth).pop().expect("a step");
    assert_eq!((given.shape.as_ball().unwrap().radius, given.friction), (0.1, f64::from(0.9_f32)));
    app.world_mut().despawn(collider);
    run(&mut app, 1);
    assert!(take_given(&mut app, cloth)[0].is_empty());
}

#[test]
fn a_moving_child_is_followed_through_each_step() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let parent = app.world_mut().spawn(Transform::default()).id();
    ball(&mut app, (AT, ChildOf(parent)));
    run(&mut app, 1);
    take_given(&mut app, cloth);
    let parent_at = |tick: i32| {
        let t = tick as f32;
        Transform::from_xyz(0.01 * t, 0.0, -0.005 * t).with_rotation(Quat::from_rotation_z(0.03 * t))
    };
    let pose_at = |tick: i32| (parent_at(tick) * AT).to_isometry();
    for tick in 1..20 {
        set_transform(&mut app, parent, parent_at(tick));
        app.update();
        let given = take_one(&mut app, cloth).pop().expect("a step");
        for (pose, expected) in [(given.start, pose_at(tick - 1)), (given.end, pose_at(tick))] {
            assert_pose(pose, expected.translation.as_dvec3(), expected.rotation.as_dquat());
        }
    }
}

#[test]
fn a_step_of_several_ticks_sees_the_way_through_all_of_them() {
    for (quality, interval) in [(ClothQuality::Low, 2), (ClothQuality::Crowd, 4)] {
        let mut app = app_with_notes();
        let cloth = spawn(&mut app, sheet(), (top_edge(), quality));
        ball(&mut app, AT);
        run(&mut app, 20);
        take_given(&mut app, cloth);
        for tick in 1..=40 {
            let mut transform = AT;
            transform.translation.x += 0.01 * tick as f32;
            let entity = app.world_mut().query_filtered::<Entity, With<ClothCollider>>().single(app.world()).unwrap();
            set_transform(&mut app, entity, transform);
            app.update();
        }
        let steps = take_one(&mut app, cloth);
        assert!(
            state(&app, cloth).last_report().is_some_and(|r| r.outcome == bevy_cloth::physics::StepOutcome::Accepted)
        );
        assert_eq!(steps.len(), 40 / interval);
        for (before, given) in steps.iter().zip(&steps[1..]) {
            assert_eq!(before.end, given.start, "no part of the way is left out");
            let moved = given.end.translation.x - given.start.translation.x;
            assert!((moved - 0.01 * interval as f64).abs() < 1e-5, "{moved}");
        }
    }
}

#[test]
fn a_new_or_teleported_collider_has_no_velocity() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), (top_edge(), ClothQuality::Crowd));
    run(&mut app, 8);
    let collider = ball(&mut app, AT.with_translation(Vec3::new(0.5, 100.0, 0.0)));
    run(&mut app, 8);
    assert!(take_given(&mut app, cloth).iter().all(Vec::is_empty), "too far away");
    set_transform(&mut app, collider, AT);
    run(&mut app, 4);
    let given = take_one(&mut app, cloth).pop().expect("a step");
    assert_eq!(given.start, given.end);

    // Below the speed it is a motion.
    let nearer = AT.with_translation(AT.translation - Vec3::Y);
    set_transform(&mut app, collider, nearer);
    run(&mut app, 4);
    let given = take_one(&mut app, cloth).pop().expect("a step");
    assert_pose(given.start, AT.translation.as_dvec3(), DQuat::IDENTITY);
    assert_pose(given.end, nearer.translation.as_dvec3(), DQuat::IDENTITY);
    app.world_mut().get_mut::<ClothCollider>(collider).unwrap().teleport_speed = 32.0;
    set_transform(&mut app, collider, AT);
    run(&mut app, 4);
    let given = take_one(&mut app, cloth).pop().expect("a step");
    assert_eq!(given.start, given.end);
}

/// The limit is a speed: the same at every length of a tick.
#[test]
fn from_which_speed_on_a_collider_jumps_does_not_depend_on_ticks() {
    let cases = [(None, 95.0, false), (None, 105.0, true), (Some(5.0), 4.5, false), (Some(5.0), 5.5, true)];
    for (hz, (limit, speed, jumps)) in [30.0, 60.0, 240.0].into_iter().flat_map(|hz| cases.map(|case| (hz, case))) {
        let mut app = app_with_notes();
        let way = Vec3::X * speed / hz as f32;
        let go = move |mut colliders: Query<&mut Transform, With<ClothCollider>>| {
            colliders.iter_mut().for_each(|mut transform| transform.translation += way);
        };
        app.insert_resource(Time::<Fixed>::from_hz(hz)).add_systems(FixedUpdate, go.before(ClothSystems::Collect));
        let cloth = spawn(&mut app, sheet(), top_edge());
        let collider = ball(&mut app, AT.with_translation(AT.translation - 3.0 * way));
        if let Some(limit) = limit {
            app.world_mut().get_mut::<ClothCollider>(collider).unwrap().teleport_speed = limit;
        }
        run(&mut app, 3);
        let last = take_given(&mut app, cloth).pop().expect("a step");
        let [given] = &last[..] else { panic!("it is there: {last:?}") };
        assert_pose(given.end, AT.translation.as_dvec3(), DQuat::IDENTITY);
        let moved = given.start.translation.distance(given.end.translation);
        let wanted = if jumps { 0.0 } else { f64::from(way.x) };
        assert!((moved - wanted).abs() < 1e-4, "{speed} m/s at {hz} Hz: {moved}");
    }
}

#[test]
fn it_is_as_large_as_it_looks_and_may_grow() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let parent = app.world_mut().spawn(Transform::from_scale(Vec3::splat(2.0))).id();
    let turned = AT.with_translation(0.5 * AT.translation).with_rotation(Quat::from_rotation_z(FRAC_PI_2));
    let collider = ball(&mut app, (turned, ChildOf(parent)));
    let radius = |app: &mut App| {
        let given = take_one(app, cloth).pop().expect("a step");
        assert_pose(given.end, AT.translation.as_dvec3(), DQuat::from_rotation_z(f64::from(FRAC_PI_2)));
        given.shape.as_ball().map(|ball| ball.radius)
    };
    run(&mut app, 2);
    assert!((radius(&mut app).unwrap() - 0.4).abs() < 1e-6);
    set_transform(&mut app, collider, turned.with_scale(Vec3::splat(0.5)));
    run(&mut app, 2);
    assert!((radius(&mut app).unwrap() - 0.2).abs() < 1e-6);
    // No ball any more.
    set_transform(&mut app, collider, turned.with_scale(Vec3::new(0.5, 1.0, 0.5)));
    run(&mut app, 2);
    let given = take_one(&mut app, cloth).pop().expect("a step");
    let aabb = given.shape.compute_local_aabb();
    assert_near(aabb.maxs, Vec3::new(0.2, 0.4, 0.2), 1e-4);
}

#[test]
fn nothing_moves_while_the_clock_stands_still() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let collider = ball(&mut app, AT);
    run(&mut app, 5);
    take_given(&mut app, cloth);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    run(&mut app, 5);
    assert!(take_given(&mut app, cloth).is_empty());
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    set_transform(&mut app, collider, AT.with_translation(AT.translation + 0.1 * Vec3::X));
    run(&mut app, 1);
    let given = take_one(&mut app, cloth).pop().expect("a step");
    assert!((given.end.translation.x - given.start.translation.x - 0.1).abs() < 1e-6);
}

#[test]
fn a_disabled_cloth_keeps_no_collider_that_is_gone() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let collider = ball(&mut app, AT);
    run(&mut app, 3);
    app.world_mut().entity_mut(cloth).insert(ClothDisabled);
    app.world_mut().despawn(collider);
    run(&mut app, 2);
    assert!(state(&app, cloth).cloth().colliders().is_empty());
}

#[test]
fn touches_are_told_to_who_asks() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), (ClothContacts::default(), Transform::from_xyz(0.0, 1.1, 0.0)));
    let floor = app.world_mut().spawn(ClothCollider::half_space(Dir3::Y)).id();
    for _ in 0..60 {
        app.update();
        let expected = state(&app, cloth).cloth().contacts();
        let told = app.world().get::<ClothContacts>(cloth).unwrap();
        assert_eq!(told.len(), expected.count());
        assert!(told.iter().all(|touch| touch.collider == floor && touch.normal.abs_diff_eq(Vec3::Y, 1e-4)));
    }
    assert!(!app.world().get::<ClothContacts>(cloth).unwrap().is_empty());
}

/// The physics keeps coarse cloth further off what is round than the plugin looked.
#[test]
fn a_collider_is_given_from_as_far_as_the_physics_reaches() {
    let mut app = app_with_notes();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(), ClothPins::indices(0..COUNT));
    let gap = 3.5 * ClothContact::default().thickness;
    let ball = ball(&mut app, Transform::from_xyz(0.5, -0.5, 0.2 + gap));
    run(&mut app, 2);
    // It has to be stepped, and all of it is held: what it was given is told by its physics.
    assert_eq!(given_in_last_step(&mut app, cloth), [ball]);
}
