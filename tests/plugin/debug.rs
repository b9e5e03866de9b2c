//! `ClothDebugPlugin`.
#![cfg(feature = "debug")]

use core::any::TypeId;

use crate::common::{COUNT, app_with, run, sheet, spawn, state, top_edge, vectors};
use bevy::gizmos::config::GizmoConfigStore;
use bevy::gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

fn app() -> App {
    let mut app = app_with((ClothPlugin::default().without_interpolation(), GizmoPlugin, ClothDebugPlugin));
    app.insert_resource(ClothGravity(Vec3::ZERO));
    app
}

/// Ends of the lines drawn in the last frame, and their colours.
fn drawn(app: &App) -> (Vec<Vec3>, Vec<LinearRgba>) {
    let handles = app.world().resource::<GizmoHandles>().handles();
    let Some(Some(handle)) = handles.get(&TypeId::of::<ClothGizmos>()) else { return default() };
    let asset = app.world().resource::<Assets<GizmoAsset>>().get(handle).unwrap();
    (asset.buffer().list_positions.clone(), asset.buffer().list_colors.clone())
}

fn set(app: &mut App, gizmos: ClothGizmos) {
    *app.world_mut().resource_mut::<GizmoConfigStore>().config_mut::<ClothGizmos>().1 = gizmos;
    app.update();
}

#[test]
fn each_part_is_drawn_when_it_is_asked_for() {
    let mut app = app();
    let at = Transform::from_xyz(0.0, 5.0, 0.0);
    let cloth = spawn(&mut app, sheet(), (at, top_edge()));
    run(&mut app, 2);
    let none = ClothGizmos { edges: false, pins: false, normals: false, stretch: false, ..default() };
    let edges = state(&app, cloth).cloth().shape().edges.len();

    set(&mut app, none);
    assert!(drawn(&app).0.is_empty());

    set(&mut app, ClothGizmos { edges: true, ..none });
    let (ends, colors) = drawn(&app);
    assert_eq!(ends.len(), 2 * edges);
    assert!(ends.contains(&Vec3::new(1.0, 5.0, 0.0)) && colors.iter().all(|color| *color == LinearRgba::WHITE));

    set(&mut app, ClothGizmos { pins: true, ..none });
    assert_eq!(drawn(&app).0.len(), 5 * 3 * 2, "five crosses of three lines");

    set(&mut app, ClothGizmos { normals: true, ..none });
    let (ends, _) = drawn(&app);
    assert_eq!(ends.len(), 2 * COUNT as usize);
    assert!(ends.chunks(2).all(|ends| (ends[1] - ends[0]).normalize().abs_diff_eq(Vec3::Z, 1e-4)));
}

#[test]
fn stretch_is_red_and_compression_blue() {
    let mut app = app();
    // Everything held: twice as wide, half as high.
    let places = vectors(&sheet(), Mesh::ATTRIBUTE_POSITION).into_iter().map(|p| p * Vec3::new(2.0, 0.5, 1.0));
    let held = (ClothPinTargets((0..).zip(places).collect()), ClothInertia::unlimited());
    let cloth = spawn(&mut app, sheet(), held);
    run(&mut app, 2);
    set(&mut app, ClothGizmos { pins: false, ..default() });
    let (_, colors) = drawn(&app);
    let shape = state(&app, cloth).cloth().shape();
    for (edge, colors) in shape.edges.iter().zip(colors.chunks(2)) {
        let along: DVec3 = shape.positions[edge[0] as usize] - shape.positions[edge[1] as usize];
        if along.y == 0.0 {
            assert_eq!(colors[0], LinearRgba::RED);
        } else if along.x == 0.0 {
            assert_eq!(colors[0], LinearRgba::BLUE);
        }
    }
}

#[test]
fn colliders_are_outlined_where_they_are() {
    let mut app = app();
    spawn(&mut app, sheet(), top_edge());
    let none = ClothGizmos { edges: false, pins: false, normals: false, stretch: false, ..default() };
    let at = Transform::from_xyz(0.0, 5.0, 0.0).with_scale(Vec3::splat(2.0));
    let collider = app.world_mut().spawn((ClothCollider::cuboid(1.0, 2.0, 3.0), at)).id();
    run(&mut app, 2);
    set(&mut app, none);
    let (ends, _) = drawn(&app);
    assert_eq!(ends.len(), 24, "twelve edges");
    assert!(ends.iter().all(|end| (*end - at.translation).abs().abs_diff_eq(Vec3::new(1.0, 2.0, 3.0), 1e-5)));
    let tetrahedron = ClothCollider::convex_hull(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]).unwrap();
    let plane = || ClothCollider::half_space(Dir3::Y);
    for (shape, lines) in [
        (ClothCollider::compound([(Vec3::X, Quat::IDENTITY, tetrahedron.clone())]).unwrap(), 6),
        (tetrahedron, 6),
        (ClothCollider::trimesh(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).unwrap(), 3),
    ] {
        app.world_mut().entity_mut(collider).insert(shape);
        run(&mut app, 2);
        assert_eq!(drawn(&app).0.len(), 2 * lines);
    }
    app.world_mut().entity_mut(collider).insert(plane());
    run(&mut app, 2);
    assert!(!drawn(&app).0.is_empty() && drawn(&app).0.iter().all(|end| (end.y - 5.0).abs() < 1e-4));
    set(&mut app, ClothGizmos { colliders: false, ..none });
    assert!(drawn(&app).0.is_empty());
}
