//! Cloth that is where it cannot be.

use bevy::prelude::*;
use bevy_cloth::prelude::*;

/// How deep the deepest vertex of a cloth is inside a collider, in metres; zero if none is. Colliders must not be scaled.
pub fn deepest(world: &mut World) -> f32 {
    let mut colliders = world.query::<(&ClothCollider, &GlobalTransform)>();
    let mut cloths = world.query::<&ClothState>();
    let mut deepest: f32 = 0.0;
    for (collider, transform) in colliders.iter(world) {
        let (shape, to_local) = (collider.shape(), transform.affine().inverse());
        for position in cloths.iter(world).flat_map(|state| state.cloth().positions()) {
            let local = to_local.transform_point3(position.as_vec3());
            if shape.contains_local_point(local) {
                deepest = deepest.max(shape.project_local_point(local, false).point.distance(local));
            }
        }
    }
    deepest
}
