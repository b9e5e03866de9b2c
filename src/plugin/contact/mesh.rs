//! Colliders made of mesh assets, once these are loaded.

use core::hash::{Hash, Hasher};

use bevy::asset::LoadState;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use super::collider::ClothCollider;
use super::error::{ClothColliderError, report};

/// Makes the mesh of this entity's [`Mesh3d`] a [`ClothCollider`], when it is loaded and again when it changes.
///
/// Building takes milliseconds for thousands of triangles: it is for meshes that keep their shape. It is built again if positions or
/// triangles of the mesh are others, not if anything else of it changes. A mesh that is moved by bones is refused: capsules on these
/// follow them, [`ClothCollider::capsule_between`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform)]
pub struct ClothMeshCollider {
    /// What is made of it.
    pub shape: ClothMeshShape,
    /// See [`ClothCollider::friction`]; 0.5 by default.
    pub friction: f32,
    /// See [`ClothCollider::teleport_speed`], m/s; 100 by default.
    pub teleport_speed: f32,
}

/// What a [`ClothMeshCollider`] makes of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
pub enum ClothMeshShape {
    /// Its triangles: [`ClothCollider::from_mesh`].
    #[default]
    Surface,
    /// The convex hull of its vertices: [`ClothCollider::hull_of_mesh`]. Coarser, and cheaper to touch.
    Hull,
}

impl Default for ClothMeshCollider {
    fn default() -> Self {
        Self {
            shape: ClothMeshShape::default(),
            friction: ClothCollider::FRICTION,
            teleport_speed: ClothCollider::TELEPORT_SPEED,
        }
    }
}

/// What a collider was built of: [`geometry`].
#[derive(Component)]
pub(in crate::plugin) struct Built(u64);

type Wanted<'a> = (
    NameOrEntity,
    Ref<'a, ClothMeshCollider>,
    Option<Ref<'a, Mesh3d>>,
    Has<ClothCollider>,
    Has<SkinnedMesh>,
    Option<&'a Built>,
    Option<&'a ClothColliderError>,
);

/// Builds what is new or changed.
pub(in crate::plugin) fn shape_meshes(
    mut commands: Commands,
    meshes: Res<Assets<Mesh>>,
    server: Option<Res<AssetServer>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    wanted: Query<Wanted>,
) {
    let modified: HashSet<AssetId<Mesh>> = events
        .read()
        .filter_map(|event| if let AssetEvent::Modified { id } = event { Some(*id) } else { None })
        .collect();
    for (name, description, mesh, built, skinned, geometry_before, shown) in &wanted {
        let waits = !built && shown.is_none();
        let edited = description.is_changed()
            || mesh.is_none()
            || skinned != (shown == Some(&ClothColliderError::Skinned))
            // It may have been loaded after all.
            || (!built && mesh.as_ref().is_some_and(|mesh| meshes.contains(&mesh.0)) && is_of_loading(shown));
        // Bevy marks the handle as changed, too, where only the asset was.
        let written = mesh.as_ref().is_some_and(|mesh| mesh.is_changed() || modified.contains(&mesh.id()));
        if !(waits || edited || written) {
            continue;
        }
        let asset = mesh.as_ref().and_then(|mesh| meshes.get(&mesh.0));
        let now = asset.map(geometry);
        if !(waits || edited) && now.is_some() && now == geometry_before.map(|before| before.0) {
            continue;
        }
        let made = if skinned {
            Err(ClothColliderError::Skinned)
        } else {
            // What is said of the mesh while it is built names the entity.
            let _entity = tracing::info_span!("cloth collider", name = %name).entered();
            description.make(mesh.as_deref(), &meshes, server.as_deref())
        };
        let Ok(mut entity) = commands.get_entity(name.entity) else { continue };
        match made {
            Ok(Some(collider)) => {
                tracing::debug!("cloth collider {name}: {:?}", collider.kind());
                entity.try_insert((collider, Built(now.unwrap_or_default()))).try_remove::<ClothColliderError>();
            }
            Ok(None) => {
                entity.try_remove::<(ClothCollider, Built, ClothColliderError)>();
            }
            Err(error) => {
                entity.try_remove::<(ClothCollider, Built)>();
                report(&mut commands, &name, shown, Some(error));
            }
        }
    }
}

/// A number for the positions and triangles of a mesh, the same in every run.
fn geometry(mesh: &Mesh) -> u64 {
    let mut hasher = std::hash::DefaultHasher::new();
    mesh.primitive_topology().hash(&mut hasher);
    if let Ok(VertexAttributeValues::Float32x3(positions)) = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) {
        positions.iter().for_each(|position| position.map(f32::to_bits).hash(&mut hasher));
    }
    match mesh.try_indices() {
        Ok(Indices::U16(indices)) => indices.hash(&mut hasher),
        Ok(Indices::U32(indices)) => indices.hash(&mut hasher),
        Err(_) => {}
    }
    hasher.finish()
}

fn is_of_loading(shown: Option<&ClothColliderError>) -> bool {
    matches!(shown, Some(ClothColliderError::MeshNotLoaded(_)))
}

impl ClothMeshCollider {
    /// The collider; `None` while the mesh is loading.
    fn make(
        &self,
        mesh: Option<&Mesh3d>,
        meshes: &Assets<Mesh>,
        server: Option<&AssetServer>,
    ) -> Result<Option<ClothCollider>, ClothColliderError> {
        let handle = &mesh.ok_or(ClothColliderError::NoMesh)?.0;
        let Some(mesh) = meshes.get(handle) else {
            return match server.and_then(|server| server.get_load_state(handle)) {
                Some(LoadState::Failed(reason)) => Err(ClothColliderError::MeshNotLoaded(reason.to_string())),
                _ => Ok(None),
            };
        };
        let collider = match self.shape {
            ClothMeshShape::Surface => ClothCollider::from_mesh(mesh),
            ClothMeshShape::Hull => ClothCollider::hull_of_mesh(mesh),
        }?;
        // The mesh describes it.
        let collider = ClothCollider::undescribed(collider.shape().clone());
        Ok(Some(collider.with_friction(self.friction).with_teleport_speed(self.teleport_speed)))
    }
}

/// Takes the collider away with its description.
pub(in crate::plugin) fn end(removed: On<Remove, ClothMeshCollider>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<(ClothCollider, ClothColliderError, Built)>();
    }
}
