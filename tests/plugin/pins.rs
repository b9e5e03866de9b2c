//! Which vertices are held, and moving them.

use crate::common::*;
use bevy::mesh::{MeshVertexAttribute, VertexFormat};
use bevy::prelude::*;
use bevy_cloth::plugin::*;

const WEIGHT: MeshVertexAttribute = MeshVertexAttribute::new("Weight", 8_765_432, VertexFormat::Float32);

/// The sheet with authored pins at 1 and 3, a weight of 0.1 per index, and the green of each vertex 1 at 5 and 6.
fn painted() -> Mesh {
    let green = |i| if i == 5 || i == 6 { 1.0 } else { 0.0 };
    sheet()
        .with_inserted_attribute(
            ATTRIBUTE_CLOTH_PIN,
            (0..COUNT).map(|i| f32::from(i == 1 || i == 3)).collect::<Vec<f32>>(),
        )
        .with_inserted_attribute(WEIGHT, (0..COUNT).map(|i| 0.1 * i as f32).collect::<Vec<f32>>())
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_COLOR,
            (0..COUNT).map(|i| [0.0, green(i), 0.0, 1.0]).collect::<Vec<_>>(),
        )
}

#[test]
fn each_rule_holds_its_vertices() {
    let cases = [
        (ClothPins::default(), vec![1, 3]),
        (ClothPins::none(), vec![]),
        (ClothPins::indices([7, 2]), vec![2, 7]),
        (ClothPins::where_position(|p| p.y > -0.01 && p.x > 0.6), vec![3, 4]),
        (
            ClothPins::where_vertex(|v| v.index == 9 && v.normal == Vec3::Z && v.uv == Some(Vec2::new(1.0, 0.25))),
            vec![9],
        ),
        (ClothPins::where_vertex(|v| v.color.is_some_and(|c| c.y > 0.5)), vec![5, 6]),
        (ClothPins::where_attribute(WEIGHT, 2.25), vec![23, 24]),
        (ClothPins::where_color(PinChannel::Green, 0.5), vec![5, 6]),
        (ClothPins::in_box(Vec3::new(0.2, -0.3, -1.0), Vec3::new(0.5, -0.2, 1.0)), vec![6, 7]),
        (ClothPins::indices([0]).or(ClothPins::where_position(|p| p.x == 1.0 && p.y == -1.0)), vec![0, 24]),
    ];
    for (pins, expected) in cases {
        let mut app = app();
        let cloth = spawn(&mut app, painted(), pins.clone());
        run(&mut app, 20);
        assert_eq!(state(&app, cloth).pinned_vertices(), expected, "{pins:?}");
        let rest = vectors(&sheet(), Mesh::ATTRIBUTE_POSITION);
        for (vertex, (now, rest)) in world(&app, cloth).iter().zip(rest).enumerate() {
            let held = expected.contains(&(vertex as u32));
            assert_eq!(now.distance(rest) < 1e-6, held, "{pins:?}: vertex {vertex} is at {now}, from {rest}");
        }
    }
}

#[test]
fn the_default_holds_nothing_on_a_mesh_without_the_attribute() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ());
    assert!(state(&app, cloth).pinned_vertices().is_empty());
    assert!(error(&app, cloth).is_none());
}

#[test]
fn rules_may_change_while_it_runs() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0, 4]));
    run(&mut app, 60);
    app.world_mut().entity_mut(cloth).insert(ClothPins::indices([4]));
    run(&mut app, 60);
    let world_now = world(&app, cloth);
    assert_near(world_now[4], Vec3::X, 1e-6);
    assert!(world_now[0].y < -0.5, "let go, it swings down: {}", world_now[0]);
    app.world_mut().entity_mut(cloth).remove::<ClothPins>();
    run(&mut app, 60);
    assert!(world(&app, cloth)[4].y < -1.0);
}

#[test]
fn targets_take_vertices_anywhere_and_let_go() {
    let mut app = app();
    let at = Transform::from_xyz(0.0, 10.0, 0.0).with_scale(Vec3::splat(2.0));
    let cloth = spawn(&mut app, sheet(), (at, top_edge()));
    // What is held 20 cm away glides there.
    let grabbed = [(0, Vec3::new(0.0, 0.0, 0.1)), (24, Vec3::new(1.0, -1.0, 0.0))];
    app.world_mut().entity_mut(cloth).insert(ClothPinTargets(grabbed.into()));
    run(&mut app, 30);
    for step in 0..20 {
        let lifted = 0.01 * step as f32;
        // One vertex that the rules hold too, one that they do not.
        let grabbed = [(0, Vec3::new(0.0, lifted, 0.1)), (24, Vec3::new(1.0, -1.0 + lifted, 0.0))];
        app.world_mut().entity_mut(cloth).insert(ClothPinTargets(grabbed.into()));
        app.update();
        for (vertex, place) in grabbed {
            assert_near(local(&app, cloth)[vertex as usize], place, 1e-6);
            let simulated = state(&app, cloth).simulated_vertex(vertex).unwrap();
            let position = state(&app, cloth).cloth().positions()[simulated as usize];
            assert_near(position.as_vec3(), at.transform_point(place), 1e-5);
        }
    }
    app.world_mut().get_mut::<ClothPinTargets>(cloth).unwrap().clear();
    run(&mut app, 300);
    assert_near(local(&app, cloth)[0], Vec3::ZERO, 1e-6);
    assert!(local(&app, cloth)[24].y < -0.85);
}

#[test]
fn pins_of_welded_vertices_hold_the_one_they_are() {
    // Two triangles that meet at a seam of split vertices; the pin names the second of each pair.
    let split = Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default()).with_inserted_attribute(
        Mesh::ATTRIBUTE_POSITION,
        vec![[0.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, -1.0, 0.0]],
    );
    let mut app = app();
    let cloth = spawn(&mut app, split, ClothPins::indices([3]));
    assert_eq!(state(&app, cloth).cloth().shape().vertex_count(), 4);
    run(&mut app, 30);
    let now = world(&app, cloth);
    assert_near(now[3], Vec3::X, 1e-6);
    assert_eq!(now[2], now[3]);
    assert_eq!(now[1], now[4]);
    assert!(now[0].y < -0.1);
}
