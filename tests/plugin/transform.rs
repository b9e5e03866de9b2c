//! Cloth under transforms: hierarchy, scale, motion, jumps.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_3};

use crate::common::*;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

fn set(app: &mut App, entity: Entity, transform: Transform) {
    *app.world_mut().get_mut(entity).unwrap() = transform;
}

#[test]
fn a_scaled_turned_child_hangs_down_in_the_world_and_is_as_large_as_it_looks() {
    let mut app = app();
    let parent_at = Transform::from_xyz(5.0, 3.0, -2.0)
        .with_rotation(Quat::from_rotation_z(FRAC_PI_2))
        .with_scale(Vec3::splat(2.0));
    let child_at = Transform::from_xyz(0.5, 0.0, 0.0).with_rotation(Quat::from_rotation_x(FRAC_PI_3));
    let parent = app.world_mut().spawn(parent_at).id();
    let cloth = spawn(&mut app, sheet(), (child_at, ClothPins::indices([0]), ChildOf(parent)));
    run(&mut app, 200);

    let mass: f64 = state(&app, cloth).cloth().masses().iter().sum();
    assert!((mass - 0.15 * 4.0).abs() < 1e-6, "2 m × 2 m of cotton weigh 600 g, not {mass}");
    let world = world(&app, cloth);
    assert_near(world[0], (parent_at * child_at).translation, 1e-5);
    let mean = world.iter().sum::<Vec3>() / COUNT as f32;
    assert!(mean.y < world[0].y - 0.5, "hangs along −Y of the world: {mean}");
    let simulated = state(&app, cloth).cloth().positions();
    assert_near(world[12], simulated[12].as_vec3(), 1e-5);
}

#[test]
fn held_vertices_follow_a_moving_parent_exactly_and_without_lag() {
    let mut app = app();
    let parent = app.world_mut().spawn(Transform::default()).id();
    let cloth = spawn(&mut app, sheet(), (top_edge(), ChildOf(parent)));
    for frame in 1..60 {
        let t = frame as f32 / 60.0;
        let moved = Transform::from_xyz(2.0 * t, t.sin(), 0.0).with_rotation(Quat::from_rotation_y(t));
        set(&mut app, parent, moved);
        app.update();
        let rest = vectors(&sheet(), Mesh::ATTRIBUTE_POSITION);
        for (now, rest) in local(&app, cloth).iter().zip(rest).take(CELLS as usize + 1) {
            assert_near(*now, rest, 1e-6);
        }
    }
    let trailing = world(&app, cloth)[COUNT as usize - 1];
    assert!(trailing.distance(world(&app, cloth)[CELLS as usize]) < 1.01 && trailing.y > -0.5, "{trailing}");
}

#[test]
fn a_step_sees_the_transform_that_the_same_tick_set() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), top_edge());
    app.add_systems(
        FixedUpdate,
        (|mut transforms: Query<&mut Transform>| transforms.single_mut().unwrap().translation.x += 0.01)
            .before(ClothSystems::Collect),
    );
    for step in 1..5 {
        app.update();
        let held = state(&app, cloth).cloth().positions()[0].x;
        assert!((held - 0.01 * f64::from(step)).abs() < 1e-6, "{held} after {step}");
    }
}

#[test]
fn a_free_cloth_does_not_follow_its_transform() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ());
    app.insert_resource(ClothGravity(Vec3::ZERO));
    for _ in 0..10 {
        app.world_mut().get_mut::<Transform>(cloth).unwrap().translation.x += 0.3;
        app.update();
        assert_near(world(&app, cloth)[7], vectors(&sheet(), Mesh::ATTRIBUTE_POSITION)[7], 1e-5);
    }
}

#[test]
fn a_jump_carries_the_cloth_with_its_folds() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    run(&mut app, 40);
    let before = state(&app, cloth).cloth().positions().to_vec();
    let speed = state(&app, cloth).cloth().velocities()[20].length();
    let jump = Transform::from_xyz(100.0, 50.0, 0.0).with_rotation(Quat::from_rotation_y(FRAC_PI_2));
    set(&mut app, cloth, jump);
    app.world_mut().resource_mut::<ClothGravity>().0 = Vec3::ZERO;
    app.update();
    let after = state(&app, cloth).cloth();
    for (before, after) in before.iter().zip(after.positions()) {
        let carried = jump.transform_point(before.as_vec3());
        // One step of free motion besides.
        assert_near(after.as_vec3(), carried, 2.0 * speed as f32 / 64.0 + 0.01);
    }
    assert!(after.stretch().max < 0.02, "not dragged: {:?}", after.stretch());

    // Below the speed of a jump it is dragged instead.
    app.world_mut().entity_mut(cloth).insert(ClothInertia::unlimited());
    set(&mut app, cloth, jump.with_translation(jump.translation + Vec3::X * 1.9));
    app.update();
    assert!(state(&app, cloth).cloth().stretch().max > 0.05, "{:?}", state(&app, cloth).cloth().stretch());
}

#[test]
fn a_new_scale_remeasures_the_cloth_and_keeps_the_deformation() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), (top_edge(), ClothMaterial(*ClothMaterial::silk())));
    run(&mut app, 100);
    let before = local(&app, cloth);
    set(&mut app, cloth, Transform::from_scale(Vec3::splat(3.0)));
    app.update();
    let running = state(&app, cloth).cloth();
    assert!((running.masses().iter().sum::<f64>() - 0.06 * 9.0).abs() < 1e-6);
    assert!(running.stretch().max < 0.01, "{:?}", running.stretch());
    for (before, after) in before.iter().zip(local(&app, cloth)) {
        assert_near(*before, after, 0.01);
    }
    assert_eq!(running.positions()[4], DVec3::new(3.0, 0.0, 0.0));
}

#[test]
fn an_unusable_transform_freezes_the_cloth_until_it_is_usable_again() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 5);
    let before = local(&app, cloth);
    for bad in [Transform::from_scale(Vec3::new(1.0, 0.0, 1.0)), Transform::from_xyz(f32::NAN, 0.0, 0.0)] {
        set(&mut app, cloth, bad);
        run(&mut app, 3);
        assert!(matches!(error(&app, cloth), Some(ClothError::Transform)), "{:?}", error(&app, cloth));
        assert_eq!(local(&app, cloth), before);
    }
    set(&mut app, cloth, Transform::from_xyz(1.0, 0.0, 0.0));
    run(&mut app, 2);
    assert!(error(&app, cloth).is_none());
    assert_near(world(&app, cloth)[0], Vec3::X, 1e-6);
    assert_near(local(&app, cloth)[20], before[20], 0.05);
}

/// Runs a cloth for so many frames, with this scale in each.
fn rescaled(app: &mut App, cloth: Entity, frames: u32, scale: impl Fn(u32) -> Vec3) {
    for frame in 0..frames {
        app.world_mut().get_mut::<Transform>(cloth).unwrap().scale = scale(frame);
        app.update();
    }
}

/// Two cloths that start at once.
fn pair(app: &mut App, bundle: impl Bundle + Clone, at: Transform) -> [Entity; 2] {
    let cloths = [0, 1].map(|_| {
        let mesh3d = Mesh3d(add_mesh(app, sheet()));
        app.world_mut().spawn((mesh3d, ClothMesh::default(), bundle.clone(), at)).id()
    });
    app.update();
    cloths
}

#[test]
fn a_free_cloth_grows_about_its_own_middle() {
    let mut app = app();
    let [cloth, beside] = pair(&mut app, (), Transform::from_xyz(0.0, 5.0, 0.0));
    let middle = |app: &App, cloth| world(app, cloth).iter().sum::<Vec3>() / COUNT as f32;
    run(&mut app, 40);
    let before = middle(&app, cloth) - middle(&app, beside);
    rescaled(&mut app, cloth, 30, |frame| Vec3::splat(1.0 + 0.1 * (frame as f32 * 0.7).sin()));
    // 2 m below its entity: a tenth of that would show.
    assert_near(middle(&app, cloth) - middle(&app, beside), before, 0.005);
    let simulated = state(&app, cloth).cloth();
    assert!(simulated.stretch().max < 1e-3, "{:?}", simulated.stretch());
    rescaled(&mut app, cloth, 1, |_| Vec3::new(-1.0, 1.0, 1.0));
    assert_near(middle(&app, cloth) - middle(&app, beside), before, 0.005);
}

#[test]
fn a_scale_animated_every_frame_does_not_stop_the_swing() {
    let mut app = app();
    let [plain, breathing] = pair(&mut app, ClothPins::indices([0]), Transform::default());
    run(&mut app, 5);
    let fastest =
        |app: &App, cloth| state(app, cloth).cloth().velocities().iter().map(|v| v.length()).fold(0.0, f64::max);
    let mut speeds = [0.0_f64; 2];
    for frame in 0..60 {
        app.world_mut().get_mut::<Transform>(breathing).unwrap().scale = Vec3::splat(1.0 + 0.01 * (frame % 2) as f32);
        app.update();
        speeds = [speeds[0].max(fastest(&app, plain)), speeds[1].max(fastest(&app, breathing))];
    }
    assert!((speeds[0] - speeds[1]).abs() < 0.15 * speeds[0], "{speeds:?}");
    assert!(state(&app, breathing).cloth().stretch().max < 0.05);
}

#[test]
fn a_scale_that_changes_while_the_entity_moves_leaves_the_cloth_behind_as_any_move_does() {
    let mut app = app();
    let [plain, breathing] = pair(&mut app, top_edge(), Transform::default());
    for frame in 0..20 {
        for cloth in [plain, breathing] {
            let mut transform = app.world_mut().get_mut::<Transform>(cloth).unwrap();
            transform.translation.z = 0.1 * frame as f32;
            transform.rotation = Quat::from_rotation_y(0.03 * frame as f32);
        }
        app.world_mut().get_mut::<Transform>(breathing).unwrap().scale = Vec3::splat(1.0 + 0.002 * (frame % 2) as f32);
        app.update();
    }
    let hem = |app: &App, cloth| world(app, cloth)[COUNT as usize - 3];
    assert!(hem(&app, plain).z < 1.6, "{}", hem(&app, plain));
    assert_near(hem(&app, breathing), hem(&app, plain), 0.05);
}

#[test]
fn facing_about_by_a_mirror_keeps_swing_and_shape() {
    let mut app = app();
    let [cloth, plain] = pair(&mut app, (ClothPins::indices([0]), ClothMaterial::denim()), Transform::default());
    for flip in 0..6 {
        let side = if flip % 2 == 0 { -1.0 } else { 1.0 };
        let before = local(&app, cloth);
        rescaled(&mut app, cloth, 1, |_| Vec3::new(side, 1.0, 1.0));
        // In its own space it goes on as if nothing had been.
        let moved = local(&app, cloth).iter().zip(before).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
        assert!(moved < 0.15, "{moved}");
        run(&mut app, 7);
    }
    let speed = |cloth| state(&app, cloth).cloth().velocities()[24].length();
    assert!((speed(cloth) - speed(plain)).abs() < 0.5, "{} and {}", speed(cloth), speed(plain));
}

#[test]
fn an_absolute_weld_distance_joins_other_vertices_at_another_scale() {
    let mut app = app();
    let mesh3d = Mesh3d(add_mesh(&mut app, sheet()));
    let welded = ClothMesh { weld_distance: Some(0.05), ..default() };
    let cloth = app.world_mut().spawn((mesh3d, welded, ClothPins::indices([0]))).id();
    run(&mut app, 2);
    assert_eq!(state(&app, cloth).cloth().shape().vertex_count(), COUNT as usize);
    set(&mut app, cloth, Transform::from_scale(Vec3::splat(0.1)));
    app.update();
    let few = state(&app, cloth).cloth().shape().vertex_count();
    assert!(few < COUNT as usize, "{few}");
    assert!(error(&app, cloth).is_none());
}
