//! Colliders made of mesh assets: before, while and after they are loaded.

use crate::common::*;
use bevy::asset::RenderAssetUsages;
use bevy::mesh::PrimitiveTopology;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_cloth::parry3d::shape::ShapeType;
use bevy_cloth::plugin::*;

fn block(size: f32) -> Mesh {
    Cuboid::from_length(size).into()
}

fn extent(app: &App, entity: Entity) -> Option<f32> {
    Some(app.world().get::<ClothCollider>(entity)?.shape().compute_local_aabb().extents().x)
}

fn spawn_collider(app: &mut App, mesh: Handle<Mesh>, description: ClothMeshCollider) -> Entity {
    let entity = app.world_mut().spawn((Mesh3d(mesh), description)).id();
    run(app, 2);
    entity
}

#[test]
fn a_mesh_that_is_there_is_made_a_collider_at_once() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let mesh = add_mesh(&mut app, block(1.0));
    let description = ClothMeshCollider { friction: 0.75, ..default() };
    let collider = spawn_collider(&mut app, mesh.clone(), description);
    let built = app.world().get::<ClothCollider>(collider).expect("a collider");
    assert_eq!((built.shape().shape_type(), built.friction), (ShapeType::TriMesh, 0.75));
    run(&mut app, 1);
    assert_eq!(given_in_last_step(&mut app, cloth), [collider]);

    let hull = ClothMeshCollider { shape: ClothMeshShape::Hull, ..description };
    app.world_mut().entity_mut(collider).insert(hull);
    run(&mut app, 1);
    let built = app.world().get::<ClothCollider>(collider).expect("a collider");
    assert_eq!(built.shape().shape_type(), ShapeType::ConvexPolyhedron);

    // Another mesh, and another content of it.
    let larger = add_mesh(&mut app, block(2.0));
    app.world_mut().entity_mut(collider).insert(Mesh3d(larger.clone()));
    run(&mut app, 1);
    assert_eq!(extent(&app, collider), Some(2.0));
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&larger).unwrap() = block(3.0);
    run(&mut app, 2);
    assert_eq!(extent(&app, collider), Some(3.0));

    app.world_mut().entity_mut(collider).remove::<ClothMeshCollider>();
    run(&mut app, 1);
    assert_eq!(extent(&app, collider), None);
    assert!(given_in_last_step(&mut app, cloth).is_empty());
}

#[test]
fn nothing_is_built_again_without_a_reason() {
    let mut app = app();
    let mesh = add_mesh(&mut app, block(1.0));
    let collider = spawn_collider(&mut app, mesh, default());
    let changed = |app: &App| app.world().entity(collider).get_ref::<ClothCollider>().unwrap().last_changed();
    let before = changed(&app);
    run(&mut app, 5);
    assert_eq!(changed(&app), before);
}

#[test]
fn a_mesh_that_loads_is_waited_for() {
    let mut app = app();
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let collider = spawn_collider(&mut app, handle.clone(), default());
    run(&mut app, 5);
    assert!(extent(&app, collider).is_none() && collider_error(&app, collider).is_none());
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&handle, block(1.5)).unwrap();
    run(&mut app, 1);
    assert_eq!(extent(&app, collider), Some(1.5));

    // Likewise when another takes its place, which is not there as long.
    let later = app.world().resource::<Assets<Mesh>>().reserve_handle();
    app.world_mut().entity_mut(collider).insert(Mesh3d(later.clone()));
    run(&mut app, 2);
    assert_eq!(extent(&app, collider), None);
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&later, block(0.5)).unwrap();
    run(&mut app, 1);
    assert_eq!(extent(&app, collider), Some(0.5));
}

#[test]
fn what_is_wrong_with_the_mesh_is_told_and_mended() {
    let mut extracted = block(1.0);
    extracted.asset_usage = RenderAssetUsages::RENDER_WORLD;
    extracted.take_gpu_data().unwrap();
    let lines = Mesh::new(PrimitiveTopology::LineList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0; 3]; 4]);
    let empty = Mesh::new(PrimitiveTopology::TriangleList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new());
    let bare = block(1.0).with_removed_attribute(Mesh::ATTRIBUTE_POSITION);
    let cases = [(extracted, "MAIN_WORLD"), (lines, "LineList"), (empty, "triangles are needed"), (bare, "missing")];
    for (mesh, part) in cases {
        let mut app = app();
        let good = add_mesh(&mut app, block(1.0));
        let bad = add_mesh(&mut app, mesh);
        // From the start, and later.
        for first in [&bad, &good] {
            let collider = spawn_collider(&mut app, first.clone(), default());
            app.world_mut().entity_mut(collider).insert(Mesh3d(bad.clone()));
            run(&mut app, 2);
            let error = collider_error(&app, collider).expect("an error").to_string();
            assert!(error.contains(part), "{error}");
            assert!(extent(&app, collider).is_none());
            app.world_mut().entity_mut(collider).insert(Mesh3d(good.clone()));
            run(&mut app, 2);
            assert!(collider_error(&app, collider).is_none());
            assert_eq!(extent(&app, collider), Some(1.0));
        }
    }
}

#[test]
fn no_mesh_is_told_too() {
    let mut app = app();
    let collider = app.world_mut().spawn(ClothMeshCollider::default()).id();
    run(&mut app, 2);
    assert_eq!(collider_error(&app, collider), Some(&ClothColliderError::NoMesh));
    let mesh = add_mesh(&mut app, block(1.0));
    app.world_mut().entity_mut(collider).insert(Mesh3d(mesh));
    run(&mut app, 2);
    assert!(collider_error(&app, collider).is_none());
    app.world_mut().entity_mut(collider).remove::<Mesh3d>();
    run(&mut app, 2);
    assert_eq!(collider_error(&app, collider), Some(&ClothColliderError::NoMesh));
    app.world_mut().entity_mut(collider).remove::<ClothMeshCollider>();
    run(&mut app, 1);
    assert!(collider_error(&app, collider).is_none());
}

/// Something else writes colors into the mesh in every frame.
#[test]
fn only_other_positions_or_triangles_build_it_again() {
    let mut app = app();
    let mesh = add_mesh(&mut app, block(1.0));
    let collider = spawn_collider(&mut app, mesh.clone(), default());
    let changed = |app: &App| app.world().entity(collider).get_ref::<ClothCollider>().unwrap().last_changed();
    run(&mut app, 2);
    let before = changed(&app);
    for shade in 0..5 {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        let colors = vec![[0.1 * shade as f32; 4]; 24];
        meshes.get_mut(&mesh).unwrap().insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
        run(&mut app, 1);
    }
    run(&mut app, 2);
    assert_eq!(changed(&app), before);
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap() = block(1.5);
    run(&mut app, 2);
    assert_eq!(extent(&app, collider), Some(1.5));
}

#[test]
fn a_skinned_mesh_is_refused_until_it_is_none() {
    let mut app = app();
    let mesh = add_mesh(&mut app, block(1.0));
    let collider = app.world_mut().spawn((Mesh3d(mesh), ClothMeshCollider::default(), SkinnedMesh::default())).id();
    for _ in 0..2 {
        run(&mut app, 2);
        assert_eq!(collider_error(&app, collider), Some(&ClothColliderError::Skinned));
        assert!(extent(&app, collider).is_none());
        app.world_mut().entity_mut(collider).remove::<SkinnedMesh>();
        run(&mut app, 2);
        assert!(collider_error(&app, collider).is_none() && extent(&app, collider).is_some());
        app.world_mut().entity_mut(collider).insert(SkinnedMesh::default());
    }
}
