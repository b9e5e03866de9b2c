//! The mesh of a running cloth, for those who save worlds.

use bevy::prelude::*;

use super::state::ClothState;

/// The mesh that a running cloth was made of: inserted beside each [`Mesh3d`] that shows it, so that a saved world knows it.
///
/// While a cloth runs, its [`Mesh3d`] is a copy of its own, which no file has: a world saved by reflection (Bevy's `DynamicWorld`)
/// has the default handle there, and Bevy warns of that. An entity that is loaded with this component and the
/// default handle takes the mesh named here. So nothing has to be done for a mesh that is loaded from a file. The handle of a mesh
/// that is built in code survives only if it is one of a UUID, under which the game adds the mesh again:
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy::asset::uuid_handle;
/// const SHEET: Handle<Mesh> = uuid_handle!("3d9a7c1e-6c1b-4c0e-9f63-2a5d0f3c8b11");
/// fn add_sheet(mut meshes: ResMut<Assets<Mesh>>) {
///     let sheet = Plane3d::new(Vec3::Z, Vec2::splat(0.5)).mesh().subdivisions(30);
///     meshes.insert(&SHEET, sheet.into()).expect("no such mesh yet");
/// }
/// ```
///
/// What comes back with a world: the components of cloths and colliders, [`ClothCollider`](super::ClothCollider)s with their
/// [shapes](super::ClothShape), and the motion of each cloth if a [`ClothSnapshot`](super::ClothSnapshot) was inserted before saving.
/// What does not: [pins](super::ClothPins) that are functions of the vertex.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct ClothSource(pub Handle<Mesh>);

/// Notes the meshes of a cloth that starts, or starts again.
pub(super) fn note(started: On<Insert, ClothState>, states: Query<&ClothState>, mut commands: Commands) {
    for part in states.get(started.entity).into_iter().flat_map(ClothState::parts) {
        if let Ok(mut entity) = commands.get_entity(part.entity()) {
            entity.try_insert(ClothSource(part.source_mesh().clone()));
        }
    }
}

type Loaded<'a> = (Entity, &'a Mesh3d, &'a ClothSource);

/// Gives a loaded cloth the meshes that it was made of.
pub(super) fn take(mut commands: Commands, loaded: Query<Loaded, Without<ClothState>>) {
    for (entity, mesh, source) in &loaded {
        if mesh.0 == Handle::default()
            && source.0 != Handle::default()
            && let Ok(mut entity) = commands.get_entity(entity)
        {
            entity.try_insert(Mesh3d(source.0.clone()));
        }
    }
}
