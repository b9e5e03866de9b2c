//! A and b of whole cloths.

use bevy::math::{DQuat, DVec3};
use bevy_cloth::physics::assembly::{ImplicitStep, Ordering, System};
use bevy_cloth::physics::math::{Padded, Scalar};
use bevy_cloth::physics::{BendingModel, Fabric, RestShape, RestShapeOptions};
use nalgebra::{DMatrix, DVector};

use crate::meshes::{TestMesh, crumpled, random_vector, rng};

/// Bending as stiff as stretch, so that neither hides the other.
fn fabric() -> Fabric {
    let bending = Fabric::isotropic(0.15, 100.0, 0.3, 0.5).undamped();
    Fabric { weft_bending: 0.2, bias_bending: 0.3, weft_stiffness: 60.0, ..bending }
}

fn bumpy() -> RestShape {
    bumpy_bent_by(BendingModel::MidEdge)
}

fn bumpy_bent_by(bending: BendingModel) -> RestShape {
    let mut mesh = TestMesh::jittered(5, 6, 1.0, 1.2, 0.2);
    mesh.positions = crumpled(&mesh.positions, 0.05, 11);
    mesh.shape_with(&RestShapeOptions { bending, ..Default::default() })
}

/// With γ = 1, no masses and no motion b is the elastic force and A the projected Hessian.
fn assembled<T: Scalar>(shape: &RestShape, x: &[DVec3]) -> (Vec<DVec3>, DMatrix<f64>) {
    assembled_at::<T>(shape, &ImplicitStep::backward_euler(x, x, 1.0, DVec3::ZERO))
}

fn assembled_at<T: Scalar>(shape: &RestShape, step: &ImplicitStep) -> (Vec<DVec3>, DMatrix<f64>) {
    let x = step.x;
    let mut system = System::<T>::new(shape, &fabric(), &Ordering::identity(shape.vertex_count()));
    system.settle(x);
    system.assemble(step, &vec![0.0; x.len()]);
    let mut a = DMatrix::zeros(3 * x.len(), 3 * x.len());
    for row in 0..x.len() {
        let diagonal = [(row as u32, system.matrix.diagonal(row))];
        for (column, block) in system.matrix.lower_row(row).chain(diagonal) {
            for (r, entries) in block.0.iter().enumerate() {
                for (c, entry) in entries.iter().enumerate() {
                    let (r, c) = (3 * row + r, 3 * column as usize + c);
                    a[(r, c)] = entry.to_f64();
                    if column as usize != row {
                        a[(c, r)] = entry.to_f64();
                    }
                }
            }
        }
    }
    (system.rhs.iter().map(|f| DVec3::from(f.to_f64())).collect(), a)
}

fn flat(forces: &[DVec3]) -> DVector<f64> {
    DVector::from_iterator(3 * forces.len(), forces.iter().flat_map(|f| f.to_array()))
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    // Sweeps come near the minimum over the turns.
    for (bending, tolerance) in [(BendingModel::Hinge, 1e-6), (BendingModel::MidEdge, 1e-5)] {
        let shape = bumpy_bent_by(bending);
        let mut system = System::<f64>::new(&shape, &fabric(), &Ordering::identity(shape.vertex_count()));
        let x = crumpled(&shape.positions, 0.08, 12);
        let (forces, _) = assembled::<f64>(&shape, &x);
        let differences = (0..3 * x.len()).map(|i| {
            let mut energy = |offset: f64| {
                let mut y = x.clone();
                y[i / 3][i % 3] += offset;
                system.settle(&y);
                let e = system.energy(&y);
                e.membrane + e.bending
            };
            -(energy(1e-6) - energy(-1e-6)) / 2e-6
        });
        let expected = DVector::from_iterator(3 * x.len(), differences);
        let error = (flat(&forces) - &expected).norm() / expected.norm();
        assert!(error < tolerance, "{bending:?}: relative error {error:e}");
    }
}

#[test]
fn rest_and_rigid_motions_give_no_force() {
    let shape = bumpy();
    let turn = DQuat::from_euler(bevy::math::EulerRot::XYZ, 0.7, -2.0, 1.1);
    let moved: Vec<_> = shape.positions.iter().map(|&p| turn * p + DVec3::new(3.0, -8.0, 0.5)).collect();
    let scale = assembled::<f64>(&shape, &crumpled(&shape.positions, 0.05, 1)).0;
    let scale = scale.iter().map(|f| f.length()).fold(0.0, f64::max);
    for x in [&shape.positions, &moved] {
        let (forces, _) = assembled::<f64>(&shape, x);
        let largest = forces.iter().map(|f| f.length()).fold(0.0, f64::max);
        assert!(largest < 1e-12 * scale, "{largest:e} of {scale:e} N");
    }
}

#[test]
fn damping_does_not_feel_a_rigid_rotation() {
    let shape = bumpy();
    // Stretched and crumpled: the geometric part of the Hessian, which would feel it, is far from zero.
    let x: Vec<_> = crumpled(&shape.positions, 0.05, 2).into_iter().map(|p| 1.2 * p).collect();
    let (_, without) = assembled::<f64>(&shape, &x);
    let damped = ImplicitStep { damping: 2.0, ..ImplicitStep::backward_euler(&x, &x, 1.0, DVec3::ZERO) };
    let (_, with) = assembled_at::<f64>(&shape, &damped);
    let spin = DVec3::new(0.3, -1.0, 0.7);
    let velocity = flat(&x.iter().map(|&x| spin.cross(x)).collect::<Vec<_>>());
    let damping = with - &without;
    let scale = damping.norm() * velocity.norm();
    assert!((damping * &velocity).norm() < 1e-12 * scale);
    assert!((without * &velocity).norm() > 1e-4 * scale);
}

#[test]
fn damping_force_is_the_damping_matrix_times_the_velocity() {
    let shape = bumpy_bent_by(BendingModel::Hinge);
    let x = crumpled(&shape.positions, 0.1, 2);
    let origin = crumpled(&x, 0.03, 9);
    let (gamma, damping) = (0.1, 0.3);
    let still = ImplicitStep { origin: &x, gamma, damping, ..ImplicitStep::backward_euler(&x, &x, 1.0, DVec3::ZERO) };
    let moving = ImplicitStep { origin: &origin, ..still };
    let (b_still, a) = assembled_at::<f64>(&shape, &still);
    let (b_moving, _) = assembled_at::<f64>(&shape, &moving);
    let (_, undamped) = assembled_at::<f64>(&shape, &ImplicitStep { damping: 0.0, ..still });
    // A = γ² H + γ dp D, and b holds −γ dp D (x − q).
    let moved: Vec<_> = x.iter().zip(&origin).map(|(&x, &q)| x - q).collect();
    let expected = -(a - undamped) * flat(&moved);
    let error = (flat(&b_moving) - flat(&b_still) - &expected).norm() / expected.norm();
    assert!(error < 1e-12, "{error:e}");
}

#[test]
fn strains_far_below_single_precision_still_give_the_right_force() {
    let shape = TestMesh::sheet(5, 5, 1.0, 1.0).shape();
    let x: Vec<_> = shape.positions.iter().map(|&p| p * DVec3::new(1.0 + 1e-9, 1.0, 1.0)).collect();
    let (f, _) = assembled::<f64>(&shape, &x);
    let (g, _) = assembled::<f32>(&shape, &x);
    let error = (flat(&f) - flat(&g)).norm() / flat(&f).norm();
    assert!(error < 1e-5, "{error:e}");
}

/// Mid-edge normals have a matrix above their own, so what is compared is the power.
#[test]
fn damping_takes_no_more_energy_than_the_matrix_says_and_none_from_a_rotation() {
    let shape = bumpy();
    let x = crumpled(&shape.positions, 0.1, 2);
    let spin: Vec<_> = x.iter().map(|&x| x - 1e-3 * DVec3::new(0.3, -1.0, 0.7).cross(x)).collect();
    let (gamma, damping) = (0.1, 0.3);
    for (origin, least) in [(crumpled(&x, 0.01, 9), 0.3), (spin, 0.0)] {
        let still =
            ImplicitStep { origin: &x, gamma, damping, ..ImplicitStep::backward_euler(&x, &x, 1.0, DVec3::ZERO) };
        let (b_still, a) = assembled_at::<f64>(&shape, &still);
        let (b_moving, _) = assembled_at::<f64>(&shape, &ImplicitStep { origin: &origin, ..still });
        let (_, undamped) = assembled_at::<f64>(&shape, &ImplicitStep { damping: 0.0, ..still });
        let moved = flat(&x.iter().zip(&origin).map(|(&x, &q)| x - q).collect::<Vec<_>>());
        let power = (flat(&b_still) - flat(&b_moving)).dot(&moved);
        let most = ((&a - &undamped) * &moved).dot(&moved);
        let scale = (a - undamped).norm() * moved.norm_squared();
        assert!(power > least * most - 1e-12 * scale && power < most + 1e-12 * scale, "{power:e} of {most:e}");
    }
}

#[test]
fn internal_forces_and_torques_sum_to_zero() {
    let shape = bumpy();
    for seed in 0..20 {
        let x = crumpled(&shape.positions, 0.2, seed);
        let (forces, _) = assembled::<f64>(&shape, &x);
        let scale: f64 = forces.iter().map(|f| f.length()).sum();
        let force: DVec3 = forces.iter().sum();
        let torque: DVec3 = x.iter().zip(&forces).map(|(x, &f)| x.cross(f)).sum();
        assert!(force.length() < 1e-12 * scale, "force {force}");
        assert!(torque.length() < 1e-12 * scale, "torque {torque}");
    }
}

#[test]
fn projected_hessian_has_no_negative_eigenvalue_on_crumpled_states() {
    let shape = bumpy();
    for seed in 0..20 {
        let (_, a) = assembled::<f64>(&shape, &crumpled(&shape.positions, 0.3, seed));
        assert!((&a - a.transpose()).norm() < 1e-14 * a.norm(), "not symmetric");
        let eigenvalues = a.symmetric_eigenvalues();
        assert!(eigenvalues.min() >= -1e-9 * eigenvalues.max(), "{:e}", eigenvalues.min());
    }
}

#[test]
fn every_number_type_assembles_the_same_system() {
    let shape = bumpy();
    let x = crumpled(&shape.positions, 0.1, 3);
    let (f, a) = assembled::<f64>(&shape, &x);
    let check = |name: &str, (g, b): (Vec<DVec3>, DMatrix<f64>)| {
        let force_error = (flat(&f) - flat(&g)).norm() / flat(&f).norm();
        let matrix_error = (&a - b).norm() / a.norm();
        assert!(force_error < 2e-6 && matrix_error < 2e-6, "{name}: {force_error:e} {matrix_error:e}");
    };
    check("f32", assembled::<f32>(&shape, &x));
}

#[test]
fn the_step_is_that_of_baraff_and_witkin() {
    // [M − Δt(Δt+dp) K] Δv = Δt [f + (Δt+dp) K v], here with dp = 0, against ours for d = Δt (v + Δv).
    let shape = bumpy();
    let dt = 1.0 / 60.0;
    let x = crumpled(&shape.positions, 0.05, 4);
    let mut rng = rng(5);
    let v: Vec<_> = x.iter().map(|_| random_vector(&mut rng)).collect();
    let masses: Vec<_> = shape.vertex_areas.iter().map(|a| 0.15 * a).collect();
    let gravity = DVec3::new(0.0, -9.81, 0.0);

    let (f, h) = assembled::<f64>(&shape, &x);
    let m = DVector::from_iterator(3 * x.len(), masses.iter().flat_map(|&m| [m; 3]));
    let weight: Vec<_> = masses.iter().map(|&m| m * gravity).collect();
    let a = DMatrix::from_diagonal(&m) + &h * (dt * dt);
    let b = (flat(&f) + flat(&weight) - &h * flat(&v) * dt) * dt;
    let expected = (a.cholesky().expect("positive definite").solve(&b) + flat(&v)) * dt;

    let mut system = System::<f64>::new(&shape, &fabric(), &Ordering::identity(shape.vertex_count()));
    let inertial: Vec<_> = x.iter().zip(&v).map(|(&x, &v)| x + dt * v).collect();
    system.settle(&x);
    system.assemble(&ImplicitStep::backward_euler(&x, &inertial, dt, gravity), &masses);
    let mut d = vec![Padded::zero(); x.len()];
    let kind = bevy_cloth::physics::SolverKind::ConjugateGradient {
        tolerance: 0.0,
        relative_tolerance: 0.0,
        max_iterations: 2000,
        preconditioner: Default::default(),
    };
    let mut solver = bevy_cloth::physics::solve::solver(kind, system.matrix.pattern());
    let target = bevy_cloth::physics::solve::Target { absolute: 1e-16, relative: 0.0 };
    solver.solve(&mut system.matrix, &system.rhs, &mut d, target).unwrap();
    let ours = DVector::from_iterator(3 * x.len(), d.iter().flat_map(|d| d.to_f64()));
    let error = (ours - &expected).norm() / expected.norm();
    assert!(error < 1e-9, "{error:e}");
}
