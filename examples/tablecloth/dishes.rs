//! What stands on the table, each with a collider of another kind.

use bevy::prelude::*;
use bevy_cloth::prelude::*;
use example_common::{
    lathe::turned,
    props::{look, mesh, solid, varnished},
};
use std::f32::consts::TAU;

type Look = MeshMaterial3d<StandardMaterial>;

/// Lays a table of this height around the origin.
pub fn build(world: &mut World, table: f32) {
    let at = |x: f32, z: f32| Vec3::new(x, table, z);
    let china = look(
        world,
        StandardMaterial { base_color: Color::srgb(0.93, 0.93, 0.90), perceptual_roughness: 0.25, ..default() },
    );
    bowl(world, &china, at(-0.14, -0.10));
    bottle(world, at(0.19, -0.14));
    for (x, z) in [(-0.20, 0.26), (0.24, 0.20)] {
        plate_and_cup(world, &china, at(x, z));
    }
}

/// A bowl of oranges: its mesh is its collider.
fn bowl(world: &mut World, china: &Look, place: Vec3) {
    const OUTSIDE: [(f32, f32); 5] = [(0.0, 0.0), (0.055, 0.0), (0.06, 0.012), (0.115, 0.05), (0.138, 0.095)];
    const INSIDE: [(f32, f32); 4] = [(0.124, 0.095), (0.10, 0.058), (0.05, 0.026), (0.0, 0.022)];
    let bowl = mesh(world, turned(&[&OUTSIDE[..], &INSIDE[..]].concat(), 0.006));
    world.spawn((
        Name::new("Bowl"),
        bowl,
        china.clone(),
        Transform::from_translation(place),
        ClothMeshCollider::default(),
    ));

    let peel = varnished(world, Color::srgb(0.93, 0.45, 0.06));
    let orange = Sphere::new(0.042);
    for nth in 0..3 {
        let around = Quat::from_rotation_y(TAU * nth as f32 / 3.0) * Vec3::new(0.05, 0.078, 0.0);
        solid(world, orange, &peel, Transform::from_translation(place + around));
    }
    solid(world, orange, &peel, Transform::from_translation(place + Vec3::new(0.0, 0.143, 0.0)));
}

/// A bottle: several shapes in one collider.
fn bottle(world: &mut World, place: Vec3) {
    let glass = look(
        world,
        StandardMaterial { base_color: Color::srgb(0.05, 0.17, 0.09), perceptual_roughness: 0.12, ..default() },
    );
    let (body, shoulder, neck) = (Cylinder::new(0.042, 0.17), Sphere::new(0.042), Capsule3d::new(0.017, 0.26));
    let parts: [(f32, Mesh, ClothCollider); 3] = [
        (0.085, body.into(), body.into()),
        (0.17, shoulder.into(), shoulder.into()),
        (0.147, neck.into(), neck.into()),
    ];
    let up = |height: f32| height * Vec3::Y;
    let colliders = parts.iter().map(|(height, _, part)| (up(*height), Quat::IDENTITY, part.clone()));
    let collider = ClothCollider::compound(colliders).expect("there are parts");
    let bottle = world.spawn((
        Name::new("Bottle"),
        Transform::from_translation(place),
        Visibility::default(),
        collider.with_friction(0.2),
    ));
    let bottle = bottle.id();
    for (height, shape, _) in parts {
        let part = mesh(world, shape);
        world.spawn((part, glass.clone(), Transform::from_translation(up(height)), ChildOf(bottle)));
    }
}

/// A cup on a plate; of the cup, cloth feels the hull.
fn plate_and_cup(world: &mut World, china: &Look, place: Vec3) {
    const PLATE: f32 = 0.014;
    const CUP: [(f32, f32); 6] =
        [(0.0, 0.0), (0.034, 0.0), (0.043, 0.085), (0.039, 0.085), (0.031, 0.006), (0.0, 0.006)];
    solid(world, Cylinder::new(0.11, PLATE), china, Transform::from_translation(place + 0.5 * PLATE * Vec3::Y));
    let cup = mesh(world, turned(&CUP, 0.003));
    world.spawn((
        Name::new("Cup"),
        cup,
        china.clone(),
        Transform::from_translation(place + PLATE * Vec3::Y),
        ClothMeshCollider { shape: ClothMeshShape::Hull, ..default() },
    ));
}
