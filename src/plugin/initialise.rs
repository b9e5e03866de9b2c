//! Building cloth from mesh assets: at first sight, when its mesh or its description changes.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::query::QueryData;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use super::build::NotBuilt;
use super::components::ClothMesh;
use super::error::{ClothError, report};
use super::geometry::extent;
use super::material::ClothMaterial;
use super::mesh_io::own_copy;
use super::parts::{ClothPart, Member, MemberItem, Wanted, members, release, remove_morph_weights};
use super::pins::ClothPins;
use super::quality::{ClothDefaultQuality, ClothQuality, ClothSolver};
use super::sources::Sources;
use super::state::ClothState;

#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct Candidate {
    entity: Entity,
    name: NameOrEntity,
    pub transform: Ref<'static, GlobalTransform>,
    children: Option<Ref<'static, Children>>,
    pub cloth_mesh: Ref<'static, ClothMesh>,
    pub material: Ref<'static, ClothMaterial>,
    pub pins: Ref<'static, ClothPins>,
    pub solver: Option<Ref<'static, ClothSolver>>,
    pub quality: Option<&'static ClothQuality>,
    state: Option<&'static mut ClothState>,
    error: Option<&'static ClothError>,
}

/// What there is to do for an entity.
enum Task {
    Nothing,
    /// An own mesh is gone.
    Show,
    /// Something wrote to a source mesh.
    Compare,
    /// From these meshes, if there are any.
    Build(Vec<Wanted>),
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
    with_mesh: Query<Member>,
    families: Query<(NameOrEntity, &Children)>,
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
        let wanted = match candidate.task(&touched, &sources, &meshes, &with_mesh) {
            Task::Nothing => continue,
            Task::Compare => match candidate.compare(&mut meshes) {
                Some(wanted) => wanted,
                None => continue,
            },
            Task::Show => {
                candidate.show_again(&mut meshes, &mut sources, &mut commands);
                continue;
            }
            Task::Build(wanted) => wanted,
        };
        let waited = missing.remove(&candidate.entity).unwrap_or(0);
        match candidate.build(&wanted, default_quality.0, &mut meshes, server.as_deref()) {
            Err(NotBuilt::Loading) => {}
            Err(NotBuilt::Missing) if waited < PATIENCE => _ = missing.insert(candidate.entity, waited + 1),
            Err(NotBuilt::Missing) => candidate.refuse(ClothError::MeshGone, &with_mesh, &mut commands),
            Ok(mut state) => {
                match &mut candidate.state {
                    // What was told of the same mesh need not be told again.
                    Some(old) if old.binding.mesh.has_shape_of(&state.binding.mesh) => {
                        state.told = core::mem::take(&mut old.told);
                    }
                    _ => tell_what_is_unusual(&candidate, &state, &with_mesh),
                }
                candidate.release_others(&state, &mut commands);
                candidate.begin(state, &mut sources, &mut commands);
            }
            Err(NotBuilt::Refused(ClothError::NoMesh)) => {
                let error = candidate.where_the_mesh_is(&with_mesh, &families);
                candidate.refuse(error, &with_mesh, &mut commands);
            }
            Err(NotBuilt::Refused(error)) => candidate.refuse(error, &with_mesh, &mut commands),
        }
    }
    missing.retain(|&entity, _| candidates.contains(entity));
}

/// A mesh that simulates, but not all as it was modelled.
fn tell_what_is_unusual(candidate: &CandidateItem, state: &ClothState, with_mesh: &Query<Member>) {
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
    if candidate.members(with_mesh).any(|member| member.skinned) {
        tracing::warn!(
            "cloth {name}: its mesh was skinned, and is not any more: cloth is simulated from the mesh as it was bound, and \
             `ClothPins` follow the entity, not the bones; make the entity a child of the bone that it hangs on, or set \
             `ClothPinTargets` from the bones"
        );
    }
}

impl CandidateItem<'_, '_> {
    fn members<'a, 's>(&'a self, with_mesh: &'a Query<'_, 's, Member>) -> impl Iterator<Item = MemberItem<'a, 's>> {
        members(self.entity, self.children.as_deref(), with_mesh)
    }

    /// Whether its meshes are those that it deforms.
    fn shows(&self, parts: &[ClothPart], with_mesh: &Query<Member>) -> bool {
        let mut parts = parts.iter();
        let is_next = |member: MemberItem| {
            parts.next().is_some_and(|part| {
                let place = member.place(self.entity);
                part.entity == member.entity && part.own == member.mesh3d.0 && part.place == place
            })
        };
        self.members(with_mesh).all(is_next) && parts.next().is_none()
    }

    fn task(
        &self,
        touched: &HashSet<AssetId<Mesh>>,
        sources: &Sources,
        meshes: &Assets<Mesh>,
        with_mesh: &Query<Member>,
    ) -> Task {
        let wanted = || self.members(with_mesh).map(|member| member.wanted(self.entity, sources)).collect::<Vec<_>>();
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
                || self.children.as_ref().is_some_and(Ref::is_changed)
                || self.members(with_mesh).any(|member| member.is_changed())
        };
        let Some(state) = &self.state else {
            let wanted = wanted();
            let mesh_touched = wanted.iter().any(|wanted| touched.contains(&wanted.source.id()));
            let build = self.error.is_none() || mesh_touched || edited();
            return if build { Task::Build(wanted) } else { Task::Nothing };
        };
        let binding = &state.binding;
        if !self.shows(&binding.parts, with_mesh) {
            return Task::Build(wanted());
        }
        let source_touched = binding.parts.iter().any(|part| touched.contains(&part.source.id()));
        let stale = binding.options != self.cloth_mesh.rest_shape_options()
            || (state.faults.rebuild.is_some() && (source_touched || edited()))
            || (state.faults.rebuild.is_none() && self.cloth_mesh.validate().is_err());
        let all_there = || binding.parts.iter().all(|part| meshes.contains(&part.own));
        if stale {
            Task::Build(binding.parts.iter().map(ClothPart::wanted).collect())
        } else if !all_there() && (source_touched || state.faults.own_mesh.is_none()) {
            Task::Show
        } else if source_touched {
            Task::Compare
        } else {
            Task::Nothing
        }
    }

    /// Makes own meshes anew, which somebody removed from the assets.
    fn show_again(&mut self, meshes: &mut Assets<Mesh>, sources: &mut Sources, commands: &mut Commands) {
        let Some(state) = &mut self.state else { return };
        let ClothState { binding, shown, faults, .. } = &mut **state;
        for part in binding.parts.iter_mut() {
            if meshes.contains(&part.own) {
                continue;
            }
            let Some(asset) = meshes.get(&part.source).filter(|mesh| mesh.try_attributes().is_ok()) else {
                faults.own_mesh = Some(ClothError::OwnMeshGone);
                return;
            };
            let own = meshes.add(own_copy(asset, &part.normals(&shown.normals)));
            sources.note(&own, part.source.clone());
            part.own = own.clone();
            if let Ok(mut entity) = commands.get_entity(part.entity) {
                entity.try_insert(Mesh3d(own));
            }
        }
        shown.from = None;
        faults.own_mesh = None;
    }

    /// Where `ClothMesh` should be instead, if meshes are further down than on children.
    fn where_the_mesh_is(&self, with_mesh: &Query<Member>, families: &Query<(NameOrEntity, &Children)>) -> ClothError {
        let mut nodes: Vec<Entity> = self.children.iter().flat_map(|children| children.iter()).collect();
        let mut next = 0;
        while let Some(&node) = nodes.get(next) {
            next += 1;
            let Ok((name, children)) = families.get(node) else { continue };
            if members(node, Some(children), with_mesh).next().is_some() {
                return ClothError::MeshBelow { node: name.to_string() };
            }
            nodes.extend(children);
        }
        ClothError::NoMesh
    }

    /// Takes over what changed in the sources; returns them if the cloth must be built again.
    fn compare(&mut self, meshes: &mut Assets<Mesh>) -> Option<Vec<Wanted>> {
        let state = self.state.as_mut()?;
        // One that has gone to the render world has nothing new to tell.
        let readable = |part: &ClothPart| meshes.get(&part.source).filter(|mesh| mesh.try_attributes().is_ok());
        let assets = state.binding.parts.iter().map(readable).collect::<Option<Vec<_>>>()?;
        let changes = state.take_over(&assets);
        let parts = &state.binding.parts;
        let Some(changes) = changes else { return Some(parts.iter().map(ClothPart::wanted).collect()) };
        for (changes, part) in changes.into_iter().zip(parts) {
            changes.apply(&part.own, meshes);
        }
        None
    }

    /// Shows a cloth that was built.
    fn begin(&self, state: ClothState, sources: &mut Sources, commands: &mut Commands) {
        for part in state.parts() {
            sources.note(&part.own, part.source.clone());
            if let Ok(mut entity) = commands.get_entity(part.entity) {
                let aabb = Aabb::enclosing(&state.binding.mesh.positions[part.range()]).unwrap_or_default();
                entity
                    .try_insert((Mesh3d(part.own.clone()), aabb, NoAutoAabb))
                    .try_remove::<SkinnedMesh>()
                    .queue_silenced(remove_morph_weights);
            }
        }
        if let Ok(mut entity) = commands.get_entity(self.entity) {
            let aabb = Aabb::enclosing(&state.binding.mesh.positions).unwrap_or_default();
            entity.try_insert((state, aabb, NoAutoAabb)).try_remove::<ClothError>();
        }
    }

    /// Lets go of meshes that were parts of the cloth and are none of this one.
    fn release_others(&self, state: &ClothState, commands: &mut Commands) {
        for old in self.state.iter().flat_map(|old| old.parts()) {
            if state.parts().iter().all(|part| part.entity != old.entity)
                && old.entity != self.entity
                && let Ok(mut entity) = commands.get_entity(old.entity)
            {
                entity.queue_silenced(release);
            }
        }
    }

    /// A cloth whose meshes are still its own goes on as it was; any other stops.
    fn refuse(&mut self, error: ClothError, with_mesh: &Query<Member>, commands: &mut Commands) {
        if self.state.as_ref().is_some_and(|state| self.shows(&state.binding.parts, with_mesh)) {
            let Some(state) = &mut self.state else { return };
            state.binding.options = self.cloth_mesh.rest_shape_options();
            state.faults.rebuild = Some(error);
            return;
        }
        for part in self.state.iter().flat_map(|state| state.parts()) {
            if let Ok(mut entity) = commands.get_entity(part.entity) {
                entity.try_remove::<NoAutoAabb>();
            }
        }
        if let Ok(mut entity) = commands.get_entity(self.entity) {
            entity.try_remove::<(ClothState, NoAutoAabb)>();
        }
        report(commands, &self.name, self.error, Some(&error));
    }
}
