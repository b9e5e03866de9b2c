//! The draped cloths as a glTF file.

use crate::glb::{GlbMesh, to_glb};
use bevy::{
    mesh::{Indices, VertexAttributeValues},
    prelude::*,
};
use bevy_cloth::prelude::ClothState;
use std::path::Path;

/// Writes every cloth as it hangs now, in world space, as binary glTF.
pub fn write_cloths(world: &mut World, path: &Path) -> Result<(), String> {
    let mut cloths = world.query::<&ClothState>();
    let mut places = world.query::<(&GlobalTransform, Option<&Name>)>();
    let meshes = world.resource::<Assets<Mesh>>();
    let mut exported = Vec::new();
    for (index, part) in cloths.iter(world).flat_map(ClothState::parts).enumerate() {
        let (transform, name) = places.get(world, part.entity()).map_err(|error| error.to_string())?;
        let name = name.map_or_else(|| format!("Cloth{index}"), |name| name.to_string());
        let mesh = meshes.get(part.own_mesh()).ok_or_else(|| format!("{name} has lost its mesh"))?;
        exported.push(draped(name, mesh, transform)?);
    }
    std::fs::write(path, to_glb(&exported)?).map_err(|error| format!("cannot write {}: {error}", path.display()))
}

fn draped(name: String, mesh: &Mesh, transform: &GlobalTransform) -> Result<GlbMesh, String> {
    let vectors = |attribute| match mesh.attribute(attribute) {
        Some(VertexAttributeValues::Float32x3(values)) => values.iter().map(|&v| Vec3::from(v)).collect(),
        _ => Vec::new(),
    };
    let positions: Vec<Vec3> = vectors(Mesh::ATTRIBUTE_POSITION);
    let normals: Vec<Vec3> = vectors(Mesh::ATTRIBUTE_NORMAL);
    let uvs = match mesh.attribute(Mesh::ATTRIBUTE_UV_0) {
        Some(VertexAttributeValues::Float32x2(values)) => values.iter().map(|&v| Vec2::from(v)).collect(),
        _ => Vec::new(),
    };
    let indices = match mesh.indices() {
        Some(Indices::U32(indices)) => indices.clone(),
        Some(Indices::U16(indices)) => indices.iter().map(|&index| index.into()).collect(),
        None => (0..positions.len() as u32).collect(),
    };
    let affine = transform.affine();
    let normal_matrix = affine.matrix3.inverse().transpose();
    Ok(GlbMesh {
        name,
        positions: positions.into_iter().map(|p| affine.transform_point3(p)).collect(),
        normals: normals.into_iter().map(|n| (normal_matrix * n).normalize_or(Vec3::Y)).collect(),
        uvs,
        indices,
        base_color: [0.7, 0.12, 0.14, 1.0],
        ..default()
    })
}
