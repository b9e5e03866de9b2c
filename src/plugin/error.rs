//! What can be wrong with a cloth, and what to do about it.

use bevy::ecs::name::NameOrEntityItem;
use bevy::prelude::*;
use thiserror::Error;

use super::state::ClothState;
use crate::physics::{ContactSettingsError, MaterialError, MeshError, NewClothError, SettingsError, SnapshotError};

/// Why an entity with [`ClothMesh`](super::ClothMesh) is not simulated as it should be.
///
/// Inserted on the entity and logged once, [`ClothError::Transform`] as a warning, as things may grow out of nothing; removed
/// again when the cause is gone. A cloth that already runs goes on with its last good settings; one that could not start is
/// tried again when one of its components or its mesh changes.
#[derive(Component, Clone, Debug, Error, Reflect)]
#[reflect(Component, Clone, Debug)]
#[non_exhaustive]
pub enum ClothError {
    /// No [`Mesh3d`], neither beside [`ClothMesh`](super::ClothMesh) nor on a child.
    #[error("there is no mesh: add `Mesh3d` beside `ClothMesh`, or to children of its entity")]
    NoMesh,
    /// No [`Mesh3d`] here or on children, but further down: so does Bevy spawn the scene of a glTF file.
    #[error("there is no mesh here or on children, but the children of {node} have one: put `ClothMesh` on {node}")]
    MeshBelow {
        /// The name of what is above the mesh, or its entity if it has none.
        node: String,
    },
    /// The handle of [`Mesh3d`] leads to no asset, and nothing loads one.
    #[error(
        "there is no mesh asset behind `Mesh3d`, and nothing loads one: the handle is `Handle::default()`, or the asset was \
         removed; give it a handle from `Assets::<Mesh>::add` or `AssetServer::load`"
    )]
    MeshGone,
    /// The mesh that shows the cloth was removed from the assets, and so was the one it was made of.
    #[error(
        "the mesh that shows the cloth was removed from `Assets<Mesh>`, and so was its source: the cloth moves on unseen; give \
         it another `Mesh3d`"
    )]
    OwnMeshGone,
    /// A field of [`ClothMesh`](super::ClothMesh) is not a finite number, or is negative where it must not be.
    #[error("`ClothMesh::{field}` must be finite, and a distance not negative")]
    Description {
        /// The field.
        field: &'static str,
    },
    /// The mesh asset failed to load.
    #[error("the mesh did not load: {reason}")]
    MeshNotLoaded {
        /// What the asset server says.
        reason: String,
    },
    /// The mesh has been moved to the render world.
    #[error(
        "the mesh is in the render world only: load or build it with `RenderAssetUsages::default()`, which includes \
         MAIN_WORLD"
    )]
    MeshExtracted,
    /// The mesh is no surface.
    #[error("the mesh is a {topology}: cloth needs a TriangleList or TriangleStrip")]
    Topology {
        /// Its topology.
        topology: String,
    },
    /// No positions, or not three f32 each.
    #[error("the positions of the mesh are {found}: cloth needs `Mesh::ATTRIBUTE_POSITION` as Float32x3")]
    Positions {
        /// What there is.
        found: String,
    },
    /// The geometry cannot be cloth.
    #[error("{0}: repair the mesh, or check `ClothMesh::weld_distance` and the scale of the entity")]
    Mesh(#[from] MeshError),
    /// A rule of [`ClothPins`](super::ClothPins) names a vertex that does not exist.
    #[error("`ClothPins` names vertex {vertex}, but the mesh has {count} vertices")]
    PinIndex {
        /// The vertex named.
        vertex: u32,
        /// Number of vertices.
        count: u32,
    },
    /// A rule of [`ClothPins`](super::ClothPins) names an attribute that the mesh has not, or not in this format.
    #[error("`ClothPins` needs the vertex attribute `{attribute}` as {format}: the mesh has {found}")]
    PinAttribute {
        /// Name of the attribute.
        attribute: String,
        /// The format needed.
        format: String,
        /// The format found, or "none".
        found: String,
    },
    /// [`ClothPinTargets`](super::ClothPinTargets) names a vertex that does not exist.
    #[error("`ClothPinTargets` names vertex {vertex}, but the mesh has {count} vertices")]
    PinTargetIndex {
        /// The vertex named.
        vertex: u32,
        /// Number of vertices.
        count: u32,
    },
    /// A place in [`ClothPinTargets`](super::ClothPinTargets) is NaN or infinite.
    #[error("`ClothPinTargets` holds vertex {vertex} at a place that is not finite")]
    PinTargetNotFinite {
        /// The vertex.
        vertex: u32,
    },
    /// The fabric cannot exist.
    #[error("`ClothMaterial`: {0}")]
    Material(#[from] MaterialError),
    /// The settings of the solver cannot be used.
    #[error("`ClothSolver`: {0}")]
    Solver(#[from] SettingsError),
    /// How it meets colliders cannot be.
    #[error("`ClothContact`: {0}")]
    Contact(#[from] ContactSettingsError),
    /// A field of [`ClothInertia`](super::ClothInertia) is NaN or negative.
    #[error("`ClothInertia::{field}` is {value}: it must be a number that is not negative")]
    Inertia {
        /// The field.
        field: &'static str,
        /// What it is.
        value: String,
    },
    /// The transform is not finite, or squashes the cloth.
    #[error("the transform of the entity is not finite or has a scale of zero: the cloth waits until it is usable")]
    Transform,
    /// A [`ClothSnapshot`](super::ClothSnapshot), or positions and velocities, that the cloth cannot be put into: it goes on as it was.
    #[error("the cloth cannot be put into this state: {reason}")]
    State {
        /// What is wrong with it.
        reason: String,
    },
    /// The last step failed: the cloth kept its place and lost its velocity.
    #[error(
        "the last step was rejected ({reason}): the cloth keeps its place; look for pins that are too far apart, gravity \
         that is not finite, extreme constants of the material or a huge time step"
    )]
    Diverged {
        /// What the solver says.
        reason: String,
    },
}

impl From<NewClothError> for ClothError {
    fn from(error: NewClothError) -> Self {
        match error {
            NewClothError::Fabric(error) => error.into(),
            NewClothError::Settings(error) => error.into(),
        }
    }
}

impl From<SnapshotError> for ClothError {
    fn from(error: SnapshotError) -> Self {
        Self::State { reason: error.to_string() }
    }
}

impl ClothError {
    /// Whether both say the same. (Not `PartialEq`: constants that are NaN must equal themselves here.)
    pub(super) fn same_as(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }

    /// Whether it may be meant, as for what grows out of nothing: a warning in the log.
    fn may_be_meant(&self) -> bool {
        matches!(self, Self::Transform)
    }
}

/// What is wrong with a cloth that runs, by what checks it.
#[derive(Default)]
pub(super) struct Faults {
    /// Building it again failed.
    pub rebuild: Option<ClothError>,
    pub own_mesh: Option<ClothError>,
    pub transform: Option<ClothError>,
    pub material: Option<ClothError>,
    pub solver: Option<ClothError>,
    pub contact: Option<ClothError>,
    pub inertia: Option<ClothError>,
    pub pins: Option<ClothError>,
    pub pin_targets: Option<ClothError>,
    /// A state that it could not be put into; until another can, or it is reset.
    pub state: Option<ClothError>,
    pub diverged: Option<ClothError>,
}

impl Faults {
    /// The one to tell the user about first.
    pub fn first(&self) -> Option<&ClothError> {
        let by_weight = [
            &self.rebuild,
            &self.own_mesh,
            &self.transform,
            &self.material,
            &self.solver,
            &self.contact,
            &self.inertia,
            &self.pins,
            &self.pin_targets,
            &self.state,
            &self.diverged,
        ];
        by_weight.into_iter().find_map(Option::as_ref)
    }
}

/// Brings the [`ClothError`] of an entity up to date, and logs a new one.
pub(super) fn report(
    commands: &mut Commands,
    name: &NameOrEntityItem,
    shown: Option<&ClothError>,
    error: Option<&ClothError>,
) {
    let Ok(mut entity) = commands.get_entity(name.entity) else { return };
    match (shown, error) {
        (Some(shown), Some(error)) if shown.same_as(error) => {}
        (_, Some(error)) => {
            if error.may_be_meant() {
                tracing::warn!("cloth {name}: {error}");
            } else {
                tracing::error!("cloth {name}: {error}");
            }
            entity.try_insert(error.clone());
        }
        (Some(_), None) => {
            entity.try_remove::<ClothError>();
        }
        (None, None) => {}
    }
}

/// Shows on each running cloth what is wrong with it.
pub(super) fn report_faults(mut commands: Commands, cloths: Query<(NameOrEntity, &ClothState, Option<&ClothError>)>) {
    for (name, state, shown) in &cloths {
        report(&mut commands, &name, shown, state.faults.first());
    }
}
