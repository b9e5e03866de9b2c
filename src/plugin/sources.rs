//! What each own mesh was made of, and what changes in that without changing the cloth.

use core::hash::BuildHasher;

use bevy::mesh::{MeshVertexAttribute, MeshVertexAttributeId, VertexAttributeValues};
use bevy::platform::collections::HashMap;
use bevy::platform::hash::FixedHasher;
use bevy::prelude::*;

use super::mesh_io::{JOINTS, SourceMesh};
use super::shading::Shading;
use super::state::ClothState;

/// The source of each own mesh that still exists. A clone of a running cloth shows the own mesh of its original: it is made
/// of the same source, also after the original is gone.
#[derive(Resource, Default)]
pub(super) struct Sources(HashMap<AssetId<Mesh>, Handle<Mesh>>);

impl Sources {
    /// What a cloth that shows this mesh is made of.
    pub fn of(&self, shown: &Handle<Mesh>) -> Handle<Mesh> {
        self.0.get(&shown.id()).unwrap_or(shown).clone()
    }

    /// Takes note of an own mesh.
    pub fn note(&mut self, own: &Handle<Mesh>, source: Handle<Mesh>) {
        self.0.insert(own.id(), source);
    }

    /// What was an own mesh is one like any other from now on.
    pub fn forget(&mut self, own: AssetId<Mesh>) {
        self.0.remove(&own);
    }

    /// Lets the sources of meshes that no longer exist go.
    pub fn retain(&mut self, meshes: &Assets<Mesh>) {
        self.0.retain(|&own, _| meshes.contains(own));
    }
}

/// Attributes of a source that go into the own mesh as they are, each with a hash of its values.
#[derive(Default)]
pub(super) struct Attributes(Vec<(MeshVertexAttributeId, u64)>);

impl Attributes {
    /// Those of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        Self(passed_on(mesh).map(|(attribute, values)| (attribute.id, hash(values))).collect())
    }

    fn contain(&self, id: MeshVertexAttributeId) -> bool {
        self.0.iter().any(|(other, _)| *other == id)
    }
}

/// What is neither simulated nor left out.
fn passed_on(mesh: &Mesh) -> impl Iterator<Item = (&MeshVertexAttribute, &VertexAttributeValues)> {
    let simulated = [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_TANGENT];
    let attributes = mesh.try_attributes().into_iter().flatten();
    attributes.filter(move |(attribute, _)| !simulated.iter().chain(&JOINTS).any(|other| other.id == attribute.id))
}

fn hash(values: &VertexAttributeValues) -> u64 {
    FixedHasher.hash_one(values.get_bytes())
}

impl ClothState {
    /// Takes over what changed in the sources of its parts while their shape stayed: colors and other attributes go into the own mesh, as do
    /// authored normals and tangents. `None` if the shape is another one, so that the cloth must be built again.
    pub(super) fn take_over(&mut self, sources: &[&Mesh]) -> Option<Vec<Changes>> {
        let Self { cloth, binding, .. } = self;
        let places = binding.parts.iter().map(|part| part.place);
        let mesh = SourceMesh::read_parts(sources.iter().copied().zip(places)).ok();
        let mesh = mesh.filter(|mesh| mesh.has_shape_of(&binding.mesh))?;
        let mut changes: Vec<Changes> = sources.iter().map(|_| Changes::default()).collect();
        if mesh.normals != binding.mesh.normals || mesh.tangents != binding.mesh.tangents {
            for (changes, source) in changes.iter_mut().zip(sources) {
                if let Ok(tangents) = source.try_attribute(Mesh::ATTRIBUTE_TANGENT) {
                    changes.inserted.push((Mesh::ATTRIBUTE_TANGENT, tangents.clone()));
                }
            }
            binding.shading = Shading::new(&mesh, &cloth.shape().simulated);
            binding.mesh = mesh;
            self.shown.from = None;
        }
        for ((part, source), changes) in binding.parts.iter_mut().zip(sources).zip(&mut changes) {
            let old = core::mem::replace(&mut part.attributes, Attributes::of(source));
            let changed = passed_on(source).zip(&part.attributes.0).filter(|(_, now)| !old.0.contains(now));
            changes.inserted.extend(changed.map(|((attribute, values), _)| (*attribute, values.clone())));
            let removed = old.0.iter().map(|(id, _)| *id).filter(|id| !part.attributes.contain(*id));
            changes.removed.extend(removed);
        }
        if changes.iter().any(|changes| !changes.inserted.is_empty() || !changes.removed.is_empty()) {
            // Rules may ask for what changed.
            self.pins_changed = None;
        }
        Some(changes)
    }
}

/// What is to be changed in an own mesh.
#[derive(Default)]
pub(super) struct Changes {
    inserted: Vec<(MeshVertexAttribute, VertexAttributeValues)>,
    removed: Vec<MeshVertexAttributeId>,
}

impl Changes {
    /// Makes them.
    pub fn apply(self, own: &Handle<Mesh>, meshes: &mut Assets<Mesh>) {
        if self.inserted.is_empty() && self.removed.is_empty() {
            return;
        }
        let Some(mut own) = meshes.get_mut(own) else { return };
        for id in self.removed {
            own.remove_attribute(id);
        }
        for (attribute, values) in self.inserted {
            own.insert_attribute(attribute, values);
        }
    }
}
