//! What stands on the table, each with a collider of another kind.

use bevy::prelude::*;
use bevy_cloth::prelude::*;
use example_common::{
    lathe::turned,
    props::{look, mesh, solid, varnished},
};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

type Look = MeshMaterial3d<StandardMaterial>;

/// Lays a table of this height around the origin.
pub fn build(world: &mut World, table: f32) {
    let at = |x: f32, z: f32| Vec3::new(x, table, z);
    let china = look(
        world,
        StandardMaterial { base_color: Color::srgb(0.93, 0.93, 0.90), perceptual_roughness: 0.25, ..default() },
    );
    bowl(world, &china, at(-0.15, -0.13));
    teapot(world, at(0.24, -0.20));
    for (x, z) in [(-0.28, 0.27), (0.25, 0.29)] {
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
}

/// A teapot: several shapes in one collider.
fn teapot(world: &mut World, place: Vec3) {
    let glaze = look(
        world,
        StandardMaterial { base_color: Color::srgb(0.07, 0.24, 0.30), perceptual_roughness: 0.2, ..default() },
    );
    let at = |x: f32, y: f32| Transform::from_xyz(x, y, 0.0);
    let (foot, belly, knob) = (Cylinder::new(0.05, 0.02), Sphere::new(0.078), Sphere::new(0.016));
    let (spout, handle) = (Capsule3d::new(0.014, 0.08), Torus::new(0.030, 0.046));
    let parts: [(Transform, Mesh, ClothCollider); 5] = [
        (at(0.0, 0.01), foot.into(), foot.into()),
        (at(0.0, 0.08), belly.into(), belly.into()),
        (at(0.0, 0.168), knob.into(), knob.into()),
        (at(0.09, 0.09).with_rotation(Quat::from_rotation_z(-0.7)), spout.into(), spout.into()),
        (
            at(-0.086, 0.085).with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
            handle.into(),
            // Nothing goes through it.
            ClothCollider::cylinder(0.046, 0.016),
        ),
    ];
    let colliders = parts.iter().map(|(at, _, part)| (at.translation, at.rotation, part.clone()));
    let collider = ClothCollider::compound(colliders).expect("there are parts").with_friction(0.3);
    let turned = Transform::from_translation(place).with_rotation(Quat::from_rotation_y(0.6));
    let teapot = world.spawn((Name::new("Teapot"), turned, Visibility::default(), collider)).id();
    for (at, shape, _) in parts {
        let part = mesh(world, shape);
        world.spawn((part, glaze.clone(), at, ChildOf(teapot)));
    }
}

/// A cup on a plate; of the cup, cloth feels the hull.
fn plate_and_cup(world: &mut World, china: &Look, place: Vec3) {
    const PLATE: f32 = 0.014;
    const FOOT: (f32, f32) = (0.034, 0.0);
    const RIM: (f32, f32) = (0.043, 0.085);
    solid(world, Cylinder::new(0.11, PLATE), china, Transform::from_translation(place + 0.5 * PLATE * Vec3::Y));
    let outline = [(0.0, 0.0), FOOT, RIM, (0.039, 0.085), (0.031, 0.006), (0.0, 0.006)];
    let cup = mesh(world, turned(&outline, 0.003));
    // The fewer points a hull has, the cheaper it is: those of a polygon around the cup.
    let around = |(radius, height): (f32, f32)| {
        let corner = Vec3::new(radius / (PI / 16.0).cos(), height, 0.0);
        (0..16).map(move |nth| Quat::from_rotation_y(TAU * nth as f32 / 16.0) * corner)
    };
    let points: Vec<Vec3> = around(FOOT).chain(around(RIM)).collect();
    let hull = ClothCollider::convex_hull(&points).expect("a body");
    let standing = Transform::from_translation(place + PLATE * Vec3::Y);
    world.spawn((Name::new("Cup"), cup, china.clone(), standing, hull));
}
