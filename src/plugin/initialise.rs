//! Building cloth from mesh assets: at first sight, when its mesh or its description changes.

use bevy::asset::LoadState;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::ecs::name::NameOrEntityItem;
use bevy::ecs::query::QueryData;
use bevy::math::DVec3;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use super::budget::Share;
use super::components::ClothMesh;
use super::error::{ClothError, Faults, report};
use super::material::ClothMaterial;
use super::mesh_io::{SourceMesh, own_copy};
use super::pace::Pace;
use super::pins::ClothPins;
use super::quality::{ClothDefaultQuality, ClothQuality, ClothSolver};
use super::shading::Shading;
use super::state::{Binding, ClothState, Shown, ShownFrom, representatives, rest_shape, usable};
use crate::physics::Cloth;

#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct Candidate {
    entity: Entity,
    name: NameOrEntity,
    transform: Ref<'static, GlobalTransform>,
    mesh3d: Option<Ref<'static, Mesh3d>>,
    cloth_mesh: Ref<'static, ClothMesh>,
    material: Ref<'static, ClothMaterial>,
    pins: Ref<'static, ClothPins>,
    solver: Option<Ref<'static, ClothSolver>>,
    quality: Option<&'static ClothQuality>,
    state: Option<&'static mut ClothState>,
    error: Option<&'static ClothError>,
}

/// Why there is no cloth (yet).
enum NotBuilt {
    Loading,
    Refused(ClothError),
}

impl<E: Into<ClothError>> From<E> for NotBuilt {
    fn from(error: E) -> Self {
        Self::Refused(error.into())
    }
}

/// Builds what is new or changed, see [`ClothSystems::Initialise`](super::ClothSystems::Initialise).
pub(super) fn initialise(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    server: Option<Res<AssetServer>>,
    default_quality: Res<ClothDefaultQuality>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    mut candidates: Query<Candidate>,
) {
    let touched: HashSet<AssetId<Mesh>> = events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for mut candidate in &mut candidates {
        let Some(source) = candidate.wants_building(&touched) else { continue };
        match candidate.build(source, default_quality.0, &mut meshes, server.as_deref()) {
            Err(NotBuilt::Loading) => {}
            Ok((state, aabb)) => {
                tell_what_is_unusual(&candidate.name, &state);
                let own = Mesh3d(state.binding.own.clone());
                if let Ok(mut entity) = commands.get_entity(candidate.entity) {
                    entity.try_insert((own, state, aabb, NoAutoAabb)).try_remove::<(ClothError, SkinnedMesh)>();
                }
            }
            Err(NotBuilt::Refused(error)) => candidate.refuse(error, &mut commands),
        }
    }
}

/// A mesh that simulates, but not all as it was modelled.
fn tell_what_is_unusual(name: &NameOrEntityItem, state: &ClothState) {
    let shape = state.cloth.shape();
    if !shape.dropped.is_empty() {
        let count = shape.dropped.len();
        tracing::info!("cloth {name}: {count} triangles have no area, or the vertices of another: they get no forces");
    }
    if !shape.non_manifold.is_empty() {
        let count = shape.non_manifold.len();
        tracing::info!(
            "cloth {name}: three or more triangles meet at {count} edges, and bend there against each other"
        );
    }
}

impl CandidateItem<'_, '_> {
    /// The mesh to build from, if there is a reason to build; the inner `None` is an entity without mesh.
    fn wants_building(&mut self, touched: &HashSet<AssetId<Mesh>>) -> Option<Option<Handle<Mesh>>> {
        let shown = self.mesh3d.as_ref().map(|mesh3d| mesh3d.0.clone());
        let solver_changed = match &self.solver {
            Some(solver) => solver.is_changed(),
            // It was taken away if its settings are still held against the cloth.
            None => matches!(self.error, Some(ClothError::Solver(_))),
        };
        let edited = || {
            self.cloth_mesh.is_changed()
                || self.material.is_changed()
                || self.pins.is_changed()
                || solver_changed
                || self.transform.is_changed()
                || self.mesh3d.as_ref().is_some_and(Ref::is_changed)
        };
        let Some(state) = &mut self.state else {
            let mesh_touched = shown.as_ref().is_some_and(|mesh| touched.contains(&mesh.id()));
            return (self.error.is_none() || mesh_touched || edited()).then_some(shown);
        };
        // What the frame that built the cloth did to the mesh is announced in the next one.
        let announced = core::mem::replace(&mut state.binding.fresh, false);
        let binding = &state.binding;
        if shown.as_ref() != Some(&binding.own) {
            return Some(shown);
        }
        let stale = binding.options != self.cloth_mesh.rest_shape_options()
            || (touched.contains(&binding.source.id()) && !announced)
            || (state.faults.rebuild.is_some() && edited())
            || (state.faults.rebuild.is_none() && self.cloth_mesh.validate().is_err());
        stale.then(|| Some(binding.source.clone()))
    }

    fn build(
        &self,
        source: Option<Handle<Mesh>>,
        default_quality: ClothQuality,
        meshes: &mut Assets<Mesh>,
        server: Option<&AssetServer>,
    ) -> Result<(ClothState, Aabb), NotBuilt> {
        let source = source.ok_or(ClothError::NoMesh)?;
        self.cloth_mesh.validate()?;
        let Some(asset) = meshes.get(&source) else {
            return match server.and_then(|server| server.get_load_state(&source)) {
                Some(LoadState::Failed(reason)) => Err(ClothError::MeshNotLoaded { reason: reason.to_string() }.into()),
                _ => Err(NotBuilt::Loading),
            };
        };
        let anchor = usable(&self.transform)?;
        let options = self.cloth_mesh.rest_shape_options();
        let mesh = SourceMesh::read(asset)?;
        let shape = rest_shape(&mesh, anchor.matrix3, &options)?;
        let shading = Shading::new(&mesh, &shape.simulated);
        let pins = self.pins.resolve(asset, &mesh.positions, &shading.rest_normals)?;

        let normals: Vec<[f32; 3]> = shading.rest_normals.iter().map(|n| n.to_array()).collect();
        let copy = own_copy(asset, &normals);
        let representatives = representatives(&shape);
        let centre = representatives.iter().map(|&v| mesh.positions[v as usize].as_dvec3()).sum::<DVec3>()
            / representatives.len() as f64;
        let aabb = Aabb::enclosing(&mesh.positions).unwrap_or_default();
        let shown = Shown {
            positions: mesh.positions.clone(),
            normals,
            from: Some(ShownFrom { revision: 0, alpha: 1.0, frame: anchor.inverse() }),
        };
        let mut binding = Binding {
            source,
            own: Handle::default(),
            options,
            mesh,
            shading,
            representatives,
            rest_linear: anchor.matrix3,
            centre,
            fresh: true,
        };
        let positions = binding.rest_positions(anchor);
        let quality = *self.quality.unwrap_or(&default_quality);
        let settings = self.solver.as_ref().map_or_else(|| quality.settings(), |solver| solver.0);
        settings.validate()?;
        let mut cloth = Cloth::new(shape, self.material.0, settings)?;
        cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
        // Last, so that a refused cloth leaves no asset behind.
        binding.own = meshes.add(copy);
        let state = ClothState {
            cloth,
            binding,
            pins,
            pins_changed: Some(self.pins.last_changed()),
            previous_positions: positions,
            anchor,
            previous_anchor: anchor,
            seen_anchor: anchor,
            pace: Pace::default(),
            ticks: None,
            near: Vec::new(),
            resumed: Vec::new(),
            quality: self.solver.is_none().then_some(quality),
            share: Share::default(),
            stepped: false,
            suspended: false,
            revision: 0,
            shown,
            report: None,
            step_length: 0.0,
            faults: Faults::default(),
        };
        Ok((state, aabb))
    }

    /// A cloth whose mesh is still its own goes on as it was; any other stops.
    fn refuse(&mut self, error: ClothError, commands: &mut Commands) {
        if let Some(state) = &mut self.state
            && self.mesh3d.as_ref().is_some_and(|mesh3d| mesh3d.0 == state.binding.own)
        {
            state.binding.options = self.cloth_mesh.rest_shape_options();
            state.faults.rebuild = Some(error);
            return;
        }
        if let Ok(mut entity) = commands.get_entity(self.entity) {
            entity.try_remove::<(ClothState, NoAutoAabb)>();
        }
        report(commands, &self.name, self.error, Some(&error));
    }
}
