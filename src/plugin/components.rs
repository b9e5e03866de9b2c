//! What a user puts on an entity, pins aside.

use std::collections::BTreeMap;

use bevy::prelude::*;

use super::error::ClothError;
use super::material::ClothMaterial;
use super::pins::ClothPins;
use crate::physics::{BendingModel, RestShapeOptions};

/// Makes the mesh of this entity's [`Mesh3d`] cloth; on an entity without one, the meshes of its children, as one cloth.
///
/// The mesh as it stands, scaled by the entity's transform, is the undeformed cloth. The entity gets a copy of its own,
/// so several cloths may share a mesh handle. A clone of the entity, or another cloth on the handle of that copy, is made of
/// the same source as the first, at rest. Where something writes positions, indices or texture coordinates of the source, the
/// cloth is built again; other attributes, such as colors, are taken over while it runs. A
/// [`SkinnedMesh`](bevy::mesh::skinning::SkinnedMesh) or `MeshMorphWeights` beside it is removed: cloth takes the mesh as it
/// is bound.
///
/// # Meshes of several materials
/// A glTF file gives Bevy such a mesh as several: a node, and for each material a child of it with a [`Mesh3d`]. Put the component on the
/// node, and all these are one cloth, whose [`ClothState`](super::ClothState) is on the node: vertices at the same place are welded as
/// within one mesh, so no border opens, and normals run smoothly across it. Each child keeps its material, its visibility and its bounds.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_cloth::prelude::*;
/// /// The node "Cape" of each scene that is spawned.
/// fn make_cape(named: On<Add, Name>, names: Query<&Name>, mut commands: Commands) {
///     if names.get(named.entity).is_ok_and(|name| name.as_str() == "Cape") {
///         commands.entity(named.entity).insert((ClothMesh::default(), ClothPins::where_color(PinChannel::Red, 0.5)));
///     }
/// }
/// # App::new().add_observer(make_cape);
/// ```
///
/// All that is said of a cloth is said on the node: its material, its pins. Pins and positions are in the space of the node, and vertices
/// are numbered through the children in their order ([`ClothState::parts`](super::ClothState::parts)). A rule that asks for an attribute,
/// such as a color, asks each mesh that has it. Only children count, not what is further down, and no child with a `ClothMesh` of its own.
/// With another child, one less, or one at another place in the node, the cloth is built again, at rest; a mesh that was let go of stays
/// as it was draped. A clone of the node needs clones of its children (`EntityCloner`'s `linked_cloning`).
///
/// # When it is built again
/// Changing any field builds the cloth again, at rest. A new scale of the entity does
/// not: the cloth is measured again and goes on. Removing the component ends the simulation and leaves the mesh as it was draped; trigger
/// [`ClothReset`](super::ClothReset) first, or set [`Mesh3d`] to
/// [`ClothState::source_mesh`](super::ClothState::source_mesh), to have it undeformed. Added again, it takes the
/// mesh as it then is for the undeformed one.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ClothMaterial, ClothPins, Transform)]
#[component(on_add = super::id::give_later)]
pub struct ClothMesh {
    /// Vertices nearer than this are one (they are split along seams of normals and texture coordinates), m. `None`: 1e-5
    /// of the diagonal of what triangles use of the mesh. The default.
    pub weld_distance: Option<f32>,
    /// Take the warp direction from the texture coordinates (growing u) where there are usable ones. True by default.
    pub warp_from_uvs: bool,
    /// Angle from growing u to the warp, rad, counter-clockwise seen against the normal. 0 by default.
    pub warp_angle: f32,
    /// The fabric is flat at rest: folds modelled into the mesh try to open. False by default.
    pub rest_flat: bool,
    /// How it bends: the rigidity of the fabric whatever the mesh, which is the default, or at the least cost.
    pub bending: BendingModel,
}

impl Default for ClothMesh {
    fn default() -> Self {
        Self {
            weld_distance: None,
            warp_from_uvs: true,
            warp_angle: 0.0,
            rest_flat: false,
            bending: BendingModel::default(),
        }
    }
}

impl ClothMesh {
    /// Refuses what is not a number: it would not even equal itself.
    pub(super) fn validate(&self) -> Result<(), ClothError> {
        let distance = |value: f32| value >= 0.0 && value.is_finite();
        let fields =
            [("weld_distance", self.weld_distance.is_none_or(distance)), ("warp_angle", self.warp_angle.is_finite())];
        match fields.into_iter().find(|(_, valid)| !valid) {
            Some((field, _)) => Err(ClothError::Description { field }),
            None => Ok(()),
        }
    }

    /// What the physics needs to know.
    pub(super) fn rest_shape_options(&self) -> RestShapeOptions {
        RestShapeOptions {
            weld_distance: self.weld_distance.map(f64::from),
            warp_from_uvs: self.warp_from_uvs,
            warp_angle: self.warp_angle.into(),
            rest_flat: self.rest_flat,
            bending: self.bending,
        }
    }
}

/// Freezes a cloth: no cost, the mesh stays as it is and moves rigidly with the entity. Once the component is removed, the
/// cloth goes on from there.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothDisabled;

/// Vertices held at given places, to grab and move cloth at run time: vertex of the mesh → place in the entity's space.
///
/// They are held whether or not [`ClothPins`] pins them, and reach the place exactly at the end of the next step. Remove
/// an entry to let go.
#[derive(Component, Clone, Debug, Default, PartialEq, Deref, DerefMut, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothPinTargets(pub BTreeMap<u32, Vec3>);

/// Acceleration of gravity for every cloth, m/s²; 9.81 down by default.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Deref, DerefMut, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct ClothGravity(pub Vec3);

impl Default for ClothGravity {
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}
