//! Steps and frames: interpolation, pause, schedules, and no needless upload.

use std::time::Duration;

use crate::common::*;
use bevy::app::FixedPostUpdate;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::plugin::*;

/// A frame takes this many fixed steps of 1/64 s.
fn set_frame(app: &mut App, steps: f64) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(steps / 64.0)));
}

#[test]
fn interpolation_shows_the_cloth_between_two_steps() {
    let mut app = app_with(ClothPlugin::default());
    let cloth = spawn(&mut app, sheet(), ());
    set_frame(&mut app, 1.0);
    run(&mut app, 10);
    set_frame(&mut app, 0.25);
    let mut shown = Vec::new();
    let mut steps = Vec::new();
    for _ in 0..12 {
        app.update();
        shown.push(world(&app, cloth)[0].y);
        let simulated = state(&app, cloth).cloth().positions()[0].y as f32;
        if steps.last() != Some(&simulated) {
            steps.push(simulated);
        }
        let alpha = app.world().resource::<Time<Fixed>>().overstep_fraction();
        if let [.., before, now] = steps[..] {
            let between = before + alpha * (now - before);
            assert!((shown[shown.len() - 1] - between).abs() < 1e-5, "{shown:?} {between} at {alpha}");
        }
    }
    assert!(steps.len() >= 3);
    // Smooth: no frame moves much more than the one before.
    let moves: Vec<f32> = shown.windows(2).map(|pair| pair[0] - pair[1]).collect();
    assert!(moves.windows(2).all(|pair| pair[1] > 0.5 * pair[0] && pair[1] < 2.0 * pair[0]), "{moves:?}");
}

#[test]
fn without_interpolation_the_last_step_is_shown() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ());
    set_frame(&mut app, 0.25);
    for _ in 0..12 {
        app.update();
        assert_near(world(&app, cloth)[0], state(&app, cloth).cloth().positions()[0].as_vec3(), 1e-6);
    }
}

#[test]
fn held_vertices_keep_their_place_between_steps() {
    let mut app = app_with(ClothPlugin::default());
    let cloth = spawn(&mut app, sheet(), top_edge());
    set_frame(&mut app, 0.3);
    for frame in 0..60 {
        let t = 0.02 * frame as f32;
        let turned = Transform::from_xyz(t * 3.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(5.0 * t));
        *app.world_mut().get_mut::<Transform>(cloth).unwrap() = turned;
        app.update();
        for (vertex, rest) in vectors(&sheet(), Mesh::ATTRIBUTE_POSITION).iter().enumerate().take(5) {
            assert_near(local(&app, cloth)[vertex], *rest, 1e-6);
        }
    }
}

#[test]
fn a_jump_is_not_interpolated() {
    let mut app = app_with(ClothPlugin::default());
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    run(&mut app, 30);
    set_frame(&mut app, 0.5);
    for frame in 0..8 {
        let before = local(&app, cloth);
        let speed = state(&app, cloth).cloth().velocities().iter().map(|v| v.length()).fold(0.0, f64::max) as f32;
        app.world_mut().get_mut::<Transform>(cloth).unwrap().translation.x += 50.0;
        app.update();
        for (now, before) in local(&app, cloth).iter().zip(before) {
            assert_near(*now, before, 2.0 * speed / 64.0);
        }
        assert_near(local(&app, cloth)[0], Vec3::ZERO, 1e-5 * (frame + 1) as f32);
    }
}

#[test]
fn a_frame_writes_once_however_many_steps_it_takes() {
    for (steps, interpolated) in [(1.0, true), (3.0, true), (3.0, false), (0.25, true)] {
        let plugin = ClothPlugin { interpolate: interpolated, ..default() };
        let mut app = app_with(plugin);
        let cloth = spawn(&mut app, sheet(), top_edge());
        set_frame(&mut app, steps);
        run(&mut app, 8);
        take_modified(&mut app, cloth);
        let before = state(&app, cloth).cloth().positions()[20];
        run(&mut app, 8);
        assert_eq!(take_modified(&mut app, cloth), 8, "{steps} steps a frame");
        assert_ne!(state(&app, cloth).cloth().positions()[20], before);
    }
    // Four frames a step without interpolation: one write a step.
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), top_edge());
    set_frame(&mut app, 0.25);
    run(&mut app, 8);
    take_modified(&mut app, cloth);
    run(&mut app, 16);
    assert_eq!(take_modified(&mut app, cloth), 4);
}

#[test]
fn a_paused_game_neither_steps_nor_uploads() {
    for pins in [top_edge(), ClothPins::none()] {
        let mut app = app_with(ClothPlugin::default());
        let cloth = spawn(&mut app, sheet(), pins);
        set_frame(&mut app, 1.3);
        run(&mut app, 10);
        app.world_mut().resource_mut::<Time<Virtual>>().pause();
        run(&mut app, 2);
        let simulated = state(&app, cloth).cloth().positions().to_vec();
        let shown = local(&app, cloth);
        take_modified(&mut app, cloth);
        run(&mut app, 10);
        assert_eq!(take_modified(&mut app, cloth), 0);
        assert_eq!(state(&app, cloth).cloth().positions(), simulated);
        assert_eq!(local(&app, cloth), shown);
        app.world_mut().resource_mut::<Time<Virtual>>().unpause();
        run(&mut app, 2);
        assert_ne!(state(&app, cloth).cloth().positions(), simulated);
    }
}

#[test]
fn a_frozen_cloth_is_not_uploaded_and_moves_with_its_entity() {
    for pins in [top_edge(), ClothPins::none()] {
        let mut app = app_with(ClothPlugin::default());
        let cloth = spawn(&mut app, sheet(), pins);
        set_frame(&mut app, 0.3);
        run(&mut app, 20);
        app.world_mut().entity_mut(cloth).insert(ClothDisabled);
        app.update();
        take_modified(&mut app, cloth);
        let shown = local(&app, cloth);
        for _ in 0..10 {
            app.world_mut().get_mut::<Transform>(cloth).unwrap().translation.x += 0.1;
            app.update();
        }
        assert_eq!(take_modified(&mut app, cloth), 0);
        assert_eq!(local(&app, cloth), shown);

        // Likewise while its transform is unusable.
        app.world_mut().entity_mut(cloth).remove::<ClothDisabled>();
        run(&mut app, 20);
        app.world_mut().get_mut::<Transform>(cloth).unwrap().scale.y = 0.0;
        run(&mut app, 4);
        take_modified(&mut app, cloth);
        run(&mut app, 10);
        assert_eq!(take_modified(&mut app, cloth), 0);
    }
}

#[test]
fn a_new_cloth_is_not_written_before_it_moves() {
    let mut app = app();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    let cloth = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 5);
    assert_eq!(take_modified(&mut app, cloth), 0);
    assert_eq!(local(&app, cloth), vectors(&sheet(), Mesh::ATTRIBUTE_POSITION));
}

#[test]
fn other_schedules_step_too() {
    let mut fixed = app_with(ClothPlugin::new(FixedPostUpdate).without_interpolation());
    let cloth = spawn(&mut fixed, sheet(), ());
    set_frame(&mut fixed, 2.0);
    run(&mut fixed, 3);
    let after_fixed = world(&fixed, cloth)[0].y;

    // Steps of a frame each; interpolation has no meaning there and is off.
    let mut variable = app_with(ClothPlugin::new(Update));
    let cloth = spawn(&mut variable, sheet(), ());
    let start = world(&variable, cloth)[0].y;
    set_frame(&mut variable, 1.0);
    run(&mut variable, 6);
    let after_variable = world(&variable, cloth)[0].y;
    assert!((after_fixed - (after_variable - start)).abs() < 1e-5, "{after_fixed} {after_variable} {start}");
    assert!(after_fixed < -0.03, "{after_fixed}");

    variable.world_mut().resource_mut::<Time<Virtual>>().pause();
    run(&mut variable, 2);
    take_modified(&mut variable, cloth);
    run(&mut variable, 5);
    assert_eq!(world(&variable, cloth)[0].y, after_variable, "paused");
    assert_eq!(take_modified(&mut variable, cloth), 0);
}
