//! Extremes that once went wrong, found by `lab stability`.

use bevy::math::DVec3;
use bevy_cloth::physics::{
    Cloth, Fabric, Integrator, Precision, RestShape, RestShapeOptions, SolverKind, SolverSettings, StepOutcome,
    SurfaceMesh,
};

use crate::meshes::{TestMesh, crumpled};

const BACKWARD_EULER: SolverSettings = SolverSettings {
    integrator: Integrator::BackwardEuler,
    kind: SolverKind::conjugate_gradient(0.005),
    precision: Precision::Single,
    substeps: 1,
    newton_steps: 1,
};

/// A sheet of 8 × 8 vertices and 1 m × 1 m, in the plane z = 0 below its top edge.
fn cloth(fabric: Fabric, settings: SolverSettings) -> Cloth {
    Cloth::new(TestMesh::jittered(8, 8, 1.0, 1.0, 0.3).shape(), fabric.undamped(), settings).unwrap()
}

fn pin_corners(cloth: &mut Cloth) {
    for vertex in [0, 7] {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
}

/// Puts the cloth elsewhere, at rest.
fn place(cloth: &mut Cloth, to: impl Fn(DVec3) -> DVec3) {
    let positions: Vec<_> = cloth.positions().iter().map(|&x| to(x)).collect();
    cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
}

fn mean(cloth: &Cloth) -> DVec3 {
    let sum: DVec3 = cloth.positions().iter().zip(cloth.masses()).map(|(&x, &mass)| mass * x).sum();
    sum / cloth.masses().iter().sum::<f64>()
}

/// A horizontal sheet, hung by two corners.
fn swinging(stiffness: f32, settings: SolverSettings) -> Cloth {
    let mut cloth = cloth(Fabric::isotropic(0.15, stiffness, 0.3, 1e-5), settings);
    place(&mut cloth, |x| DVec3::new(x.x, 0.0, x.y));
    pin_corners(&mut cloth);
    cloth
}

#[test]
fn a_stiff_sheet_does_not_swing_higher_than_it_began() {
    // Each step gained less than it may, and all of them lifted the sheet by a third of its size above its start.
    let mut cloth = swinging(1e5, SolverSettings::default());
    let start = cloth.energy().total();
    let dt = 1.0 / 32.0;
    // What gravity gives in a step from rest, and in all.
    let (first, mut most) = (0.15 * (9.81 * dt) * (9.81 * dt), 0.0_f64);
    for step in 0..100 {
        cloth.step(dt);
        let energy = cloth.energy();
        most = most.max(start - energy.gravity);
        let gained = energy.total() - start;
        assert!(gained < 0.055 * (first + most), "step {step}: {gained} J of {most} J");
    }
    assert!(most > 0.5, "it does swing");
}

#[test]
fn a_stiff_sheet_is_not_stuck_in_steps_of_a_second() {
    // Flat, it bends within a millionth of the fall: no step was found short enough.
    for stiffness in [1e7, 1e9] {
        let mut cloth = swinging(stiffness, BACKWARD_EULER);
        for _ in 0..16 {
            assert_eq!(cloth.step(1.0).outcome, StepOutcome::Accepted);
        }
        assert!(mean(&cloth).y < -0.01, "{stiffness} N/m: {}", mean(&cloth));
    }
}

#[test]
fn whatever_becomes_of_a_free_cloth_it_falls() {
    let fabric = Fabric::isotropic(1e-4, 1e7, 0.3, 1e-6);
    for start in ["stretched", "crumpled", "a line", "a point"] {
        let mut cloth = cloth(fabric, BACKWARD_EULER);
        let positions = cloth.positions().to_vec();
        let noisy = crumpled(&positions, 1.0, 1);
        let place = |(&x, noisy): (&DVec3, DVec3)| match start {
            "stretched" => 5.0 * x,
            "crumpled" => noisy,
            "a line" => DVec3::X * x.x + 1e-6 * (noisy - x),
            _ => 1e-6 * (noisy - x),
        };
        let positions: Vec<_> = positions.iter().zip(noisy).map(place).collect();
        cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
        let (before, dt) = (mean(&cloth).y, 0.3);
        for _ in 0..10 {
            assert_eq!(cloth.step(dt).outcome, StepOutcome::Accepted, "{start}");
        }
        // Backward Euler falls g Δt² (1 + 2 + … + 10); where velocities were scaled down, less.
        let share = (before - mean(&cloth).y) / (9.81 * dt * dt * 55.0);
        assert!((0.5..1.001).contains(&share), "{start}: {share} of free fall");
    }
}

#[test]
fn a_system_too_ill_conditioned_for_its_precision_is_no_end() {
    // Slivers of a light, stiff-bending fabric: conjugate gradients in f32 meet negative curvature.
    let mut mesh = TestMesh::sheet(9, 9, 1.0, 1.0);
    for x in &mut mesh.positions {
        x.y += if x.y < -0.55 { 0.12 } else { 0.0 };
    }
    let fabric = Fabric::isotropic(4e-4, 0.02, 0.3, 0.2).undamped();
    let mut cloth = Cloth::new(mesh.shape(), fabric, SolverSettings::default()).unwrap();
    place(&mut cloth, |x| DVec3::new(x.x, 0.0, x.y));
    for step in 0..60 {
        assert_eq!(cloth.step(0.01).outcome, StepOutcome::Accepted, "step {step}");
    }
    let fallen = -mean(&cloth).y / (0.5 * 9.81 * 0.6 * 0.6);
    assert!((0.9..1.05).contains(&fallen), "{fallen} of free fall");
}

/// A vertex that is coupled with more than 2¹⁶ others.
#[test]
fn a_fan_of_more_triangles_than_16_bits_count_steps() {
    let count = 65_600_u32;
    let on_rim = |i: u32| {
        let angle = f64::from(i) / f64::from(count) * core::f64::consts::TAU;
        DVec3::new(angle.cos(), 0.0, angle.sin())
    };
    let positions: Vec<_> = [DVec3::ZERO].into_iter().chain((0..count).map(on_rim)).collect();
    let triangles: Vec<_> = (0..count).map(|i| [0, 1 + (i + 1) % count, 1 + i]).collect();
    let mesh = SurfaceMesh { positions: &positions, triangles: &triangles, uvs: None };
    // Some of the rim is nearer than the tolerance for welding.
    let options = RestShapeOptions { weld_distance: Some(0.0), ..Default::default() };
    let shape = RestShape::new(&mesh, &options).unwrap();
    assert_eq!(shape.triangles.len(), count as usize);
    let mut cloth = Cloth::new(shape, Fabric::cotton(), SolverSettings::default()).unwrap();
    cloth.pin(0, DVec3::ZERO);
    let report = cloth.step(1.0 / 60.0);
    assert_eq!(report.outcome, StepOutcome::Accepted);
    assert!(cloth.positions().iter().all(|x| x.is_finite()));
}
