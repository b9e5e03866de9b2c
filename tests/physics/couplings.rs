//! Forces on points of the cloth in A and b, whether the pattern couples their vertices or not.

use bevy::math::{DMat3, DVec3};
use bevy_cloth::physics::assembly::{ImplicitStep, Ordering, Stencil, System, constrain};
use bevy_cloth::physics::math::Padded;
use bevy_cloth::physics::solve::{PreconditionerKind, Target, solver};
use bevy_cloth::physics::{Fabric, SolverKind};
use nalgebra::{DMatrix, DVector};

use crate::matrices::dense;
use crate::meshes::{TestMesh, crumpled};

const DT: f64 = 1.0 / 60.0;
const DRIFT: DVec3 = DVec3::new(0.01, -0.02, 0.005);

fn stiffness() -> DMat3 {
    let way = DVec3::new(0.6, 0.0, 0.8);
    let outer = DMat3::from_cols(way * way.x, way * way.y, way * way.z);
    900.0 * outer + DMat3::from_diagonal(DVec3::splat(40.0))
}

fn stencil(vertices: [u32; 4], weights: [f64; 4]) -> Stencil {
    Stencil { vertices, weights, force: DVec3::new(0.3, 0.1, -0.2), stiffness: stiffness() }
}

/// In the pattern; across the cloth, one end pinned; a place of one triangle against that of another, far away.
fn stencils() -> [Stencil; 4] {
    [
        stencil([5, 5, 5, 5], [1.0, 0.0, 0.0, 0.0]),
        stencil([0, 9, 0, 0], [1.0, -1.0, 0.0, 0.0]),
        stencil([3, 60, 0, 0], [-1.0, 1.0, 0.0, 0.0]),
        stencil([20, 21, 50, 57], [0.4, 0.6, -0.5, -0.5]),
    ]
}

fn held() -> Vec<bool> {
    (0..63).map(|vertex| vertex < 4).collect()
}

fn prescribed(vertex: usize) -> DVec3 {
    DVec3::new(0.01, 0.02, -0.01) * (1.0 + vertex as f64)
}

fn system(stencils: &[Stencil]) -> System<f64> {
    let shape = TestMesh::jittered(9, 7, 1.0, 1.0, 0.2).shape();
    let mut system = System::new(&shape, &Fabric::cotton(), &Ordering::identity(shape.vertex_count()));
    let x = crumpled(&shape.positions, 0.02, 3);
    let inertial = crumpled(&x, DT, 4);
    let masses: Vec<_> = shape.vertex_areas.iter().map(|a| 0.15 * a).collect();
    let step = ImplicitStep { stencils, drift: DRIFT, ..ImplicitStep::backward_euler(&x, &inertial, DT, DVec3::NEG_Y) };
    system.assemble(&step, &masses);
    system
}

/// The same by dense algebra: moves of all vertices.
fn answer() -> DVector<f64> {
    let bare = system(&[]);
    let mut a = dense(&bare.matrix);
    let mut b = DVector::from_iterator(189, bare.rhs.iter().flat_map(|b| b.to_f64()));
    for Stencil { vertices, weights, force, stiffness } in stencils() {
        let w = DMatrix::from_fn(3, 189, |row, column| {
            let of = |i: usize| if vertices[i] as usize == column / 3 { weights[i] } else { 0.0 };
            if column % 3 == row { (0..4).map(of).sum() } else { 0.0 }
        });
        let k = DMatrix::from_fn(3, 3, |row, column| stiffness.col(column)[row]);
        let force = force - weights.iter().sum::<f64>() * (stiffness * DRIFT);
        a += DT * DT * w.transpose() * k * &w;
        b += DT * DT * w.transpose() * DVector::from_row_slice(&force.to_array());
    }
    for vertex in (0..63).filter(|&vertex| held()[vertex]) {
        for i in 0..3 {
            a.row_mut(3 * vertex + i).fill(0.0);
            a[(3 * vertex + i, 3 * vertex + i)] = 1.0;
            b[3 * vertex + i] = prescribed(vertex)[i];
        }
    }
    a.lu().solve(&b).expect("the matrix is regular")
}

#[test]
fn what_the_pattern_does_not_couple_is_solved_for_as_by_a_dense_matrix() {
    let answer = answer();
    let gradients =
        [PreconditionerKind::Multigrid, PreconditionerKind::IncompleteCholesky, PreconditionerKind::BlockJacobi];
    let kinds = gradients.map(|preconditioner| SolverKind::ConjugateGradient {
        tolerance: 0.0,
        relative_tolerance: 0.0,
        max_iterations: 10_000,
        preconditioner,
    });
    #[cfg(feature = "cholesky")]
    let kinds = kinds.into_iter().chain([SolverKind::Cholesky]);
    for kind in kinds {
        let stencils = stencils();
        let mut system = system(&stencils);
        constrain(&mut system.matrix, &mut system.rhs, &held(), |vertex| {
            Padded::from_f64(prescribed(vertex).to_array())
        });
        let mut d: Vec<_> = (0..63).map(|_| Padded::zero()).collect();
        for (vertex, d) in d.iter_mut().enumerate().filter(|(vertex, _)| held()[*vertex]) {
            *d = Padded::from_f64(prescribed(vertex).to_array());
        }
        let target = Target { absolute: 1e-13, relative: 0.0 };
        let mut solver = solver(kind, system.matrix.pattern());
        solver.solve(&mut system.matrix, &system.rhs, &mut d, target).unwrap();
        let found = DVector::from_iterator(189, d.iter().flat_map(|d| d.to_f64()));
        let error = (&found - &answer).amax();
        assert!(error < 1e-9 * answer.amax(), "{kind:?}: {error:e} of {}", answer.amax());
    }
}

#[test]
fn the_product_is_that_of_all_of_it() {
    let stencils = stencils();
    let mut system = system(&stencils);
    assert!(!system.matrix.couplings().is_empty());
    let x: Vec<_> =
        (0..63).map(|i| Padded::from_f64([f64::from(i).sin(), f64::from(i).cos(), 0.1 * f64::from(i)])).collect();
    let mut y = x.clone();
    system.matrix.interleave();
    let product = system.matrix.multiply(&x, &mut y);
    let sum: f64 = x.iter().zip(&y).map(|(x, y)| x.dot_f64(*y)).sum();
    assert!((product - sum).abs() < 1e-12 * sum, "{product} {sum}");
}
