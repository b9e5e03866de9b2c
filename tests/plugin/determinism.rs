//! The same bits in every run, wherever entities are in memory, with any number of threads, and in another process.

use std::env;
use std::process::Command;

use bevy::ecs::schedule::SingleThreadedExecutor;
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

/// What moves in [`busy`].
#[derive(Component, Clone, Copy)]
struct Swayed(Transform);

fn sway(time: Res<Time>, mut swayed: Query<(&Swayed, &mut Transform)>, mut targets: Query<&mut ClothPinTargets>) {
    let (sin, cos) = (4.0 * time.elapsed_secs()).sin_cos();
    for (Swayed(about), mut transform) in &mut swayed {
        let turned = Quat::from_rotation_y(0.3 * cos);
        *transform = *about * Transform::from_xyz(0.2 * sin, 0.1 * cos, 0.2 * sin * cos).with_rotation(turned);
    }
    for mut targets in &mut targets {
        targets.values_mut().for_each(|place| place.z = 0.3 * sin);
    }
}

/// Threads that the steps had.
#[derive(Resource, Default)]
struct Threads(usize);

/// The motion of a second: a large cloth that is worked on in parts and small ones, on moving pins, among colliders that move and that
/// rest. Positions and velocities of all.
fn busy() -> (usize, Vec<DVec3>) {
    let mut app = app();
    app.init_resource::<Threads>()
        .add_systems(
            FixedUpdate,
            (sway, |mut threads: ResMut<Threads>| threads.0 = rayon::current_num_threads())
                .before(ClothSystems::Collect),
        )
        // Systems run in the thread that the app is updated in, and so in its pool.
        .edit_schedule(FixedUpdate, |schedule| _ = schedule.set_executor(SingleThreadedExecutor::new()));
    let large = Plane3d::new(Vec3::Z, Vec2::splat(1.0)).mesh().subdivisions(63).build();
    let swayed = |x: f32, y: f32| {
        let at = Transform::from_xyz(x, y, 0.0);
        (at, Swayed(at))
    };
    let world = app.world_mut();
    world.spawn((ClothCollider::sphere(0.3), swayed(0.0, -0.4)));
    world.spawn((ClothCollider::capsule(0.15, 0.5), swayed(2.4, -0.6)));
    world.spawn((ClothCollider::half_space(Dir3::Y), Transform::from_xyz(0.0, -0.8, 0.0)));
    let mut cloths = vec![spawn(&mut app, large, (ClothPins::where_position(|p| p.y > 0.99), swayed(0.0, 0.6)))];
    for (quality, x) in [(ClothQuality::Film, 2.0), (ClothQuality::Medium, 3.5), (ClothQuality::Crowd, 5.0)] {
        cloths.push(spawn(&mut app, sheet(), (quality, top_edge(), swayed(x, 0.0))));
    }
    let held = ClothPinTargets([(0, Vec3::ZERO), (CELLS, Vec3::X)].into());
    cloths.push(spawn(&mut app, sheet(), (held, Transform::from_xyz(2.2, -0.2, 0.1))));
    run(&mut app, 64);
    let cloths = cloths.into_iter().map(|cloth| state(&app, cloth).cloth());
    let motion = cloths.flat_map(|cloth| [cloth.positions(), cloth.velocities()].concat()).collect();
    (app.world().resource::<Threads>().0, motion)
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let motions = [1, 2, 5].map(|count| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
        let (threads, motion) = pool.install(busy);
        assert_eq!(threads, count, "the steps ran in this pool");
        motion
    });
    assert!(motions[0].iter().all(|value| value.is_finite()));
    assert!(motions[1] == motions[0] && motions[2] == motions[0]);
}

/// What the motion is known by to another process.
const MARK: &str = "motion of this process: ";

/// 64-bit FNV-1a of all bits.
fn fingerprint(motion: &[DVec3]) -> u64 {
    let bytes = motion.iter().flat_map(|value| value.to_array()).flat_map(|value| value.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

#[test]
fn another_process_moves_it_the_same() {
    let here = fingerprint(&busy().1);
    let itself = env::current_exe().expect("this program");
    let arguments = ["--exact", "determinism::tells_its_motion", "--ignored", "--nocapture"];
    let output = Command::new(itself).args(arguments).output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stdout);
    let there = said.split_once(MARK).and_then(|(_, rest)| rest.lines().next()).unwrap_or_else(|| panic!("{said}"));
    assert_eq!(there.trim(), here.to_string());
}

#[test]
#[ignore = "started by `another_process_moves_it_the_same`"]
fn tells_its_motion() {
    println!("{MARK}{}", fingerprint(&busy().1));
}
