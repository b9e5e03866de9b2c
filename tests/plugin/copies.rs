//! Cloths made of what other cloths show, and source meshes that others write to.

use crate::common::*;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

fn meshes(app: &App) -> usize {
    app.world().resource::<Assets<Mesh>>().len()
}

/// Mean height of the vertices of a cloth above where its entity is, m.
fn height(app: &App, cloth: Entity) -> f32 {
    let at = app.world().get::<GlobalTransform>(cloth).expect("a transform").translation().y;
    world(app, cloth).iter().map(|p| p.y - at).sum::<f32>() / COUNT as f32
}

/// Clones a cloth, to 3 m beside it.
fn clone(app: &mut App, cloth: Entity) -> Entity {
    let world = app.world_mut();
    let copy = world.commands().entity(cloth).clone_and_spawn().insert(Transform::from_xyz(3.0, 0.0, 0.0)).id();
    world.flush();
    copy
}

#[test]
fn a_clone_starts_at_rest_in_its_own_place_and_falls_as_its_original_did() {
    for pins in [ClothPins::none(), top_edge(), ClothPins::indices([0])] {
        let mut app = app();
        let original = spawn(&mut app, sheet(), pins.clone());
        let expected: Vec<f32> = (0..30)
            .map(|_| {
                app.update();
                height(&app, original)
            })
            .collect();
        for frames in [0, 60] {
            let mut app = self::app();
            let cloth = spawn(&mut app, sheet(), pins.clone());
            let source = state(&app, cloth).source_mesh().clone();
            run(&mut app, frames);
            let copy = clone(&mut app, cloth);
            app.update();
            assert_eq!(state(&app, copy).source_mesh(), &source);
            assert_ne!(state(&app, copy).own_mesh(), state(&app, cloth).own_mesh());
            assert_eq!(local(&app, copy), vectors(&sheet(), Mesh::ATTRIBUTE_POSITION));
            assert_near(world(&app, copy)[0], Vec3::X * 3.0, 1e-6);
            assert_eq!(state(&app, copy).cloth().energy().kinetic, 0.0);
            for expected in &expected {
                app.update();
                assert!((height(&app, copy) - expected).abs() < 1e-4, "{} is not {expected}", height(&app, copy));
            }
            assert!(error(&app, copy).is_none());
        }
    }
}

#[test]
fn a_clone_of_a_cloth_that_has_not_started_starts_too() {
    let mut app = app();
    let mesh3d = Mesh3d(add_mesh(&mut app, sheet()));
    let cloth = app.world_mut().spawn((mesh3d, ClothMesh::default())).id();
    let copy = clone(&mut app, cloth);
    run(&mut app, 20);
    assert_eq!(height(&app, copy), height(&app, cloth));
    assert!(height(&app, copy) < -0.6);
}

#[test]
fn a_second_cloth_may_show_what_a_running_one_shows_also_after_that_is_gone() {
    let mut app = app();
    let before = meshes(&app);
    let first = spawn(&mut app, sheet(), ClothPins::indices([0]));
    run(&mut app, 30);
    let shown = app.world().get::<Mesh3d>(first).unwrap().clone();
    app.world_mut().entity_mut(first).despawn();
    let second = app.world_mut().spawn((shown, ClothMesh::default(), ClothPins::indices([0]))).id();
    app.update();
    assert_eq!(local(&app, second), vectors(&sheet(), Mesh::ATTRIBUTE_POSITION));
    run(&mut app, 30);
    assert!(world(&app, second)[4].y < -0.5);
    assert_eq!(meshes(&app), before + 2, "a source and an own mesh");
    app.world_mut().entity_mut(second).despawn();
    run(&mut app, 5);
    assert_eq!(meshes(&app), before, "nothing is kept alive");
}

#[test]
fn a_draped_mesh_whose_cloth_was_removed_is_a_mesh_like_any_other() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    run(&mut app, 30);
    let draped = local(&app, cloth);
    app.world_mut().entity_mut(cloth).remove::<ClothMesh>();
    app.update();
    app.world_mut().entity_mut(cloth).insert(ClothMesh::default());
    app.update();
    assert_eq!(local(&app, cloth), draped);
    assert_ne!(draped, vectors(&sheet(), Mesh::ATTRIBUTE_POSITION));
}

/// Colors every vertex of the source of a cloth, a little otherwise in each frame.
fn color(app: &mut App, cloth: Entity, red: f32) {
    let source = state(app, cloth).source_mesh().clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let mut mesh = meshes.get_mut(&source).unwrap();
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[red, 0.0, 0.0, 1.0]; COUNT as usize]);
}

fn first_color(mesh: &Mesh) -> Option<[f32; 4]> {
    match mesh.attribute(Mesh::ATTRIBUTE_COLOR) {
        Some(VertexAttributeValues::Float32x4(colors)) => Some(colors[0]),
        _ => None,
    }
}

#[test]
fn colors_written_to_the_source_show_and_do_not_disturb() {
    let mut app = app();
    let [colored, plain] = [0, 1].map(|_| spawn(&mut app, sheet(), ClothPins::indices([0])));
    for frame in 0..60 {
        color(&mut app, colored, frame as f32 / 60.0);
        app.update();
    }
    run(&mut app, 1);
    let behind = |app: &App, cloth| state(app, cloth).cloth().positions().to_vec();
    assert!(world(&app, colored)[4].y < -0.5);
    // Both were spawned a frame apart.
    run(&mut app, 1);
    assert!(behind(&app, colored)[24].distance(behind(&app, plain)[24]) < 0.1);
    assert_eq!(first_color(mesh(&app, colored)), Some([59.0 / 60.0, 0.0, 0.0, 1.0]));

    let source = state(&app, colored).source_mesh().clone();
    app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&source).unwrap().remove_attribute(Mesh::ATTRIBUTE_COLOR);
    run(&mut app, 2);
    assert_eq!(first_color(mesh(&app, colored)), None);
}

#[test]
fn what_is_painted_on_the_own_mesh_stays() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    let own = state(&app, cloth).own_mesh().clone();
    let painted = vec![[0.0, 1.0, 0.0, 1.0]; COUNT as usize];
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.get_mut(&own).unwrap().insert_attribute(Mesh::ATTRIBUTE_COLOR, painted);
    run(&mut app, 5);
    assert_eq!(first_color(mesh(&app, cloth)), Some([0.0, 1.0, 0.0, 1.0]));
}

#[test]
fn pins_by_color_follow_the_colors() {
    let mut app = app();
    let red = sheet().with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, vec![[1.0, 0.0, 0.0, 1.0]; COUNT as usize]);
    let cloth = spawn(&mut app, red, ClothPins::where_color(PinChannel::Red, 0.5));
    run(&mut app, 5);
    assert_eq!(state(&app, cloth).pinned_vertices().len(), COUNT as usize);
    color(&mut app, cloth, 0.0);
    run(&mut app, 20);
    assert!(state(&app, cloth).pinned_vertices().is_empty());
    assert!(height(&app, cloth) < -0.6);
}

#[test]
fn authored_normals_written_to_the_source_are_taken_over() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 20);
    let before = state(&app, cloth).cloth().positions()[24];
    let source = state(&app, cloth).source_mesh().clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let down = vec![[0.0, 0.0, -1.0]; COUNT as usize];
    meshes.get_mut(&source).unwrap().insert_attribute(Mesh::ATTRIBUTE_NORMAL, down);
    run(&mut app, 2);
    assert!(vectors(mesh(&app, cloth), Mesh::ATTRIBUTE_NORMAL).iter().all(|n| n.z < -0.5));
    assert!(state(&app, cloth).cloth().positions()[24].distance(before) < 0.02);
}
