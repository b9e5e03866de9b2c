//! Showing the cloth: from world positions to the vertices of its mesh.

use bevy::camera::primitives::Aabb;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::budget::Keeper;
use super::components::ClothDisabled;
use super::contact::ClothCollider;
use super::mesh_io;
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
) {
    let start = Instant::now();
    let fraction = if interpolate.0 { fixed.overstep_fraction().clamp(0.0, 1.0) } else { 1.0 };
    for (mut state, transform, aabb, disabled) in &mut cloths {
        let Some(from) = state.to_show(transform, fraction, disabled, &colliders) else { continue };
        let Some(mut mesh) = meshes.get_mut(&state.binding.own) else { continue };
        let tangents = state.show(from);
        let shown = &state.shown;
        let positions: Vec<[f32; 3]> = shown.positions.iter().map(|p| p.to_array()).collect();
        mesh_io::write(&mut mesh, &positions, &shown.normals, &tangents);
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
