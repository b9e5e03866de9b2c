//! From meshes, good and bad, to rest shapes.

use bevy::math::DVec3;
use bevy_cloth::physics::{MeshError, RestShape, RestShapeOptions, SurfaceMesh};

use crate::meshes::TestMesh;

fn build(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<RestShape, MeshError> {
    let positions: Vec<_> = positions.iter().copied().map(DVec3::from).collect();
    let mesh = SurfaceMesh { positions: &positions, triangles, uvs: None };
    RestShape::new(&mesh, &RestShapeOptions::default())
}

#[test]
fn a_grid_has_the_elements_it_should() {
    let shape = TestMesh::sheet(4, 3, 3.0, 2.0).shape();
    assert_eq!((shape.vertex_count(), shape.triangles.len()), (12, 12));
    // Euler: V − E + F = 1 for a disc.
    assert_eq!(shape.edges.len(), 12 + 12 - 1);
    assert_eq!(shape.boundary.len(), 10);
    assert_eq!(shape.hinges.len(), shape.edges.len() - 10);
    assert!((shape.vertex_areas.iter().sum::<f64>() - 6.0).abs() < 1e-12);
    assert!(shape.dropped.is_empty() && shape.non_manifold.is_empty());
    for triangle in &shape.triangles {
        assert!((triangle.area - 0.5).abs() < 1e-12);
    }
    for hinge in &shape.hinges {
        assert!(hinge.rest_angle.abs() < 1e-12);
    }
}

#[test]
fn vertices_split_along_a_seam_are_one() {
    // Two triangles that share an edge in space but no vertex index.
    let shape = build(
        &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
        &[[0, 1, 2], [3, 4, 5]],
    )
    .unwrap();
    assert_eq!(shape.vertex_count(), 4);
    assert_eq!(shape.simulated, [0, 1, 2, 1, 3, 2].map(Some));
    assert_eq!(shape.hinges.len(), 1);
}

#[test]
fn unused_vertices_are_not_simulated() {
    let shape = build(&[[9., 9., 9.], [0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], &[[1, 2, 3]]).unwrap();
    assert_eq!(shape.simulated, [None, Some(0), Some(1), Some(2)]);
    assert!(shape.vertex_areas.iter().all(|&area| area > 0.0));
}

#[test]
fn degenerate_and_duplicate_triangles_are_left_out_and_listed() {
    let shape = build(
        &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0.5, 0., 0.]],
        &[[0, 1, 2], [0, 3, 1], [2, 1, 0], [1, 1, 2], [1, 2, 0]],
    )
    .unwrap();
    assert_eq!(shape.triangles.len(), 1);
    assert_eq!(shape.triangles[0].source, 0);
    assert_eq!(shape.dropped, [1, 2, 3, 4]);
    // Vertex 3 had only the degenerate one.
    assert_eq!(shape.simulated[3], None);
}

#[test]
fn an_edge_of_three_triangles_bends_between_each_pair() {
    let shape = build(
        &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.]],
        &[[0, 1, 2], [1, 0, 3], [0, 1, 4]],
    )
    .unwrap();
    assert_eq!(shape.non_manifold, [[0, 1]]);
    assert_eq!(shape.hinges.len(), 3);
    let mut angles: Vec<_> = shape.hinges.iter().map(|h| h.rest_angle.abs().to_degrees().round()).collect();
    angles.sort_by(f64::total_cmp);
    assert_eq!(angles, [0.0, 90.0, 90.0]);
}

#[test]
fn meshes_that_are_no_cloth_are_refused_by_element() {
    let square = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    assert_eq!(build(&square, &[]).unwrap_err(), MeshError::Empty { given: 0 });
    assert_eq!(build(&square, &[[0, 0, 1]]).unwrap_err(), MeshError::Empty { given: 1 });
    let out_of_range = MeshError::IndexOutOfRange { triangle: 1, vertex: 3, count: 3 };
    assert_eq!(build(&square, &[[0, 1, 2], [0, 3, 1]]).unwrap_err(), out_of_range);
    let nan = [[0., 0., 0.], [1., 0., 0.], [0., f64::NAN, 0.]];
    assert_eq!(build(&nan, &[[0, 1, 2]]).unwrap_err(), MeshError::NotFinite { vertex: 2 });
    let positions = square.map(DVec3::from);
    let mesh = SurfaceMesh { positions: &positions, triangles: &[[0, 1, 2]], uvs: Some(&[[0.0; 2]; 2]) };
    let error = RestShape::new(&mesh, &RestShapeOptions::default()).unwrap_err();
    assert_eq!(error, MeshError::UvCount { uvs: 2, positions: 3 });
}

#[test]
fn a_sliver_of_aspect_ten_thousand_is_an_element() {
    let shape = build(&[[0., 0., 0.], [1., 0., 0.], [0.3, 1e-4, 0.]], &[[0, 1, 2]]).unwrap();
    assert_eq!(shape.triangles.len(), 1);
    assert!(shape.dropped.is_empty());
}

#[test]
fn a_modelled_fold_is_the_rest_shape_unless_asked_otherwise() {
    let mut mesh = TestMesh::sheet(3, 2, 2.0, 1.0);
    for vertex in [2, 5] {
        mesh.positions[vertex] = DVec3::new(1.0, mesh.positions[vertex].y, 1.0);
    }
    let fold = |options: &RestShapeOptions| {
        let shape = mesh.shape_with(options);
        shape.hinges.iter().map(|h| h.rest_angle.abs()).fold(0.0, f64::max).to_degrees()
    };
    assert!((fold(&RestShapeOptions::default()) - 90.0).abs() < 1e-9);
    assert_eq!(fold(&RestShapeOptions { rest_flat: true, ..Default::default() }), 0.0);
}

#[test]
fn a_triangle_too_large_for_numbers_is_left_out() {
    let huge = 1e100;
    let shape =
        build(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [huge, 0., 0.], [0., huge, 0.]], &[[0, 3, 4], [0, 1, 2]]);
    // A huge mesh has a huge weld distance too: here all that is small becomes one.
    assert_eq!(shape.unwrap_err(), MeshError::Empty { given: 2 });
}

/// rlguy/Blender-FLIP-Fluids #91: a vertex left behind.
#[test]
fn a_loose_vertex_far_away_welds_nothing() {
    let mut mesh = TestMesh::sheet(20, 20, 1.0, 1.0);
    let whole = mesh.shape();
    for far in [1e3, 1e6, 1e18] {
        mesh.positions.push(DVec3::splat(far));
        mesh.uvs.push([0.0; 2]);
        let shape = mesh.shape();
        assert_eq!(shape.vertex_count(), whole.vertex_count(), "at {far:e} m");
        assert!(shape.dropped.is_empty() && shape.simulated.last() == Some(&None));
    }
}
