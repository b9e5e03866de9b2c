//! Colliders of Avian are colliders of cloth, and cloth pushes its bodies.

use avian3d::prelude::*;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use bevy_cloth::plugin::*;

use crate::common::{
    app_with, given_in_last_step, id, run, set_transform, sheet, spawn, state, take_given, with_notes,
};

const NEAR: Transform = Transform::from_xyz(0.5, -0.5, 0.1);

/// Nothing falls.
fn app() -> App {
    let mut app = app_with((PhysicsPlugins::default(), ClothPlugin::default().without_interpolation()));
    with_notes(&mut app);
    app.insert_resource(ClothGravity(Vec3::new(0.0, -0.01, 0.0))).insert_resource(Gravity(Vec3::ZERO));
    app
}

#[test]
fn a_marked_collider_is_followed_in_shape_friction_and_motion() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    let mark = (ClothPhysicsCollider, Friction::new(0.8));
    let ball = app.world_mut().spawn((RigidBody::Static, Collider::sphere(0.2), NEAR, mark)).id();
    app.world_mut().spawn((RigidBody::Static, Collider::sphere(0.2), NEAR));
    run(&mut app, 2);
    let given = take_given(&mut app, cloth).pop().expect("a step");
    assert_eq!(given.len(), 1, "the one that is marked");
    assert_eq!(given[0].shape.as_ball().expect("a ball").radius, 0.2);
    assert_eq!((given[0].id, given[0].friction), (id(&app, ball), f64::from(0.8_f32)));

    app.world_mut().entity_mut(ball).insert((Collider::cuboid(0.2, 0.4, 0.6), Friction::new(0.1)));
    set_transform(&mut app, ball, NEAR.with_scale(Vec3::splat(2.0)));
    run(&mut app, 3);
    let given = take_given(&mut app, cloth).pop().expect("a step");
    let half = given[0].shape.as_cuboid().expect("a box").half_extents;
    assert!(half.abs_diff_eq(Vec3::new(0.2, 0.4, 0.6), 1e-5), "{half}: scaled once");
    assert_eq!(given[0].friction, f64::from(0.1_f32));

    for end in [true, false] {
        if end {
            app.world_mut().entity_mut(ball).remove::<ClothPhysicsCollider>();
        } else {
            app.world_mut().entity_mut(ball).remove::<Collider>();
        }
        run(&mut app, 2);
        assert!(given_in_last_step(&mut app, cloth).is_empty());
        app.world_mut().entity_mut(ball).insert((Collider::sphere(0.2), ClothPhysicsCollider));
        run(&mut app, 2);
        assert_eq!(given_in_last_step(&mut app, cloth), [ball]);
    }
}

#[test]
fn a_child_moves_with_its_body() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    let velocity = Vec3::new(0.5, 0.0, 0.0);
    let body = (RigidBody::Kinematic, LinearVelocity(velocity), Friction::new(0.7));
    let body = app.world_mut().spawn((body, Transform::from_xyz(0.0, -0.5, 0.1))).id();
    let part = (Collider::sphere(0.2), ClothPhysicsCollider, Transform::from_xyz(0.3, 0.0, 0.0), ChildOf(body));
    let part = app.world_mut().spawn(part).id();
    run(&mut app, 8);
    let given = take_given(&mut app, cloth).pop().expect("a step").pop().expect("a collider");
    assert_eq!((given.id, given.friction), (id(&app, part), f64::from(0.7_f32)));
    let moved = (given.end.translation - given.start.translation) * 64.0;
    assert!(moved.abs_diff_eq(velocity.as_dvec3(), 1e-3), "{moved} m/s");
    let parent = app.world().get::<Transform>(body).unwrap().translation.x;
    assert!((f64::from(parent) + 0.3 - given.end.translation.x).abs() < 0.5 / 64.0 + 1e-4, "at most a tick old");
}

/// A ball flies into a free cloth; the momentum of both along z, before and after.
fn momentum_of_a_hit(pushes: bool) -> [f64; 2] {
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(), ClothMaterial(Fabric { air_drag: 0.0, ..Fabric::cotton() }));
    let ball = (RigidBody::Dynamic, Collider::sphere(0.2), ClothPhysicsCollider, Mass(0.5));
    let flying = (LinearVelocity(Vec3::new(0.0, 0.0, -1.0)), Transform::from_xyz(0.5, -0.5, 0.25));
    let ball = app.world_mut().spawn((ball, flying)).id();
    if pushes {
        app.world_mut().entity_mut(ball).insert(ClothPushes);
    }
    let momentum = |app: &App| {
        let cloth = state(app, cloth).cloth();
        let of_cloth: DVec3 = cloth.masses().iter().zip(cloth.velocities()).map(|(m, v)| *m * *v).sum();
        let velocity = app.world().get::<LinearVelocity>(ball).unwrap().0;
        of_cloth.z + 0.5 * f64::from(velocity.z)
    };
    let before = momentum(&app);
    run(&mut app, 30);
    assert!(state(&app, cloth).cloth().velocities()[12].z < -0.3, "it was hit");
    [before, momentum(&app)]
}

#[test]
fn what_the_cloth_gains_the_body_loses() {
    let [before, after] = momentum_of_a_hit(true);
    assert!((after - before).abs() < 0.02 * before.abs(), "{before} N s becomes {after} N s");
    let [before, after] = momentum_of_a_hit(false);
    assert!(after < 1.1 * before, "without the component, the body is not slowed down: {after} N s");
}

/// Avian makes meshes of triangles without saying which side is outside.
#[test]
fn a_mesh_is_solid_or_one_sided_as_that_of_cloth_would_be() {
    let mut app = app();
    let ball: Mesh = Sphere::new(0.3).mesh().uv(16, 8);
    let floor = Plane3d::default().mesh().size(2.0, 2.0).build();
    for (mesh, kind) in [(ball, ClothColliderKind::Solid), (floor, ClothColliderKind::OneSided)] {
        let ours = ClothCollider::from_mesh(&mesh).expect("a mesh of triangles");
        let mesh = ours.shape().as_trimesh().expect("a mesh of triangles");
        let (vertices, triangles) = (mesh.vertices().to_vec(), mesh.indices().to_vec());
        // As `trimesh_from_mesh` does.
        let collider = Collider::trimesh_with_config(vertices, triangles, TrimeshFlags::MERGE_DUPLICATE_VERTICES);
        let entity = app.world_mut().spawn((RigidBody::Static, collider, ClothPhysicsCollider, NEAR)).id();
        run(&mut app, 2);
        assert_eq!(app.world().get::<ClothCollider>(entity).expect("a collider").kind(), kind);
        let changed = |app: &App| app.world().entity(entity).get_ref::<ClothCollider>().unwrap().last_changed();
        let before = changed(&app);
        run(&mut app, 3);
        assert_eq!(changed(&app), before, "built once");
    }
}

#[test]
fn sensors_and_what_is_disabled_are_not_solid() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    let body = app.world_mut().spawn((RigidBody::Static, Transform::default())).id();
    let mark = (ClothPhysicsCollider, Collider::sphere(0.2), NEAR, ChildOf(body));
    let ball = app.world_mut().spawn(mark).id();
    run(&mut app, 2);
    app.world_mut().get_mut::<ClothCollider>(ball).expect("a collider").teleport_speed = 0.7;
    let given = |app: &mut App| {
        run(app, 2);
        given_in_last_step(app, cloth)
    };
    assert_eq!(given(&mut app), [ball]);
    app.world_mut().entity_mut(ball).insert(Sensor);
    assert!(given(&mut app).is_empty());
    app.world_mut().entity_mut(ball).remove::<Sensor>();
    assert_eq!(given(&mut app), [ball]);
    app.world_mut().entity_mut(ball).insert(ColliderDisabled);
    assert!(given(&mut app).is_empty());
    app.world_mut().entity_mut(ball).remove::<ColliderDisabled>();
    assert_eq!(given(&mut app), [ball]);
    app.world_mut().entity_mut(body).insert(RigidBodyDisabled);
    assert!(given(&mut app).is_empty());
    app.world_mut().entity_mut(body).remove::<RigidBodyDisabled>();
    assert_eq!(given(&mut app), [ball]);
    assert_eq!(app.world().get::<ClothCollider>(ball).unwrap().teleport_speed, 0.7);
}
