//! Meshes and looks of what a scene is made of.

use bevy::{math::Affine2, prelude::*};
use bevy_cloth::prelude::*;

/// Adds a shape to the meshes.
pub fn mesh(world: &mut World, shape: impl Into<Mesh>) -> Mesh3d {
    Mesh3d(world.resource_mut::<Assets<Mesh>>().add(shape.into()))
}

/// Adds a material.
pub fn look(world: &mut World, material: StandardMaterial) -> MeshMaterial3d<StandardMaterial> {
    MeshMaterial3d(world.resource_mut::<Assets<StandardMaterial>>().add(material))
}

/// Dark wood.
pub fn wood(world: &mut World) -> MeshMaterial3d<StandardMaterial> {
    varnished(world, Color::srgb(0.20, 0.12, 0.08))
}

/// For rings and ornaments.
pub fn brass(world: &mut World) -> MeshMaterial3d<StandardMaterial> {
    let base_color = Color::srgb(0.80, 0.62, 0.30);
    look(world, StandardMaterial { base_color, metallic: 1.0, perceptual_roughness: 0.45, ..default() })
}

/// A smooth surface of one colour.
pub fn varnished(world: &mut World, base_color: Color) -> MeshMaterial3d<StandardMaterial> {
    look(world, StandardMaterial { base_color, perceptual_roughness: 0.45, ..default() })
}

/// Cloth with this pattern, `repeats` times across: seen from both sides, without a shine.
pub fn woven(world: &mut World, pattern: Image, repeats: Vec2) -> MeshMaterial3d<StandardMaterial> {
    let pattern = world.resource_mut::<Assets<Image>>().add(pattern);
    look(
        world,
        StandardMaterial {
            base_color_texture: Some(pattern),
            uv_transform: Affine2::from_scale(repeats),
            perceptual_roughness: 0.9,
            reflectance: 0.25,
            double_sided: true,
            cull_mode: None,
            ..default()
        },
    )
}

/// Spawns a body that is drawn and that cloth touches.
pub fn solid<'w>(
    world: &'w mut World,
    shape: impl Into<Mesh> + Into<ClothCollider> + Copy,
    look: &MeshMaterial3d<StandardMaterial>,
    transform: Transform,
) -> EntityWorldMut<'w> {
    let mesh = mesh(world, shape);
    let collider: ClothCollider = shape.into();
    world.spawn((mesh, look.clone(), transform, collider))
}
