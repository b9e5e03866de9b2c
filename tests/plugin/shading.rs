//! What the renderer gets beside positions: normals, tangents, bounds.

use crate::common::*;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::mesh::VertexAttributeValues;
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
