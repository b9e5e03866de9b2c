//! Stage and camera for a model of unknown size.

use crate::model::{descendants, mesh_of};
use bevy::prelude::*;
use example_common::{orbit_camera::OrbitCamera, scene::SceneCamera, stage::Stage};

/// Angle of the view to the side of the cloth's face, in radians.
const SIDEWAYS: f32 = 0.45;

/// Distance of the camera in radii of the model: a view of 45° sees most of it.
const DISTANCE_IN_RADII: f32 = 2.2;

/// A camera to begin with: the model is still loading.
pub fn spawn_camera(world: &mut World) {
    let camera = world.spawn(OrbitCamera { focus: Vec3::ZERO, distance: 5.0, yaw: 0.0, pitch: 0.1 }).id();
    world.insert_resource(SceneCamera(camera));
}

/// Puts ground under the model and the camera where it sees the outer face of the cloths.
pub fn frame(world: &mut World, root: Entity, cloths: &[Entity]) {
    let (least, greatest) = bounds(world, &descendants(world, root));
    let (cloth_least, cloth_greatest) = bounds(world, cloths);
    let middle = 0.5 * (least + greatest);
    let cloth_middle = 0.5 * (cloth_least + cloth_greatest);
    let radius = (0.5 * (greatest - least).length()).max(1e-3);

    let outwards: Vec3 = cloths.iter().map(|&cloth| mean_normal(world, cloth)).sum();
    let outwards = outwards.with_y(0.0).try_normalize().unwrap_or(Vec3::Z);
    let yaw = outwards.x.atan2(outwards.z) + SIDEWAYS;
    let camera = world.resource::<SceneCamera>().0;
    world.entity_mut(camera).insert(OrbitCamera {
        focus: middle.lerp(cloth_middle, 0.25),
        distance: DISTANCE_IN_RADII * radius,
        yaw,
        pitch: 0.12,
    });
    Stage { floor: middle.with_y(least.y), radius, yaw }.build(world, camera);
}

/// Least and greatest corner of a box around the meshes of these entities.
fn bounds(world: &World, entities: &[Entity]) -> (Vec3, Vec3) {
    let points = entities.iter().flat_map(|&entity| world_positions(world, entity));
    points.fold((Vec3::MAX, Vec3::MIN), |(least, greatest), p| (least.min(p), greatest.max(p)))
}

/// The vertices of an entity's mesh in the world; none without a mesh.
pub fn world_positions(world: &World, entity: Entity) -> Vec<Vec3> {
    let positions = mesh_of(world, entity).and_then(|mesh| mesh.attribute(Mesh::ATTRIBUTE_POSITION)?.as_float3());
    let (Some(positions), Some(transform)) = (positions, world.get::<GlobalTransform>(entity)) else {
        return Vec::new();
    };
    positions.iter().map(|&position| transform.transform_point(position.into())).collect()
}

fn mean_normal(world: &World, entity: Entity) -> Vec3 {
    let normals = mesh_of(world, entity).and_then(|mesh| mesh.attribute(Mesh::ATTRIBUTE_NORMAL)?.as_float3());
    let (Some(normals), Some(transform)) = (normals, world.get::<GlobalTransform>(entity)) else { return Vec3::ZERO };
    let local: Vec3 = normals.iter().map(|&normal| Vec3::from(normal)).sum();
    transform.affine().transform_vector3(local)
}
