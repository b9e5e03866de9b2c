//! What the renderer gets beside positions: normals, tangents, bounds.

use crate::common::*;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use bevy_cloth::plugin::*;

fn tangents(app: &App, cloth: Entity) -> Vec<Vec4> {
    match mesh(app, cloth).attribute(Mesh::ATTRIBUTE_TANGENT) {
        Some(VertexAttributeValues::Float32x4(tangents)) => tangents.iter().map(|&t| t.into()).collect(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn normals_and_tangents_follow_a_small_cloth() {
    // Edges of 2 mm: Bevy's smooth normals would be zero here.
    let small = sheet()
        .scaled_by(Vec3::splat(0.008))
        .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[1.0, 0.0, 0.0, -1.0]; COUNT as usize]);
    // Held by targets that turn the whole sheet about x by 90°: what was up is out.
    let turned = vectors(&small, Mesh::ATTRIBUTE_POSITION).into_iter().map(|p| Vec3::new(p.x, 0.0, p.y));
    let targets = ClothPinTargets((0..).zip(turned).collect());
    let mut app = app();
    let cloth = spawn(&mut app, small, targets);
    run(&mut app, 2);
    for normal in vectors(mesh(&app, cloth), Mesh::ATTRIBUTE_NORMAL) {
        assert_near(normal, Vec3::NEG_Y, 1e-4);
    }
    for tangent in tangents(&app, cloth) {
        assert!(tangent.abs_diff_eq(Vec4::new(1.0, 0.0, 0.0, -1.0), 1e-4), "{tangent}");
    }
}

#[test]
fn a_crumpled_cloth_has_sane_normals_and_tangents() {
    let curtain = sheet().with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[1.0, 0.0, 0.0, 1.0]; COUNT as usize]);
    // Everything squeezed to a line, then to a point.
    for squeeze in [Vec3::X, Vec3::ZERO] {
        let places = vectors(&curtain, Mesh::ATTRIBUTE_POSITION).into_iter().map(|p| p * squeeze);
        let mut app = app();
        let cloth = spawn(&mut app, curtain.clone(), ClothPinTargets((0..).zip(places).collect()));
        run(&mut app, 2);
        for (normal, tangent) in vectors(mesh(&app, cloth), Mesh::ATTRIBUTE_NORMAL).iter().zip(tangents(&app, cloth)) {
            assert!((normal.length() - 1.0).abs() < 1e-4, "{normal}");
            assert!((tangent.truncate().length() - 1.0).abs() < 1e-4 && tangent.w == 1.0, "{tangent}");
            assert!(tangent.truncate().dot(*normal).abs() < 1e-4);
        }
    }
}

#[test]
fn the_bounds_are_those_of_the_deformed_mesh() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    for _ in 0..40 {
        app.update();
        let bounds = *app.world().get::<Aabb>(cloth).unwrap();
        assert_eq!(bounds, Aabb::enclosing(local(&app, cloth)).unwrap());
    }
    let bounds = app.world().get::<Aabb>(cloth).unwrap();
    assert!(bounds.min().y < -1.2, "it hangs by a corner: {bounds:?}");
    assert!(app.world().get::<NoAutoAabb>(cloth).is_some());
}

/// [`sheet`] with other triangles.
fn with_triangles(change: impl Fn(Vec<[u16; 3]>) -> Vec<[u16; 3]>) -> Mesh {
    let Some(Indices::U16(indices)) = sheet().indices().cloned() else { panic!("u16") };
    sheet().with_inserted_indices(Indices::U16(change(indices.as_chunks().0.to_vec()).into_flattened()))
}

fn flipped([a, b, c]: [u16; 3]) -> [u16; 3] {
    [b, a, c]
}

fn flip_every(n: usize) -> Mesh {
    with_triangles(|mut triangles| {
        triangles.iter_mut().step_by(n).for_each(|triangle| *triangle = flipped(*triangle));
        triangles
    })
}

/// Godot #79265 and #102973: the lighting of soft bodies did not follow.
#[test]
fn normals_follow_where_faces_are_doubled_or_wound_unevenly() {
    let meshes = [
        with_triangles(|triangles| triangles.iter().copied().chain(triangles.iter().copied().map(flipped)).collect()),
        with_triangles(|triangles| triangles.into_iter().flat_map(|triangle| [triangle, flipped(triangle)]).collect()),
        flip_every(2),
        flip_every(3),
    ];
    for (case, mesh_of_case) in meshes.into_iter().enumerate() {
        for authored in [true, false] {
            let of = |mesh: &Mesh| {
                if authored { mesh.clone() } else { mesh.clone().with_removed_attribute(Mesh::ATTRIBUTE_NORMAL) }
            };
            let mut app = app();
            let held = || {
                (
                    ClothPins::indices([0, 4]),
                    ClothMaterial::denim(),
                    Transform::from_rotation(Quat::from_rotation_x(1.0)),
                )
            };
            let meshes = [of(&sheet()), of(&mesh_of_case)].map(|mesh| Mesh3d(add_mesh(&mut app, mesh)));
            let [plain, odd] = meshes.map(|mesh3d| app.world_mut().spawn((mesh3d, ClothMesh::default(), held())).id());
            app.update();
            for _ in 0..40 {
                app.update();
                let [expected, found] = [plain, odd].map(|cloth| vectors(mesh(&app, cloth), Mesh::ATTRIBUTE_NORMAL));
                // Of as many triangles either way, without authored normals, none says which is the front.
                let side = if authored { 1.0 } else { expected[0].dot(found[0]).signum() };
                for (expected, found) in expected.iter().zip(found) {
                    let cosine = side * expected.dot(found);
                    assert!(cosine > 0.99, "case {case}, authored {authored}: {found} is not {expected}");
                }
            }
        }
    }
}
