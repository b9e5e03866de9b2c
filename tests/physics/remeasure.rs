//! A cloth whose mesh is stretched, squashed or mirrored under it.

use crate::meshes::{TestMesh, random_vector, rng};
use bevy::math::{DAffine3, DMat3, DVec3};
use bevy_cloth::physics::{
    BendingModel, Cloth, Fabric, Integrator, MeshError, RestShape, RestShapeOptions, SolverSettings, SurfaceMesh,
};

/// A sheet with waves in it, so that its rest angles are not zero.
fn wavy() -> TestMesh {
    let mut mesh = TestMesh::jittered(8, 11, 0.7, 1.0, 0.3);
    for p in &mut mesh.positions {
        p.z = 0.05 * (9.0 * p.x).sin() * (7.0 * p.y).cos();
    }
    mesh
}

fn mapped(mesh: &TestMesh, linear: DMat3) -> TestMesh {
    let positions = mesh.positions.iter().map(|&p| linear * p).collect();
    TestMesh { positions, triangles: mesh.triangles.clone(), uvs: mesh.uvs.clone() }
}

fn surface(mesh: &TestMesh) -> SurfaceMesh<'_> {
    SurfaceMesh { positions: &mesh.positions, triangles: &mesh.triangles, uvs: Some(&mesh.uvs) }
}

const SCALES: [DVec3; 5] = [
    DVec3::splat(1.1),
    DVec3::new(1.1, 0.9, 1.05),
    DVec3::new(-1.0, 1.0, 1.0),
    DVec3::new(2.0, -0.5, 3.0),
    DVec3::splat(-0.01),
];

fn all_options() -> Vec<RestShapeOptions> {
    let bendings = [BendingModel::MidEdge, BendingModel::Hinge, BendingModel::None];
    let mut options: Vec<_> =
        bendings.map(|bending| RestShapeOptions { bending, warp_angle: 0.4, ..Default::default() }).into();
    options.push(RestShapeOptions { rest_flat: true, warp_from_uvs: false, ..Default::default() });
    options.push(RestShapeOptions { weld_distance: Some(1e-9), ..Default::default() });
    options
}

#[test]
fn a_shape_measured_again_is_the_shape_built_anew() {
    let mesh = wavy();
    for options in all_options() {
        for scale in SCALES {
            let other = mapped(&mesh, DMat3::from_diagonal(scale));
            let mut shape = mesh.shape_with(&options);
            shape.remeasure(&surface(&other), &options).unwrap();
            // Bit for bit: both measure by the same lines.
            assert_eq!(format!("{shape:?}"), format!("{:?}", other.shape_with(&options)));
        }
    }
}

#[test]
fn another_mesh_is_refused_and_changes_nothing() {
    let mesh = wavy();
    let options = RestShapeOptions::default();
    let shape = mesh.shape();
    let refused = |other: &SurfaceMesh, options: &RestShapeOptions| {
        let mut measured = shape.clone();
        let error = measured.remeasure(other, options).unwrap_err();
        assert_eq!(format!("{measured:?}"), format!("{shape:?}"));
        error
    };
    let larger = TestMesh::sheet(9, 11, 1.0, 1.0);
    assert_eq!(refused(&surface(&larger), &options), MeshError::OtherMesh);
    let mut flipped = wavy();
    flipped.triangles[3].swap(0, 1);
    assert_eq!(refused(&surface(&flipped), &options), MeshError::OtherMesh);
    let flat = mapped(&mesh, DMat3::from_diagonal(DVec3::new(1.0, 1e-12, 1e-12)));
    assert_eq!(refused(&surface(&flat), &options), MeshError::OtherMesh);
    let hinges = RestShapeOptions { bending: BendingModel::Hinge, ..Default::default() };
    assert_eq!(refused(&surface(&mesh), &hinges), MeshError::OtherMesh);
    // A distance of its own joins what has come near.
    let small = mapped(&mesh, DMat3::from_diagonal(DVec3::splat(0.01)));
    let near = RestShapeOptions { weld_distance: Some(0.005), ..Default::default() };
    assert_eq!(refused(&surface(&small), &near), MeshError::OtherMesh);
    let mut nan = wavy();
    nan.positions[5].x = f64::NAN;
    assert_eq!(refused(&surface(&nan), &options), MeshError::NotFinite { vertex: 5 });
}

fn settings(integrator: Integrator) -> SolverSettings {
    SolverSettings { integrator, ..SolverSettings::reference() }
}

fn hanging(shape: RestShape, settings: SolverSettings) -> Cloth {
    let mut cloth = Cloth::new(shape, Fabric::denim(), settings).unwrap();
    for vertex in [0, 7] {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    cloth
}

fn largest_difference(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn a_cloth_measured_again_steps_as_one_built_anew() {
    let mesh = wavy();
    for options in all_options() {
        for scale in SCALES {
            let linear = DMat3::from_diagonal(scale);
            let other = mapped(&mesh, linear);
            let mut measured = hanging(mesh.shape_with(&options), settings(Integrator::BackwardEuler));
            let mut rng = rng(3);
            let positions: Vec<_> = mesh.positions.iter().map(|&p| p + 0.01 * random_vector(&mut rng)).collect();
            measured.set_state(&positions, &vec![DVec3::X; positions.len()]);
            measured.remeasure(&surface(&other), &options, DAffine3::from_mat3(linear)).unwrap();

            let mut anew = hanging(other.shape_with(&options), settings(Integrator::BackwardEuler));
            let places: Vec<_> = positions.iter().map(|&p| linear * p).collect();
            let size = scale.abs().max_element();
            assert!(largest_difference(measured.positions(), &places) <= 1e-15 * size);
            assert_eq!(measured.masses(), anew.masses());
            anew.set_state(&places, measured.velocities());
            // So that both have found their turns from nothing.
            measured.set_state(&places, anew.velocities());
            let [a, b] = [measured.energy(), anew.energy()];
            assert!(
                (a.membrane - b.membrane).abs() <= 1e-9 * b.membrane
                    && (a.bending - b.bending).abs() <= 1e-9 * b.bending
            );
            for _ in 0..3 {
                measured.step(1.0 / 60.0);
                anew.step(1.0 / 60.0);
            }
            let off = largest_difference(measured.positions(), anew.positions());
            assert!(off <= 1e-8 * size, "{options:?}, {scale}: {off:e}");
        }
    }
}

#[test]
fn a_mirror_changes_nothing_but_the_side() {
    let mesh = wavy();
    let options = RestShapeOptions::default();
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let mut plain = hanging(mesh.shape(), settings(Integrator::Bdf2));
    let mut mirrored = hanging(mesh.shape(), settings(Integrator::Bdf2));
    // By one corner, so that it swings.
    plain.unpin(7);
    mirrored.unpin(7);
    for step in 0..30 {
        // As often as a figure faces about.
        if step % 7 == 3 {
            let before = mirrored.energy();
            let other = if step / 7 % 2 == 0 { mapped(&mesh, mirror) } else { wavy() };
            mirrored.remeasure(&surface(&other), &options, DAffine3::from_mat3(mirror)).unwrap();
            let after = mirrored.energy();
            // The turns of the normals are turned round too.
            assert!((after.bending - before.bending).abs() <= 1e-9 * before.bending, "{before:?}, {after:?}");
        }
        plain.step(1.0 / 60.0);
        mirrored.step(1.0 / 60.0);
        let flips = (step + 4) / 7;
        let expected: Vec<_> = plain.positions().iter().map(|&p| if flips % 2 == 1 { mirror * p } else { p }).collect();
        let off = largest_difference(mirrored.positions(), &expected);
        assert!(off < 1e-9, "{off:e} after step {step}");
    }
    assert!(plain.velocities().iter().any(|v| v.length() > 0.5), "it swings");
}

#[test]
fn what_moves_on_moves_on_as_fast_while_it_grows() {
    let mesh = wavy();
    let options = RestShapeOptions::default();
    let velocity = DVec3::new(6.0, 0.0, 1.0);
    for held in [true, false] {
        let mut cloth = hanging(mesh.shape(), settings(Integrator::Bdf2));
        cloth.set_gravity(DVec3::ZERO);
        cloth.set_state(&mesh.positions, &vec![velocity; mesh.positions.len()]);
        cloth.set_fabric(Fabric { air_drag: 0.0, ..Fabric::denim() }).unwrap();
        if !held {
            cloth.clear_pins();
        }
        let (mut size, mut start) = (1.0, DVec3::ZERO);
        for step in 1..40 {
            let factor = if step % 10 == 0 { -1.0 } else { 1.0 + 0.01 * f64::from(step % 3 - 1) };
            size *= factor;
            let scale = DVec3::new(factor, factor.abs(), factor.abs());
            let other = mapped(&mesh, DMat3::from_diagonal(DVec3::new(size, size.abs(), size.abs())));
            // About the first vertex, wherever it has come to.
            let origin = cloth.positions()[0];
            let map =
                DAffine3::from_translation(origin) * DAffine3::from_scale(scale) * DAffine3::from_translation(-origin);
            cloth.remeasure(&surface(&other), &options, map).unwrap();
            start += velocity / 60.0;
            if held {
                for vertex in [0, 7] {
                    cloth
                        .pin(vertex, other.positions[vertex as usize] - other.positions[0] + mesh.positions[0] + start);
                }
            }
            cloth.step(1.0 / 60.0);
            let off = cloth.velocities().iter().map(|v| v.distance(velocity)).fold(0.0, f64::max);
            assert!(off < 1e-6, "held: {held}, off by {off:e} m/s after step {step}");
        }
    }
}
