//! Showing the cloth: from world positions to the vertices of its mesh.

use bevy::camera::primitives::Aabb;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::budget::Keeper;
use super::components::ClothDisabled;
use super::contact::ClothCollider;
use super::state::{ClothState, ShownFrom};

/// Whether [`write_back`] interpolates between steps.
#[derive(Resource)]
pub(super) struct Interpolate(pub bool);

/// See [`ClothSystems::WriteBack`](super::ClothSystems::WriteBack).
pub(super) fn write_back(
    interpolate: Res<Interpolate>,
    mut keeper: ResMut<Keeper>,
    fixed: Res<Time<Fixed>>,
    mut meshes: ResMut<Assets<Mesh>>,
    colliders: Query<&GlobalTransform, With<ClothCollider>>,
    mut cloths: Query<(&mut ClothState, &GlobalTransform, Option<&mut Aabb>, Has<ClothDisabled>)>,
    mut children: Query<&mut Aabb, (With<ChildOf>, Without<ClothState>)>,
) {
    let start = Instant::now();
    let fraction = if interpolate.0 { fixed.overstep_fraction().clamp(0.0, 1.0) } else { 1.0 };
    for (mut state, transform, aabb, disabled) in &mut cloths {
        let Some(from) = state.to_show(transform, fraction, disabled, &colliders) else { continue };
        if !state.binding.parts.iter().all(|part| meshes.contains(&part.own)) {
            continue;
        }
        let tangents = state.show(from);
        let shown = &state.shown;
        for part in &state.binding.parts {
            let Some(mut mesh) = meshes.get_mut(&part.own) else { continue };
            let bounds = part.write(&mut mesh, shown, &tangents);
            if let (Ok(mut aabb), Some(bounds)) = (children.get_mut(part.entity), bounds) {
                *aabb = bounds;
            }
        }
        if let (Some(mut aabb), Some(bounds)) = (aabb, Aabb::enclosing(&shown.positions)) {
            *aabb = bounds;
        }
    }
    keeper.spent.write_back += start.elapsed();
}

impl ClothState {
    /// Computes what is shown, and returns the tangents.
    fn show(&mut self, from: ShownFrom) -> Vec<[f32; 4]> {
        let pictured = self.pictured(&from);
        let Self { cloth, binding, shown, .. } = self;
        // Vertices without triangle are not simulated: they keep their place in the mesh.
        for (place, simulated) in shown.positions.iter_mut().zip(&cloth.shape().simulated) {
            if let Some(simulated) = simulated {
                *place = pictured[*simulated as usize].as_vec3();
            }
        }
        shown.normals = binding.shading.normals(&binding.mesh.triangles, &shown.positions);
        shown.from = Some(from);
        binding.shading.tangents(&binding.mesh.triangles, &shown.positions, &shown.normals)
    }
}
