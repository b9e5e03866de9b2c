//! The linear solvers, on matrices of real cloths.

use bevy::math::DVec3;
use bevy_cloth::physics::assembly::{BlockCsr, ImplicitStep, Ordering, System, constrain};
use bevy_cloth::physics::math::{M3, Padded};
use bevy_cloth::physics::solve::{PreconditionerKind, SolveError, Target, solver};
use bevy_cloth::physics::{Fabric, SolverKind};

use crate::meshes::{TestMesh, crumpled};

const TIGHT: SolverKind = kind(10_000);
const TARGET: Target = Target { absolute: 1e-14, relative: 0.0 };

const fn kind(max_iterations: u32) -> SolverKind {
    SolverKind::ConjugateGradient {
        tolerance: 0.0,
        relative_tolerance: 0.0,
        max_iterations,
        preconditioner: PreconditionerKind::Multigrid,
    }
}

fn system(seed: u64) -> System<f64> {
    let shape = TestMesh::jittered(12, 9, 1.0, 1.0, 0.2).shape();
    let fabric = Fabric::cotton();
    let mut system = System::new(&shape, &fabric, &Ordering::new(&shape));
    let x = crumpled(&shape.positions, 0.02, seed);
    let dt = 1.0 / 60.0;
    let inertial = crumpled(&x, dt, seed + 1);
    let masses: Vec<_> = shape.vertex_areas.iter().map(|a| 0.15 * a).collect();
    let step = ImplicitStep::backward_euler(&x, &inertial, dt, DVec3::new(0.0, -9.81, 0.0));
    system.assemble(&step, &masses);
    system
}

fn residual(a: &mut BlockCsr<f64>, b: &[Padded<f64>], d: &[Padded<f64>]) -> f64 {
    let mut product = b.to_vec();
    a.interleave();
    a.multiply(d, &mut product);
    let norm = |v: &mut dyn Iterator<Item = f64>| v.sum::<f64>().sqrt();
    let r = norm(&mut product.iter().zip(b).map(|(&p, &b)| (b - p).dot_f64(b - p)));
    r / norm(&mut b.iter().map(|b| b.dot_f64(*b)))
}

#[test]
fn every_solver_solves() {
    let kinds = [
        TIGHT,
        #[cfg(feature = "cholesky")]
        SolverKind::Cholesky,
    ];
    for kind in kinds {
        let first = system(1);
        let mut solver = solver(kind, first.matrix.pattern());
        // The second system reuses what the first left behind.
        for mut system in [first, system(2)] {
            let mut d = vec![Padded::zero(); system.rhs.len()];
            let solved = solver.solve(&mut system.matrix, &system.rhs, &mut d, TARGET).unwrap();
            assert!(solved.converged, "{kind:?}");
            let r = residual(&mut system.matrix, &system.rhs, &d);
            assert!(r < 1e-9, "{kind:?}: {r:e}");
        }
    }
}

#[test]
fn conjugate_gradients_stop_at_the_tolerance_and_at_the_limit() {
    let system = system(3);
    let run = |target, max_iterations| {
        let mut d = vec![Padded::zero(); system.rhs.len()];
        let mut solver = solver(kind(max_iterations), system.matrix.pattern());
        solver.solve(&mut system.matrix.clone(), &system.rhs, &mut d, target).unwrap()
    };
    let absolute = |absolute| Target { absolute, relative: 0.0 };
    let (loose, tight) = (run(absolute(1e-5), 1000), run(absolute(1e-9), 1000));
    assert!(0 < loose.iterations && loose.iterations < tight.iterations, "{loose:?} {tight:?}");
    // Whichever bound is reached first.
    let relative = run(Target { absolute: 1e-9, relative: 0.1 }, 1000);
    assert!(0 < relative.iterations && relative.iterations < tight.iterations, "{relative:?} {tight:?}");
    let cut = run(absolute(1e-12), 3);
    assert_eq!((cut.iterations, cut.converged), (3, false));
}

#[test]
fn pins_are_exact_and_coupled_with_nothing() {
    let mut system = system(4);
    let count = system.rhs.len();
    let pinned: Vec<_> = (0..count).map(|v| v % 7 == 0).collect();
    let prescribed = |v: usize| Padded::new([0.01 * v as f64, -0.3, 1.0 / 3.0]);
    let (mut full, rhs) = (system.matrix.clone(), system.rhs.clone());
    full.interleave();
    constrain(&mut system.matrix, &mut system.rhs, &pinned, prescribed);
    let mut d: Vec<_> = (0..count).map(|v| if pinned[v] { prescribed(v) } else { Padded::zero() }).collect();
    let constrained = system.matrix.clone();
    solver(TIGHT, constrained.pattern()).solve(&mut system.matrix, &system.rhs, &mut d, TARGET).unwrap();

    // The free rows of the original system hold, with d as prescribed at the pins.
    let mut product = rhs.clone();
    full.multiply(&d, &mut product);
    for v in 0..count {
        if pinned[v] {
            assert_eq!(d[v], prescribed(v));
        } else {
            assert!((product[v] - rhs[v]).dot_f64(product[v] - rhs[v]).sqrt() < 1e-9, "row {v}");
        }
        // Nothing couples a pin.
        for (column, block) in constrained.lower_row(v) {
            assert!(!(pinned[v] || pinned[column as usize]) || block == M3::zero(), "({v}, {column})");
        }
        assert_eq!(system.matrix.fixed[v], pinned[v]);
    }
}

#[test]
fn matrices_that_cannot_be_solved_are_errors() {
    let kinds = [
        TIGHT,
        #[cfg(feature = "cholesky")]
        SolverKind::Cholesky,
    ];
    for kind in kinds {
        let solve = |spoil: &dyn Fn(&mut System<f64>)| {
            let mut system = system(5);
            spoil(&mut system);
            let mut d = vec![Padded::zero(); system.rhs.len()];
            solver(kind, system.matrix.pattern()).solve(&mut system.matrix, &system.rhs, &mut d, TARGET).unwrap_err()
        };
        assert_eq!(solve(&|s| s.rhs[3] = Padded::new([0.0, f64::NAN, 0.0])), SolveError::NotFinite, "{kind:?}");
        assert_eq!(solve(&|s| s.matrix.set_diagonal(2, M3::zero() * f64::NAN)), SolveError::NotFinite, "{kind:?}");
        let indefinite = solve(&|s| {
            for row in 0..s.rhs.len() {
                s.matrix.set_diagonal(row, -s.matrix.diagonal(row));
                for slot in s.matrix.pattern().clone().row(row) {
                    s.matrix.set_block(slot, -s.matrix.block(slot));
                }
            }
        });
        assert_eq!(indefinite, SolveError::NotPositiveDefinite, "{kind:?}");
    }
}
