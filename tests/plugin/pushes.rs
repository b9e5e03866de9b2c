//! Cloth pushes bodies of Avian, and never gives them more than they came with.

use avian3d::prelude::*;
use bevy::app::FixedPostUpdate;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

use crate::common::{app_with, run};

/// What counts as a rebound, m.
const REBOUND: f32 = 0.03;

fn apps() -> [(&'static str, App); 2] {
    [
        ("FixedUpdate", app_with((PhysicsPlugins::default(), ClothPlugin::default()))),
        ("FixedPostUpdate", app_with((PhysicsPlugins::default(), ClothPlugin::new(FixedPostUpdate)))),
    ]
}

fn canvas(app: &mut App, size: Vec2, cells: u32, bundle: impl Bundle) {
    let mesh = Plane3d::new(Vec3::Y, 0.5 * size).mesh().subdivisions(cells - 1).build();
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    app.world_mut().spawn((Mesh3d(mesh), ClothMesh::default(), bundle));
    app.update();
}

fn height(app: &App, body: Entity) -> f32 {
    app.world().get::<Transform>(body).expect("a body").translation.y
}

fn speeds(app: &App, body: Entity) -> [f32; 2] {
    let world = app.world();
    [
        world.get::<LinearVelocity>(body).expect("a body").length(),
        world.get::<AngularVelocity>(body).expect("a body").length(),
    ]
}

/// It came up to 3.3 m in `FixedUpdate` and to 198 m in `FixedPostUpdate`, let fall from 1.6 m with 5 kg.
#[test]
fn a_ball_never_comes_up_higher_in_a_hammock_than_it_was_let_fall() {
    for mass in [0.3, 1.0, 2.0, 5.0, 20.0] {
        for (schedule, mut app) in apps() {
            let material = ClothMaterial(bevy_cloth::physics::Fabric::canvas());
            let ends = ClothPins::where_position(|p| p.x.abs() > 0.99);
            canvas(&mut app, Vec2::new(2.0, 1.0), 20, (material, ends, Transform::from_xyz(0.0, 1.0, 0.0)));
            let body = (RigidBody::Dynamic, Collider::sphere(0.15), Mass(mass), ClothPhysicsCollider, ClothPushes);
            let ball = app.world_mut().spawn((body, Transform::from_xyz(0.0, 1.6, 0.0))).id();
            // Highest places between falls of 3 cm and more: what lies trembles by a few millimeters.
            let (mut tops, mut top, mut low) = (vec![1.6_f32], f32::MIN, 1.6_f32);
            for _ in 0..384 {
                app.update();
                let now = height(&app, ball);
                (top, low) =
                    if now > low + REBOUND || top > f32::MIN { (top.max(now), low) } else { (top, low.min(now)) };
                if now < top - REBOUND {
                    tops.push(top);
                    (top, low) = (f32::MIN, now);
                }
            }
            assert!(tops.windows(2).all(|pair| pair[1] < pair[0]), "{mass} kg, {schedule}: {tops:?}");
        }
    }
}

/// Avian's default bodies: a box of 6 g, a ball of 4 g, a capsule. The box left the table with 143 m/s.
#[test]
fn light_bodies_lie_on_a_table_cloth_or_roll_off_it() {
    for (schedule, mut app) in apps() {
        let top = (RigidBody::Static, Collider::cuboid(1.2, 0.1, 1.2), ClothPhysicsCollider);
        app.world_mut().spawn((top, Transform::from_xyz(0.0, 0.95, 0.0)));
        canvas(&mut app, Vec2::splat(1.6), 24, Transform::from_xyz(0.0, 1.02, 0.0));
        run(&mut app, 120);
        let shapes = [
            ("box", Collider::cuboid(0.18, 0.18, 0.18), -0.3),
            ("ball", Collider::sphere(0.1), 0.0),
            ("capsule", Collider::capsule(0.07, 0.2), 0.3),
        ];
        let bodies = shapes.map(|(name, shape, x)| {
            let place = Transform::from_xyz(x, 1.3, 0.05).with_rotation(Quat::from_rotation_x(0.1));
            let body = (RigidBody::Dynamic, shape, ClothPhysicsCollider, ClothPushes, place);
            (name, app.world_mut().spawn(body).id())
        });
        let (mut fastest, mut spin) = ([0.0_f32; 3], [0.0_f32; 3]);
        for _ in 0..320 {
            app.update();
            for (i, (_, body)) in bodies.iter().enumerate() {
                if height(&app, *body) > 0.9 {
                    let [speed, turns] = speeds(&app, *body);
                    (fastest[i], spin[i]) = (fastest[i].max(speed), spin[i].max(turns));
                }
            }
        }
        for (i, (name, body)) in bodies.into_iter().enumerate() {
            let [speed, _] = speeds(&app, body);
            let y = height(&app, body);
            // What falls 0.2 m has 2 m/s.
            assert!(fastest[i] < 2.3 && spin[i] < 40.0, "{schedule} {name}: {} m/s, {} rad/s", fastest[i], spin[i]);
            if name == "box" {
                assert!((1.05..1.15).contains(&y) && speed < 0.3, "{schedule} {name}: {y} m, {speed} m/s");
            }
        }
    }
}

/// A body that lies in a cloth is carried for good.
#[test]
fn a_body_at_rest_is_carried() {
    for mass in [0.1, 5.0] {
        for (schedule, mut app) in apps() {
            let rim = ClothPins::where_position(|p| p.x.abs() > 0.99 || p.z.abs() > 0.49);
            canvas(&mut app, Vec2::new(2.0, 1.0), 16, (rim, Transform::from_xyz(0.0, 1.0, 0.0)));
            let body = (RigidBody::Dynamic, Collider::sphere(0.15), Mass(mass), ClothPhysicsCollider, ClothPushes);
            let ball = app.world_mut().spawn((body, Transform::from_xyz(0.0, 1.16, 0.0))).id();
            run(&mut app, 640);
            let before = height(&app, ball);
            run(&mut app, 128);
            let [speed, _] = speeds(&app, ball);
            assert!(
                (height(&app, ball) - before).abs() < 0.02 && (0.5..1.2).contains(&before),
                "{mass} {schedule}: {before} then {} m",
                height(&app, ball)
            );
            // Pushed before Avian lets it fall, it has the speed of one step of gravity, 0.15 m/s.
            assert!(speed < 0.3, "{mass} kg, {schedule}: {speed} m/s");
        }
    }
}
