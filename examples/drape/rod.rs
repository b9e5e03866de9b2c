//! A rod between two posts, to hang cloth from.

use bevy::prelude::*;
use std::f32::consts::FRAC_PI_2;

/// In metres.
pub const RADIUS: f32 = 0.016;

/// The rod along x with this centre, its posts, and their feet on the ground at y = 0.
pub fn build(world: &mut World, centre: Vec3, length: f32) {
    let wood = surface(world, Color::srgb(0.20, 0.12, 0.08), 0.0);
    let brass = brass(world);
    let rod = mesh(world, Cylinder::new(RADIUS, length));
    let sideways = Quat::from_rotation_z(FRAC_PI_2);
    world.spawn((rod, wood.clone(), Transform::from_translation(centre).with_rotation(sideways)));

    let height = centre.y + 0.05;
    let post = mesh(world, Cylinder::new(1.6 * RADIUS, height));
    let finial = mesh(world, Sphere::new(2.4 * RADIUS));
    let foot = mesh(world, Cylinder::new(0.12, 0.03));
    for x in [centre.x - 0.5 * length, centre.x + 0.5 * length] {
        world.spawn((post.clone(), wood.clone(), Transform::from_xyz(x, 0.5 * height, centre.z)));
        world.spawn((foot.clone(), wood.clone(), Transform::from_xyz(x, 0.015, centre.z)));
        world.spawn((finial.clone(), brass.clone(), Transform::from_xyz(x, height + 0.02, centre.z)));
    }
}

/// For rings and ornaments.
pub fn brass(world: &mut World) -> MeshMaterial3d<StandardMaterial> {
    surface(world, Color::srgb(0.80, 0.62, 0.30), 1.0)
}

/// Adds a shape to the meshes.
pub fn mesh(world: &mut World, shape: impl Into<Mesh>) -> Mesh3d {
    Mesh3d(world.resource_mut::<Assets<Mesh>>().add(shape.into()))
}

fn surface(world: &mut World, base_color: Color, metallic: f32) -> MeshMaterial3d<StandardMaterial> {
    let material = StandardMaterial { base_color, metallic, perceptual_roughness: 0.45, ..default() };
    MeshMaterial3d(world.resource_mut::<Assets<StandardMaterial>>().add(material))
}
