//! Cloths with a known answer.

use bevy::math::DVec3;
use bevy_cloth::physics::assembly::{ImplicitStep, Ordering, System};
use bevy_cloth::physics::{Cloth, Fabric, Integrator, Precision, SolverKind, SolverSettings};

use crate::meshes::TestMesh;

/// Uniaxial stretch λ along X with free sides: force per width λ k (λ²−1)/2, k = k0 − k1²/k2; and no force elsewhere.
#[test]
fn uniaxial_patch() {
    let fabric = Fabric { weft_stiffness: 300.0, coupling: 150.0, ..Fabric::isotropic(0.15, 1000.0, 0.0, 1e-3) };
    let (k0, k1, k2) = (1000.0, 150.0, 300.0);
    let k = k0 - k1 * k1 / k2;
    let (length, width) = (2.0, 1.0);
    for mesh in [TestMesh::sheet(9, 6, length, width), TestMesh::jittered(9, 6, length, width, 0.35)] {
        let shape = mesh.shape();
        let mut system = System::<f64>::new(&shape, &fabric, &Ordering::identity(shape.vertex_count()));
        for lambda in [0.6_f64, 0.9, 1.01, 1.3, 2.0] {
            let strain = 0.5 * (lambda * lambda - 1.0);
            let lateral = (1.0 - 2.0 * k1 / k2 * strain).sqrt();
            if lateral.is_nan() {
                continue;
            }
            let x: Vec<_> = shape.positions.iter().map(|p| DVec3::new(lambda * p.x, lateral * p.y, 0.0)).collect();
            system.assemble(&ImplicitStep::backward_euler(&x, &x, 1.0, DVec3::ZERO), &vec![0.0; x.len()]);
            let expected = lambda * k * strain * width;
            let mut end = 0.0;
            for (p, f) in shape.positions.iter().zip(&system.rhs) {
                let f = DVec3::from(f.to_f64());
                if p.x == length {
                    end -= f.x;
                } else if p.x > 0.0 {
                    assert!(f.length() < 1e-6 * expected.abs(), "λ {lambda}: {f} inside, at {p}");
                }
            }
            assert!((end - expected).abs() < 1e-6 * expected.abs(), "λ {lambda}: {end} N, not {expected}");
        }
    }
}

/// A sheet hung by its top edge: λ(λ²−1)/2 = ρ g s/k at the distance s from the free end. The tip drops 22.06 mm for
/// k = 69 N/m and 0.7816 mm for k = 2030 N/m at ρ = 0.324 kg/m², L = 1 m.
fn hanging_strip(stiffness: f32, n: usize, dt: f64, settings: SolverSettings) -> f64 {
    let fabric = Fabric { damping: 0.0, air_drag: 40.0, ..Fabric::isotropic(0.324, stiffness, 0.0, 1e-6) };
    let mut cloth = Cloth::new(TestMesh::sheet(n, n, 1.0, 1.0).shape(), fabric, settings).unwrap();
    for vertex in 0..n {
        cloth.pin(vertex as u32, cloth.positions()[vertex]);
    }
    for _ in 0..(3.0 / dt).round() as u32 {
        cloth.step(dt);
    }
    let bottom = &cloth.positions()[n * (n - 1)..];
    -1.0 - bottom.iter().map(|x| x.y).sum::<f64>() / n as f64
}

#[test]
fn hanging_strip_over_mesh_step_and_tolerance() {
    for (stiffness, expected) in [(69.0, 22.06e-3), (2030.0, 0.7816e-3)] {
        for n in [16, 32, 48] {
            for dt in [1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0] {
                for (tolerance, precision) in [(1e-2, Precision::Single), (1e-6, Precision::Double)] {
                    // The finest steps are the dearest runs and the least demanding.
                    if n == 48 && dt < 1.0 / 60.0 && precision == Precision::Double {
                        continue;
                    }
                    let kind = SolverKind::conjugate_gradient(tolerance);
                    let drop =
                        hanging_strip(stiffness, n, dt, SolverSettings { kind, precision, ..Default::default() });
                    let error = drop / expected - 1.0;
                    assert!(
                        error.abs() < 5e-3,
                        "k {stiffness}, {n}², dt {dt:.4}, tolerance {tolerance:e}: {:.4} mm, off by {:.2} %",
                        1e3 * drop,
                        1e2 * error
                    );
                }
            }
        }
    }
}

/// Where a free cloth is after a second, less where it was: the same for every vertex.
fn fall(drag: f32, settings: SolverSettings) -> Vec<DVec3> {
    let fabric = Fabric { air_drag: drag, ..Fabric::cotton() };
    let mut cloth = Cloth::new(TestMesh::jittered(8, 8, 1.0, 1.0, 0.3).shape(), fabric, settings).unwrap();
    let start = cloth.positions().to_vec();
    cloth.set_state(&start, &vec![DVec3::new(1.0, 3.0, -2.0); start.len()]);
    for _ in 0..60 {
        cloth.step(1.0 / 60.0);
    }
    cloth.positions().iter().zip(&start).map(|(&x, &s)| x - s).collect()
}

#[test]
fn free_fall_is_exact() {
    for (settings, tolerance) in [(SolverSettings::default(), 1e-6), (SolverSettings::reference(), 1e-12)] {
        for moved in fall(0.0, settings) {
            let expected = DVec3::new(1.0, 3.0 - 0.5 * 9.81, -2.0);
            assert!(moved.distance(expected) < tolerance, "{moved}");
        }
    }
}

#[test]
fn air_drag_slows_a_fall_as_it_should() {
    // v' = g − α v.
    let (drag, v, g) = (0.5_f64, DVec3::new(1.0, 3.0, -2.0), DVec3::new(0.0, -9.81, 0.0));
    let decay = 1.0 - (-drag).exp();
    let expected = g / drag + (v - g / drag) * decay / drag;
    for moved in fall(drag as f32, SolverSettings::default()) {
        assert!(moved.distance(expected) < 5e-4, "{moved}, not {expected}");
    }
}

#[test]
fn free_fall_under_backward_euler_is_that_of_a_point_mass() {
    let settings = SolverSettings { integrator: Integrator::BackwardEuler, ..SolverSettings::reference() };
    let (dt, drag) = (1.0 / 60.0, 0.5);
    let (mut expected, mut v) = (DVec3::ZERO, DVec3::new(1.0, 3.0, -2.0));
    for _ in 0..60 {
        v = (v + dt * DVec3::new(0.0, -9.81, 0.0)) / (1.0 + dt * drag);
        expected += dt * v;
    }
    for moved in fall(drag as f32, settings) {
        assert!(moved.distance(expected) < 1e-12, "{moved}");
    }
}

/// A stiff triangle hung by two corners is a point mass on a rod: T = 2π √(ℓ/g) (1 + θ₀²/16) at a small amplitude θ₀.
#[test]
fn pendulum_period() {
    let (length, amplitude) = (0.25, 0.1_f64);
    let mesh = TestMesh {
        positions: vec![DVec3::ZERO, DVec3::new(0.3, 0.0, 0.0), DVec3::new(0.15, -length, 0.0)],
        triangles: vec![[0, 2, 1]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]],
    };
    let fabric = Fabric::isotropic(0.15, 1e4, 0.3, 0.0).undamped();
    let mut cloth = Cloth::new(mesh.shape(), fabric, SolverSettings::reference()).unwrap();
    for vertex in [0, 1] {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    let mut x = cloth.positions().to_vec();
    x[2] = DVec3::new(0.15, -length * amplitude.cos(), length * amplitude.sin());
    cloth.set_state(&x, &[DVec3::ZERO; 3]);

    let dt = 1.0 / 2000.0;
    let mut crossings = Vec::new();
    let mut before = x[2].z;
    for step in 1..=8000 {
        cloth.step(dt);
        let z = cloth.positions()[2].z;
        if before > 0.0 && z <= 0.0 {
            crossings.push((f64::from(step) - z / (z - before)) * dt);
        }
        before = z;
    }
    let periods = crossings.len() - 1;
    let period = (crossings[periods] - crossings[0]) / periods as f64;
    // The amplitude shrinks with backward Euler: its effect on the period is below 0.1 %.
    let expected = core::f64::consts::TAU * (length / 9.81).sqrt();
    assert!(periods >= 3 && (period / expected - 1.0).abs() < 2e-3, "{period} s, not {expected}");
}
