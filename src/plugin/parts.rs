//! The meshes that a cloth is made of: that of its entity, or those of its children. A mesh of several materials comes from a glTF file
//! as several meshes under one node.

use core::ops::Range;

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::ecs::query::QueryData;
use bevy::math::DAffine3;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy::reflect::TypeRegistration;

use super::components::ClothMesh;
use super::mesh_io;
use super::saving::ClothSource;
use super::sources::{Attributes, Sources};
use super::state::{ClothState, Shown};

/// A mesh of a running cloth, see [`ClothState::parts`].
pub struct ClothPart {
    pub(super) entity: Entity,
    /// From the space of the mesh to that of the cloth's entity.
    pub(super) place: Transform,
    pub(super) vertices: Range<u32>,
    pub(super) source: Handle<Mesh>,
    pub(super) own: Handle<Mesh>,
    /// What else of the source the own mesh has.
    pub(super) attributes: Attributes,
}

impl ClothPart {
    /// The entity with the [`Mesh3d`]: that of the cloth, or a child of it.
    pub fn entity(&self) -> Entity {
        self.entity
    }

    /// Its vertices among those of the cloth: what [`ClothPins`](super::ClothPins) and
    /// [`ClothPinTargets`](super::ClothPinTargets) call `vertices().start + i` is vertex `i` of this mesh.
    pub fn vertices(&self) -> Range<u32> {
        self.vertices.clone()
    }

    /// The mesh asset that it was made of, as [`Mesh3d`] was set.
    pub fn source_mesh(&self) -> &Handle<Mesh> {
        &self.source
    }

    /// The copy that the cloth deforms: what [`Mesh3d`] is now.
    pub fn own_mesh(&self) -> &Handle<Mesh> {
        &self.own
    }

    /// A part that has no mesh of its own yet, its vertices from `first` on.
    pub(super) fn new(wanted: &Wanted, first: u32, asset: &Mesh) -> Self {
        let count = asset.try_attribute(Mesh::ATTRIBUTE_POSITION).map_or(0, |positions| positions.len());
        Self {
            entity: wanted.entity,
            place: wanted.place,
            vertices: first..first + count as u32,
            source: wanted.source.clone(),
            own: Handle::default(),
            attributes: Attributes::of(asset),
        }
    }

    /// What it was made of.
    pub(super) fn wanted(&self) -> Wanted {
        Wanted { entity: self.entity, place: self.place, source: self.source.clone() }
    }

    /// Its range among the vertices of the cloth.
    pub(super) fn range(&self) -> Range<usize> {
        self.vertices.start as usize..self.vertices.end as usize
    }

    /// From the space of the cloth's entity to that of the mesh; `None` where they are the same.
    fn inward(&self) -> Option<DAffine3> {
        // It was usable when the cloth was built.
        let outward = || GlobalTransform::from(self.place).affine().as_daffine3();
        (self.place != Transform::IDENTITY).then(|| outward().inverse())
    }

    /// Its normals among those of the cloth, in the space of the mesh.
    pub(super) fn normals(&self, of_cloth: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let normals = &of_cloth[self.range()];
        let Some(inward) = self.inward() else { return normals.to_vec() };
        let covariant = inward.matrix3.inverse().transpose();
        let turned = |&normal: &[f32; 3]| (covariant * Vec3::from(normal).as_dvec3()).normalize_or_zero().as_vec3();
        normals.iter().map(|normal| turned(normal).to_array()).collect()
    }

    /// Writes what the cloth shows to its mesh, and returns the bounds of that.
    pub(super) fn write(&self, mesh: &mut Mesh, shown: &Shown, tangents: &[[f32; 4]]) -> Option<Aabb> {
        let positions = &shown.positions[self.range()];
        let tangents = tangents.get(self.range()).unwrap_or_default();
        let Some(inward) = self.inward() else {
            let places: Vec<[f32; 3]> = positions.iter().map(|p| p.to_array()).collect();
            mesh_io::write(mesh, &places, &shown.normals[self.range()], tangents);
            return Aabb::enclosing(positions);
        };
        let places: Vec<Vec3> = positions.iter().map(|p| inward.transform_point3(p.as_dvec3()).as_vec3()).collect();
        let tangents: Vec<[f32; 4]> = tangents
            .iter()
            .map(|&[x, y, z, w]| {
                let along = inward.transform_vector3(Vec3::new(x, y, z).as_dvec3()).normalize_or_zero().as_vec3();
                along.extend(w).to_array()
            })
            .collect();
        let bounds = Aabb::enclosing(&places);
        let places: Vec<[f32; 3]> = places.into_iter().map(Into::into).collect();
        mesh_io::write(mesh, &places, &self.normals(&shown.normals), &tangents);
        bounds
    }
}

impl ClothState {
    /// The meshes that show the cloth: one, or those of the children of its entity in their order. Never empty.
    pub fn parts(&self) -> &[ClothPart] {
        &self.binding.parts
    }
}

/// An entity whose mesh may be cloth, or a part of one.
#[derive(QueryData)]
pub(super) struct Member {
    pub entity: Entity,
    pub mesh3d: Ref<'static, Mesh3d>,
    pub skinned: Has<SkinnedMesh>,
    transform: &'static Transform,
    is_cloth: Has<ClothMesh>,
}

/// A mesh that a cloth is to be made of.
pub(super) struct Wanted {
    pub entity: Entity,
    pub place: Transform,
    pub source: Handle<Mesh>,
}

impl MemberItem<'_, '_> {
    /// From the space of its mesh to that of a cloth.
    pub fn place(&self, cloth: Entity) -> Transform {
        if self.entity == cloth { Transform::IDENTITY } else { *self.transform }
    }

    /// Whether its handle was set, or Bevy says that the asset changed.
    pub fn is_changed(&self) -> bool {
        self.mesh3d.is_changed()
    }

    pub fn wanted(&self, cloth: Entity, sources: &Sources) -> Wanted {
        Wanted { entity: self.entity, place: self.place(cloth), source: sources.of(&self.mesh3d.0) }
    }
}

/// What a cloth is to be made of: its own mesh; without one, those of its children that are no cloth themselves.
pub(super) fn members<'a, 's>(
    cloth: Entity,
    children: Option<&'a Children>,
    all: &'a Query<'_, 's, Member>,
) -> impl Iterator<Item = MemberItem<'a, 's>> {
    let own = all.get(cloth).ok();
    let children = children.filter(|_| own.is_none()).into_iter().flatten();
    own.into_iter().chain(children.filter_map(|&child| all.get(child).ok()).filter(|member| !member.is_cloth))
}

/// Bevy's component of this path is there with its feature `morph` only.
const MORPH_WEIGHTS: &str = "bevy_mesh::morph::MeshMorphWeights";

/// Takes away what asks for morph targets, which the own mesh has not: under the limits of WebGL 2 nothing opaque would be drawn
/// any more (Bevy #23811).
pub(super) fn remove_morph_weights(mut entity: EntityWorldMut) {
    let Some(registry) = entity.world().get_resource::<AppTypeRegistry>() else { return };
    let weights = registry.read().get_with_type_path(MORPH_WEIGHTS).map(TypeRegistration::type_id);
    if let Some(weights) = weights.and_then(|weights| entity.world().components().get_id(weights)) {
        entity.remove_by_id(weights);
    }
}

/// Leaves a mesh as it is draped: its cloth goes on without it.
pub(super) fn release(mut entity: EntityWorldMut) {
    // It may have become a cloth of its own.
    if !entity.contains::<ClothMesh>() {
        entity.remove::<(ClothSource, NoAutoAabb)>();
    }
}
