//! Colliders of Rapier are colliders of cloth.

use bevy::prelude::*;
use bevy_cloth::parry3d::shape::ShapeType;
use bevy_cloth::plugin::*;
use bevy_rapier3d::dynamics::{RigidBody, RigidBodyDisabled};
use bevy_rapier3d::geometry::{Collider, ColliderDisabled, Friction, Sensor};

use crate::common::{
    app_with_notes, collider_error, given_in_last_step, id, run, set_transform, sheet, spawn, take_given,
};

const NEAR: Transform = Transform::from_xyz(0.5, -0.5, 0.1);

#[test]
fn a_marked_collider_is_followed_in_shape_and_friction() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    let mark = (ClothPhysicsCollider, Friction::coefficient(0.8));
    let ball = app.world_mut().spawn((Collider::ball(0.2), NEAR, mark)).id();
    app.world_mut().spawn((Collider::ball(0.2), NEAR));
    run(&mut app, 2);
    let given = take_given(&mut app, cloth).pop().expect("a step");
    assert_eq!(given.len(), 1, "the one that is marked");
    assert_eq!(given[0].shape.as_ball().expect("a ball").radius, 0.2);
    assert_eq!((given[0].id, given[0].friction), (id(&app, ball), f64::from(0.8_f32)));

    app.world_mut().entity_mut(ball).insert(Friction::coefficient(0.1));
    set_transform(&mut app, ball, NEAR.with_scale(Vec3::splat(0.5)));
    run(&mut app, 2);
    let given = take_given(&mut app, cloth).pop().expect("a step");
    assert_eq!((given[0].shape.as_ball().unwrap().radius, given[0].friction), (0.1, f64::from(0.1_f32)));
    app.world_mut().entity_mut(ball).remove::<Collider>();
    run(&mut app, 2);
    assert!(given_in_last_step(&mut app, cloth).is_empty());
}

#[test]
fn shapes_become_the_same_or_are_refused() {
    let square = vec![vec![0.0; 2]; 2].concat();
    let tetrahedron = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let cases = [
        (Collider::cuboid(0.1, 0.2, 0.3), ShapeType::Cuboid),
        (Collider::capsule_y(0.5, 0.2), ShapeType::Capsule),
        (Collider::cylinder(0.5, 0.2), ShapeType::Cylinder),
        (Collider::cone(0.5, 0.2), ShapeType::Cone),
        (Collider::halfspace(Vec3::Y).unwrap(), ShapeType::HalfSpace),
        (Collider::convex_hull(&tetrahedron).unwrap(), ShapeType::ConvexPolyhedron),
        (Collider::trimesh(tetrahedron.to_vec(), vec![[0, 1, 2]]).unwrap(), ShapeType::TriMesh),
        (Collider::heightfield(square, 2, 2, Vec3::ONE), ShapeType::TriMesh),
        (Collider::compound(vec![(Vec3::X, Quat::IDENTITY, Collider::ball(0.2))]), ShapeType::Compound),
        (Collider::round_cuboid(0.1, 0.2, 0.3, 0.01), ShapeType::RoundCuboid),
    ];
    let mut app = app_with_notes();
    let entity = app.world_mut().spawn((NEAR, ClothPhysicsCollider)).id();
    for (collider, kind) in cases {
        let theirs = collider.raw.compute_local_aabb();
        app.world_mut().entity_mut(entity).insert(collider);
        run(&mut app, 1);
        let shape = app.world().get::<ClothCollider>(entity).expect("a collider").shape();
        let ours = shape.compute_local_aabb();
        assert_eq!(shape.shape_type(), kind);
        assert!(ours.mins.abs_diff_eq(theirs.mins, 1e-5) && ours.maxs.abs_diff_eq(theirs.maxs, 1e-5), "{kind:?}");
    }
    app.world_mut().entity_mut(entity).insert(Collider::voxels(Vec3::ONE, &[IVec3::ZERO]));
    run(&mut app, 2);
    let error = collider_error(&app, entity).expect("an error").to_string();
    assert!(error.contains("Voxels") && app.world().get::<ClothCollider>(entity).is_none(), "{error}");
    app.world_mut().entity_mut(entity).insert(Collider::ball(0.2));
    run(&mut app, 2);
    assert!(collider_error(&app, entity).is_none());
}

#[test]
fn sensors_and_what_is_disabled_are_not_solid() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    let body = app.world_mut().spawn((RigidBody::Fixed, Transform::default())).id();
    let ball = app.world_mut().spawn((ClothPhysicsCollider, Collider::ball(0.2), NEAR, ChildOf(body))).id();
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
}

#[test]
fn ground_is_solid_from_above() {
    let mut app = app_with_notes();
    let mark = (NEAR, ClothPhysicsCollider, Collider::heightfield(vec![0.0; 4], 2, 2, Vec3::ONE));
    let ground = app.world_mut().spawn(mark).id();
    run(&mut app, 2);
    let collider = app.world().get::<ClothCollider>(ground).expect("a collider");
    assert_eq!(collider.kind(), ClothColliderKind::OneSided);
    let mesh = collider.shape().as_trimesh().expect("a mesh");
    assert!(mesh.triangles().all(|triangle| triangle.normal().expect("a triangle").y > 0.99));
}
