//! From a mesh asset to a running cloth.

use crate::common::*;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy_cloth::plugin::*;

#[test]
fn mesh_and_cloth_mesh_are_enough() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ());
    run(&mut app, 10);
    // Ten steps of 1/64 s in free fall with the cotton's air drag of 1/s: v' = g − v.
    let t = 10.0 / 64.0_f32;
    let fall = 9.81 * (t - 1.0 + (-t).exp());
    for (now, rest) in world(&app, cloth).iter().zip(vectors(&sheet(), Mesh::ATTRIBUTE_POSITION)) {
        assert_near(*now, rest - Vec3::Y * fall, 2e-4);
    }
    assert!(error(&app, cloth).is_none());
}

#[test]
fn a_mesh_that_loads_late_starts_where_the_entity_then_is() {
    let mut app = app();
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let cloth = app.world_mut().spawn((Mesh3d(handle.clone()), ClothMesh::default(), ClothPins::indices([0]))).id();
    run(&mut app, 5);
    assert!(app.world().get::<ClothState>(cloth).is_none() && error(&app, cloth).is_none());

    app.world_mut().get_mut::<Transform>(cloth).unwrap().translation.x = 3.0;
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(handle.id(), sheet()).unwrap();
    run(&mut app, 1);
    assert_near(world(&app, cloth)[4], Vec3::X * 4.0, 1e-6);
    run(&mut app, 30);
    assert_near(world(&app, cloth)[0], Vec3::X * 3.0, 1e-6);
    assert!(world(&app, cloth)[4].y < -0.5, "the free corner swings down: {}", world(&app, cloth)[4]);
}

#[test]
fn cloths_that_share_a_handle_do_not_share_a_mesh() {
    let mut app = app();
    let handle = add_mesh(&mut app, sheet());
    let [hanging, falling] = [top_edge(), ClothPins::none()]
        .map(|pins| app.world_mut().spawn((Mesh3d(handle.clone()), ClothMesh::default(), pins)).id());
    let plain = app.world_mut().spawn(Mesh3d(handle.clone())).id();
    run(&mut app, 30);
    let [hanging, falling, plain] = [hanging, falling, plain].map(|entity| world(&app, entity));
    assert_eq!(hanging[0], Vec3::ZERO);
    assert!(falling[0].y < -0.5, "{}", falling[0]);
    assert_eq!(plain, vectors(&sheet(), Mesh::ATTRIBUTE_POSITION), "the asset itself is not touched");
}

#[test]
fn the_users_attributes_are_kept_and_skinning_is_not() {
    let count = COUNT as usize;
    let colors: Vec<[f32; 4]> = (0..count).map(|i| [i as f32, 0.0, 0.5, 1.0]).collect();
    let skinned = sheet()
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(vec![[0; 4]; count]))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0, 0.0, 0.0, 0.0]; count]);
    let mut app = app();
    let cloth = spawn(&mut app, skinned.clone(), SkinnedMesh::default());
    run(&mut app, 2);
    let own = mesh(&app, cloth);
    assert_eq!(own.indices(), skinned.indices());
    for kept in [Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_COLOR] {
        let [ours, theirs] = [own, &skinned].map(|mesh| mesh.attribute(kept).unwrap().get_bytes());
        assert_eq!(ours, theirs);
    }
    assert!(!own.contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX));
    assert!(!own.contains_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT));
    assert!(app.world().get::<SkinnedMesh>(cloth).is_none());
}

#[test]
fn a_triangle_strip_is_cloth_too() {
    let strip = Mesh::new(PrimitiveTopology::TriangleStrip, default())
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            (0..12).map(|i| [(i % 2) as f32 * 0.2, (i / 2) as f32 * -0.2, 0.0]).collect::<Vec<_>>(),
        )
        .with_inserted_indices(Indices::U32((0..12).collect()));
    let mut app = app();
    let cloth = spawn(&mut app, strip, top_edge());
    run(&mut app, 20);
    assert_eq!(state(&app, cloth).cloth().shape().triangles.len(), 10);
    assert_eq!(mesh(&app, cloth).primitive_topology(), PrimitiveTopology::TriangleStrip);
    let normals = vectors(mesh(&app, cloth), Mesh::ATTRIBUTE_NORMAL);
    assert!(normals.iter().all(|n| n.z < -0.9), "added, along the winding: {normals:?}");
}

#[test]
fn a_vertex_without_triangle_stays_where_it_is() {
    let lonely = sheet();
    let mut positions = vectors(&lonely, Mesh::ATTRIBUTE_POSITION);
    positions.push(Vec3::new(0.5, 0.5, 0.5));
    let lonely = lonely
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_removed_attribute(Mesh::ATTRIBUTE_NORMAL)
        .with_removed_attribute(Mesh::ATTRIBUTE_UV_0);
    let mut app = app();
    let cloth = spawn(&mut app, lonely, top_edge());
    run(&mut app, 5);
    assert_eq!(state(&app, cloth).simulated_vertex(COUNT), None);
    assert_eq!(local(&app, cloth)[COUNT as usize], Vec3::splat(0.5));
}
