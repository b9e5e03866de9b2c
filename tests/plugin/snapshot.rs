//! A cloth put back into a state goes on from there.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

use crate::common::*;

/// Number of the tick: what moves goes by it.
#[derive(Resource, Clone, Copy, Default)]
struct Tick(u32);

#[derive(Component)]
struct Mover;

fn advance(
    mut tick: ResMut<Tick>,
    mut movers: Query<&mut Transform, With<Mover>>,
    mut targets: Query<&mut ClothPinTargets>,
) {
    tick.0 += 1;
    let angle = 0.07 * tick.0 as f32;
    for mut transform in &mut movers {
        transform.translation.x = 0.5 + 0.2 * angle.sin();
        transform.rotation = Quat::from_rotation_y(angle);
    }
    for mut targets in &mut targets {
        targets.0.clear();
        if tick.0 % 40 < 30 {
            targets.insert(COUNT - 1, Vec3::new(1.0, -0.9 + 0.1 * angle.sin(), 0.1));
        }
    }
}

/// A sheet held at its top edge, pulled at a corner, in the way of a ball that moves to and fro.
fn scene(quality: ClothQuality) -> (App, Entity, Entity) {
    let mut app = app();
    app.init_resource::<Tick>().add_systems(FixedUpdate, advance.before(ClothSystems::Collect));
    let place = Transform::from_xyz(0.5, -0.6, 0.1);
    let ball = app.world_mut().spawn((ClothCollider::cuboid(0.5, 0.4, 0.3), place, Mover)).id();
    let cloth = spawn(&mut app, sheet(), (top_edge(), quality, ClothPinTargets::default()));
    (app, cloth, ball)
}

fn record(app: &mut App, cloth: Entity, frames: u32) -> Vec<(Vec<DVec3>, Vec<Vec3>)> {
    let frame = |_| {
        app.update();
        (state(app, cloth).cloth().positions().to_vec(), local(app, cloth))
    };
    (0..frames).map(frame).collect()
}

#[test]
fn ticks_played_again_give_the_same_bits() {
    let mut any = false;
    for (quality, at) in [(ClothQuality::Medium, 60), (ClothQuality::Film, 31), (ClothQuality::Crowd, 58)] {
        let (mut app, cloth, ball) = scene(quality);
        app.world_mut().entity_mut(cloth).insert(ClothContacts::default());
        run(&mut app, at);
        let snapshot = state(&app, cloth).snapshot();
        let world = app.world();
        let before = (*world.resource::<Tick>(), *world.get::<Transform>(ball).unwrap());
        let targets = world.get::<ClothPinTargets>(cloth).unwrap().clone();
        let ahead = record(&mut app, cloth, 60);
        let touched = app.world().get::<ClothContacts>(cloth).unwrap().clone();
        any |= !touched.is_empty();
        assert!(touched.iter().all(|touch| touch.collider == ball));

        app.insert_resource(before.0);
        set_transform(&mut app, ball, before.1);
        *app.world_mut().get_mut(cloth).unwrap() = targets;
        app.world_mut().trigger(ClothRestore { entity: cloth, snapshot: snapshot.clone() });
        assert_eq!(state(&app, cloth).snapshot().positions(), snapshot.positions());
        assert!(record(&mut app, cloth, 60) == ahead, "{quality:?}");
        assert_eq!(*app.world().get::<ClothContacts>(cloth).unwrap(), touched);
        assert!(error(&app, cloth).is_none());
    }
    assert!(any, "some of them touch the box");
}

#[test]
fn a_turned_and_scaled_cloth_is_put_back_too() {
    let mut app = app();
    let turned = Transform::from_rotation(Quat::from_rotation_y(0.3)).with_scale(Vec3::splat(1.5));
    let cloth = spawn(&mut app, sheet(), (top_edge(), turned));
    run(&mut app, 20);
    let snapshot = state(&app, cloth).snapshot();
    let ahead = record(&mut app, cloth, 20);
    let other = Transform::from_rotation(Quat::from_rotation_y(1.3)).with_scale(Vec3::splat(0.5));
    set_transform(&mut app, cloth, other);
    run(&mut app, 5);
    set_transform(&mut app, cloth, turned);
    app.world_mut().trigger(ClothRestore { entity: cloth, snapshot });
    assert!(record(&mut app, cloth, 20) == ahead);
}

#[test]
fn a_cloth_that_starts_beside_a_snapshot_begins_in_it() {
    let mut first = app();
    let cloth = spawn(&mut first, sheet(), top_edge());
    run(&mut first, 30);
    let snapshot = state(&first, cloth).snapshot();
    let ahead = record(&mut first, cloth, 20);
    let mut second = app();
    let again = spawn(&mut second, sheet(), (top_edge(), snapshot.clone()));
    assert_eq!(state(&second, again).cloth().positions(), snapshot.positions());
    assert!(second.world().get::<ClothSnapshot>(again).is_none());
    assert!(record(&mut second, again, 20) == ahead);
}

#[test]
fn one_kept_beside_a_running_cloth_is_left_alone() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 30);
    let snapshot = state(&app, cloth).snapshot();
    run(&mut app, 5);
    app.world_mut().entity_mut(cloth).insert(snapshot.clone());
    let before = state(&app, cloth).cloth().positions().to_vec();
    run(&mut app, 3);
    assert!(app.world().get::<ClothSnapshot>(cloth) == Some(&snapshot));
    assert_ne!(state(&app, cloth).cloth().positions(), before);
}

#[test]
fn what_does_not_fit_is_refused_and_the_cloth_goes_on() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let plane = Plane3d::default().mesh().size(1.0, 1.0).subdivisions(2).build();
    let other = spawn(&mut app, plane, ());
    run(&mut app, 5);
    let snapshot = state(&app, other).snapshot();
    app.world_mut().trigger(ClothRestore { entity: cloth, snapshot });
    let before = state(&app, cloth).cloth().positions().to_vec();
    run(&mut app, 1);
    let told = error(&app, cloth).expect("an error").to_string();
    assert!(told.contains("another"), "{told}");
    assert_ne!(state(&app, cloth).cloth().positions(), before);
    let snapshot = state(&app, cloth).snapshot();
    app.world_mut().trigger(ClothRestore { entity: cloth, snapshot });
    run(&mut app, 1);
    assert!(error(&app, cloth).is_none());
}

#[test]
fn a_game_sets_positions_and_velocities() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ());
    let mut state = app.world_mut().get_mut::<ClothState>(cloth).unwrap();
    let draped: Vec<_> =
        state.cloth().positions().iter().map(|x| *x + DVec3::new(0.0, 3.0, -0.2 * x.y * x.y)).collect();
    let thrown = vec![DVec3::X; COUNT as usize];
    let short = state.set_positions_and_velocities(&draped[1..], &thrown).unwrap_err();
    assert!(matches!(&short, ClothError::State { reason } if reason.contains("24 positions")), "{short}");
    let nan = [&[DVec3::NAN], &draped[1..]].concat();
    assert!(matches!(state.set_positions_and_velocities(&nan, &thrown), Err(ClothError::State { .. })));
    state.set_positions_and_velocities(&draped, &thrown).unwrap();
    assert_eq!((state.cloth().positions(), state.cloth().velocities()), (&draped[..], &thrown[..]));
    run(&mut app, 1);
    assert_near(world(&app, cloth)[0], draped[0].as_vec3() + Vec3::X / 64.0, 2e-2);
    assert!(error(&app, cloth).is_none());
}
