//! The same meshes as assets.

use bevy::camera::primitives::Aabb;
use bevy::math::DVec3;
use bevy::mesh::{Indices, MeshPlugin, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::plugin::{ClothError, ClothMesh, ClothPins, ClothPlugin, ClothState};
use proptest::prelude::*;

use crate::cases;
use crate::generators::Surface;
use crate::mesh_input::any_mesh;

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, ClothPlugin::default()))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.finish();
    app.cleanup();
    app
}

/// The mesh as an asset, in f32.
fn asset(surface: &Surface) -> Mesh {
    let positions: Vec<_> = surface.positions.iter().map(|p: &DVec3| p.as_vec3().to_array()).collect();
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(surface.triangles.as_flattened().to_vec()));
    if let Some(uvs) = &surface.uvs {
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs.clone());
    }
    mesh
}

fn finite(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> bool {
    match mesh.attribute(attribute) {
        Some(VertexAttributeValues::Float32x3(values)) => values.as_flattened().iter().all(|v| v.is_finite()),
        _ => false,
    }
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn a_mesh_gives_cloth_that_is_shown_or_an_error(surface in any_mesh()) {
        let mut app = app();
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(asset(&surface));
        let bundle = (Mesh3d(mesh), ClothMesh::default(), ClothPins::indices([]), Aabb::default());
        let cloth = app.world_mut().spawn(bundle).id();
        for _ in 0..6 {
            app.update();
        }
        let entity = app.world().entity(cloth);
        let error = entity.get::<ClothError>();
        let Some(state) = entity.get::<ClothState>() else {
            prop_assert!(error.is_some(), "neither cloth nor error");
            return Ok(());
        };
        prop_assert!(matches!(error, None | Some(ClothError::Diverged { .. })), "{error:?}");
        prop_assert!(state.last_report().is_some());
        let mesh = app.world().resource::<Assets<Mesh>>().get(state.own_mesh()).expect("its own mesh");
        prop_assert!(finite(mesh, Mesh::ATTRIBUTE_POSITION) && finite(mesh, Mesh::ATTRIBUTE_NORMAL));
        let bounds = entity.get::<Aabb>().expect("bounds");
        prop_assert!(bounds.center.is_finite() && bounds.half_extents.is_finite(), "{bounds:?}");
    }
}
