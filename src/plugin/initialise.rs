//! Building cloth from mesh assets: at first sight, when its mesh or its description changes.

use bevy::asset::LoadState;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::query::QueryData;
use bevy::math::{DAffine3, DVec3};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;
use bevy::reflect::TypeRegistration;

use super::advice::Told;
use super::budget::Share;
use super::components::ClothMesh;
use super::error::{ClothError, Faults, report};
use super::follow::Follower;
use super::geometry::extent;
use super::inertia::ClothInertia;
use super::material::ClothMaterial;
use super::mesh_io::{SourceMesh, own_copy};
use super::pace::Pace;
use super::pins::ClothPins;
use super::quality::{ClothDefaultQuality, ClothQuality, ClothSolver};
use super::shading::Shading;
use super::sources::{Attributes, Sources};
use super::state::{Binding, ClothState, Shown, ShownFrom, representatives, rest_shape, usable};
use crate::physics::Cloth;

#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct Candidate {
    entity: Entity,
    name: NameOrEntity,
    transform: Ref<'static, GlobalTransform>,
    mesh3d: Option<Ref<'static, Mesh3d>>,
    skinned: Has<SkinnedMesh>,
    children: Option<&'static Children>,
    cloth_mesh: Ref<'static, ClothMesh>,
    material: Ref<'static, ClothMaterial>,
    pins: Ref<'static, ClothPins>,
    solver: Option<Ref<'static, ClothSolver>>,
    quality: Option<&'static ClothQuality>,
    state: Option<&'static mut ClothState>,
    error: Option<&'static ClothError>,
}

/// What there is to do for an entity.
enum Task {
    Nothing,
    /// The own mesh is gone.
    Show,
    /// Something wrote to the source mesh.
    Compare,
    /// From this mesh; `None` is an entity without mesh.
    Build(Option<Handle<Mesh>>),
}

/// Why there is no cloth (yet).
enum NotBuilt {
    Loading,
    /// There is no asset, and nothing loads one. Somebody may have reserved its handle, and add it later.
    Missing,
    Refused(ClothError),
}

impl<E: Into<ClothError>> From<E> for NotBuilt {
    fn from(error: E) -> Self {
        Self::Refused(error.into())
    }
}

/// How near a vertex must be to another triangle's edge to look as if it belonged there, relative to the mesh: f32 positions are
/// not exact.
const RELATIVE_TOLERANCE: f64 = 1e-5;
/// Frames that a cloth waits for a mesh that nothing loads before it says so: some meshes are made on another thread.
const PATIENCE: u32 = 64;

/// Builds what is new or changed, see [`ClothSystems::Initialise`](super::ClothSystems::Initialise).
#[expect(clippy::too_many_arguments, reason = "a system")]
pub(super) fn initialise(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    server: Option<Res<AssetServer>>,
    default_quality: Res<ClothDefaultQuality>,
    mut sources: ResMut<Sources>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    mut missing: Local<EntityHashMap<u32>>,
    mut candidates: Query<Candidate>,
    with_mesh: Query<NameOrEntity, With<Mesh3d>>,
) {
    let (mut touched, mut removed) = (HashSet::new(), false);
    for event in events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => _ = touched.insert(*id),
            AssetEvent::Removed { .. } => removed = true,
            _ => {}
        }
    }
    if removed {
        sources.retain(&meshes);
    }
    for mut candidate in &mut candidates {
        let source = match candidate.task(&touched, &sources, &meshes) {
            Task::Nothing => continue,
            Task::Compare => match candidate.compare(&mut meshes) {
                Some(source) => Some(source),
                None => continue,
            },
            Task::Show => {
                candidate.show_again(&mut meshes, &mut sources, &mut commands);
                continue;
            }
            Task::Build(source) => source,
        };
        let waited = missing.remove(&candidate.entity).unwrap_or(0);
        match candidate.build(source, default_quality.0, &mut meshes, server.as_deref()) {
            Err(NotBuilt::Loading) => {}
            Err(NotBuilt::Missing) if waited < PATIENCE => _ = missing.insert(candidate.entity, waited + 1),
            Err(NotBuilt::Missing) => candidate.refuse(ClothError::MeshGone, &mut commands),
            Ok((mut state, aabb)) => {
                match &mut candidate.state {
                    // What was told of the same mesh need not be told again.
                    Some(old) if old.binding.mesh.has_shape_of(&state.binding.mesh) => {
                        state.told = core::mem::take(&mut old.told);
                    }
                    _ => tell_what_is_unusual(&candidate, &state),
                }
                sources.note(&state.binding.own, state.binding.source.clone());
                let own = Mesh3d(state.binding.own.clone());
                if let Ok(mut entity) = commands.get_entity(candidate.entity) {
                    entity
                        .try_insert((own, state, aabb, NoAutoAabb))
                        .try_remove::<(ClothError, SkinnedMesh)>()
                        .queue_silenced(remove_morph_weights);
                }
            }
            Err(NotBuilt::Refused(ClothError::NoMesh)) => {
                candidate.refuse(candidate.where_the_mesh_is(&with_mesh), &mut commands);
            }
            Err(NotBuilt::Refused(error)) => candidate.refuse(error, &mut commands),
        }
    }
    missing.retain(|&entity, _| candidates.contains(entity));
}

/// Bevy's component of this path is there with its feature `morph` only.
const MORPH_WEIGHTS: &str = "bevy_mesh::morph::MeshMorphWeights";

/// Takes away what asks for morph targets, which the own mesh has not: under the limits of WebGL 2 nothing opaque would be drawn
/// any more (Bevy #23811).
fn remove_morph_weights(mut entity: EntityWorldMut) {
    let Some(registry) = entity.world().get_resource::<AppTypeRegistry>() else { return };
    let weights = registry.read().get_with_type_path(MORPH_WEIGHTS).map(TypeRegistration::type_id);
    if let Some(weights) = weights.and_then(|weights| entity.world().components().get_id(weights)) {
        entity.remove_by_id(weights);
    }
}

/// A mesh that simulates, but not all as it was modelled.
fn tell_what_is_unusual(candidate: &CandidateItem, state: &ClothState) {
    let (name, shape) = (&candidate.name, state.cloth.shape());
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
    let [min, max] = extent(shape.positions.iter().copied());
    let tolerance = state.binding.options.weld_distance.unwrap_or(0.0).max(RELATIVE_TOLERANCE * min.distance(max));
    let open = shape.t_junctions(tolerance).len();
    if open > 0 {
        tracing::warn!(
            "cloth {name}: {open} vertices lie in the middle of another triangle's edge, and the mesh opens there: split these \
             edges at the vertices, so that both sides share them"
        );
    }
    if candidate.skinned {
        tracing::warn!(
            "cloth {name}: its mesh was skinned, and is not any more: cloth is simulated from the mesh as it was bound, and \
             `ClothPins` follow the entity, not the bones; make the entity a child of the bone that it hangs on, or set \
             `ClothPinTargets` from the bones"
        );
    }
}

impl CandidateItem<'_, '_> {
    fn task(&self, touched: &HashSet<AssetId<Mesh>>, sources: &Sources, meshes: &Assets<Mesh>) -> Task {
        let shown = self.mesh3d.as_ref().map(|mesh3d| &mesh3d.0);
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
        let Some(state) = &self.state else {
            let source = shown.map(|mesh| sources.of(mesh));
            let mesh_touched = source.as_ref().is_some_and(|mesh| touched.contains(&mesh.id()));
            let build = self.error.is_none() || mesh_touched || edited();
            return if build { Task::Build(source) } else { Task::Nothing };
        };
        let binding = &state.binding;
        if shown != Some(&binding.own) {
            return Task::Build(shown.map(|mesh| sources.of(mesh)));
        }
        let source_touched = touched.contains(&binding.source.id());
        let stale = binding.options != self.cloth_mesh.rest_shape_options()
            || (state.faults.rebuild.is_some() && (source_touched || edited()))
            || (state.faults.rebuild.is_none() && self.cloth_mesh.validate().is_err());
        if stale {
            Task::Build(Some(binding.source.clone()))
        } else if !meshes.contains(&binding.own) && (source_touched || state.faults.own_mesh.is_none()) {
            Task::Show
        } else if source_touched {
            Task::Compare
        } else {
            Task::Nothing
        }
    }

    /// Makes the own mesh anew, which somebody removed from the assets.
    fn show_again(&mut self, meshes: &mut Assets<Mesh>, sources: &mut Sources, commands: &mut Commands) {
        let Some(state) = &mut self.state else { return };
        let source = &state.binding.source;
        let Some(asset) = meshes.get(source).filter(|mesh| mesh.try_attributes().is_ok()) else {
            state.faults.own_mesh = Some(ClothError::OwnMeshGone);
            return;
        };
        let own = meshes.add(own_copy(asset, &state.shown.normals));
        sources.note(&own, source.clone());
        state.binding.own = own.clone();
        state.shown.from = None;
        state.faults.own_mesh = None;
        if let Ok(mut entity) = commands.get_entity(self.entity) {
            entity.try_insert(Mesh3d(own));
        }
    }

    /// The mesh of a node of a glTF file is on its child.
    fn where_the_mesh_is(&self, with_mesh: &Query<NameOrEntity, With<Mesh3d>>) -> ClothError {
        let mut children = self.children.into_iter().flatten().filter_map(|&child| with_mesh.get(child).ok());
        children.next().map_or(ClothError::NoMesh, |child| ClothError::MeshOnChild { child: child.to_string() })
    }

    /// Takes over what changed in the source; returns it if the cloth must be built again.
    fn compare(&mut self, meshes: &mut Assets<Mesh>) -> Option<Handle<Mesh>> {
        let state = self.state.as_mut()?;
        // One that has gone to the render world has nothing new to tell.
        let asset = meshes.get(&state.binding.source).filter(|mesh| mesh.try_attributes().is_ok())?;
        match state.take_over(asset) {
            Some(changes) => {
                changes.apply(&state.binding.own, meshes);
                None
            }
            None => Some(state.binding.source.clone()),
        }
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
                Some(LoadState::NotLoaded | LoadState::Loading) => Err(NotBuilt::Loading),
                Some(LoadState::Loaded) | None => Err(NotBuilt::Missing),
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
        let places = representatives.iter().map(|&v| mesh.positions[v as usize].as_dvec3());
        let bounds = extent(places);
        let aabb = Aabb::enclosing(&mesh.positions).unwrap_or_default();
        let shown = Shown {
            positions: mesh.positions.clone(),
            normals,
            from: Some(ShownFrom {
                revision: 0,
                alpha: 1.0,
                frame: anchor.inverse(),
                obstacles: Vec::new(),
                drawn: DAffine3::IDENTITY,
            }),
        };
        let mut binding = Binding {
            source,
            own: Handle::default(),
            options,
            mesh,
            attributes: Attributes::of(asset),
            shading,
            representatives,
            rest_linear: anchor.matrix3,
            bounds,
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
            limits: ClothInertia::default().limits()?,
            follower: Follower::default(),
            placed: true,
            met: Vec::new(),
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
            told: Told::default(),
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
