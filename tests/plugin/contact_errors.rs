//! What is wrong with a collider, or with how a cloth meets them: shown on the entity, gone with its cause.

use crate::common::*;
use bevy::prelude::*;
use bevy_cloth::physics::ContactSettings;
use bevy_cloth::plugin::*;

const NEAR: Transform = Transform::from_xyz(0.5, -0.5, 0.1);

/// Something is wrong with a collider that was right, and it is mended.
#[track_caller]
fn assert_told_and_mended(spoil: impl Fn(&mut EntityWorldMut), mend: impl Fn(&mut EntityWorldMut), part: &str) {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let collider = app.world_mut().spawn((ClothCollider::sphere(0.2), NEAR)).id();
    run(&mut app, 3);
    assert_eq!(given_in_last_step(&mut app, cloth), [collider]);
    for _ in 0..2 {
        spoil(&mut app.world_mut().entity_mut(collider));
        run(&mut app, 3);
        let error = collider_error(&app, collider).expect("an error").to_string();
        assert!(error.contains(part), "{error}");
        assert!(given_in_last_step(&mut app, cloth).is_empty());
        mend(&mut app.world_mut().entity_mut(collider));
        run(&mut app, 2);
        assert!(collider_error(&app, collider).is_none());
        assert_eq!(given_in_last_step(&mut app, cloth), [collider]);
    }
}

fn set(transform: Transform) -> impl Fn(&mut EntityWorldMut) {
    move |entity| *entity.get_mut().expect("a transform") = transform
}

fn put(collider: ClothCollider) -> impl Fn(&mut EntityWorldMut) {
    move |entity| {
        entity.insert(collider.clone());
    }
}

#[test]
fn the_transform_is_not_usable() {
    for bad in
        [NEAR.with_translation(Vec3::NAN), NEAR.with_scale(Vec3::ZERO), NEAR.with_scale(Vec3::new(1.0, 0.0, 1.0))]
    {
        assert_told_and_mended(set(bad), set(NEAR), "transform");
    }
}

#[test]
fn a_number_means_nothing() {
    let good = || put(ClothCollider::sphere(0.2));
    for friction in [-0.1, f32::NAN, f32::INFINITY] {
        assert_told_and_mended(put(ClothCollider::sphere(0.2).with_friction(friction)), good(), "friction");
    }
    assert_told_and_mended(put(ClothCollider::sphere(0.2).with_teleport_speed(f32::NAN)), good(), "teleport");
    assert_told_and_mended(|e| e.get_mut::<ClothCollider>().unwrap().friction = -1.0, good(), "friction");
}

#[test]
fn the_shape_is_empty() {
    for bad in [
        ClothCollider::sphere(0.0),
        ClothCollider::sphere(-1.0),
        ClothCollider::sphere(f32::NAN),
        ClothCollider::cuboid(1.0, f32::NAN, 1.0),
        ClothCollider::capsule_between(Vec3::ZERO, Vec3::NAN, 1.0),
    ] {
        assert_told_and_mended(put(bad), put(ClothCollider::sphere(0.2)), "shape");
    }
}

#[test]
fn the_shape_cannot_be_scaled() {
    let voxels = bevy_cloth::parry3d::shape::SharedShape::voxels(Vec3::splat(0.1), &[IVec3::NEG_ONE]);
    let spoil = |entity: &mut EntityWorldMut| {
        put(voxels.clone().into())(entity);
        set(NEAR.with_scale(Vec3::splat(2.0)))(entity);
    };
    assert_told_and_mended(spoil, set(NEAR), "Voxels cannot be scaled");
}

#[test]
fn an_error_goes_with_the_collider() {
    let mut app = app();
    let collider = app.world_mut().spawn(ClothCollider::sphere(0.0)).id();
    run(&mut app, 3);
    assert_eq!(collider_error(&app, collider), Some(&ClothColliderError::Shape));
    app.world_mut().entity_mut(collider).remove::<ClothCollider>();
    run(&mut app, 1);
    assert!(collider_error(&app, collider).is_none());
}

#[test]
fn settings_of_contact_are_taken_over_and_refused_if_they_mean_nothing() {
    let mut app = app();
    let thick = ClothContact { thickness: 0.01, friction: 0.25 };
    let cloth = spawn(&mut app, sheet(), (top_edge(), thick));
    let plain = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 2);
    let settings = |app: &App, cloth| state(app, cloth).cloth().contact_settings();
    assert_eq!(settings(&app, cloth), thick.into());
    assert_eq!(settings(&app, plain), ContactSettings::default());

    for (bad, part) in [
        (ClothContact { thickness: 0.0, ..thick }, "thickness"),
        (ClothContact { thickness: f32::NAN, ..thick }, "thickness"),
        (ClothContact { friction: -1.0, ..thick }, "friction"),
    ] {
        app.world_mut().entity_mut(cloth).insert(bad);
        run(&mut app, 2);
        let shown = error(&app, cloth).expect("an error");
        assert!(matches!(shown, ClothError::Contact(_)) && shown.to_string().contains(part), "{shown}");
        assert_eq!(settings(&app, cloth), thick.into(), "the last good ones stay");
    }
    app.world_mut().entity_mut(cloth).insert(ClothContact { friction: 0.5, ..thick });
    run(&mut app, 2);
    assert!(error(&app, cloth).is_none());
    assert_eq!(settings(&app, cloth).friction, 0.5);

    // A cloth measured anew has them still.
    set_transform(&mut app, cloth, Transform::from_scale(Vec3::splat(2.0)));
    run(&mut app, 1);
    assert_eq!(settings(&app, cloth).thickness, f64::from(0.01_f32));
    app.world_mut().entity_mut(cloth).remove::<ClothContact>();
    run(&mut app, 1);
    assert_eq!(settings(&app, cloth), ContactSettings::default());
}
