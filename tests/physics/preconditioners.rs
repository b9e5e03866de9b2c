//! The preconditioners, on matrices of real cloths.

use bevy::math::DVec3;
use bevy_cloth::physics::assembly::{BlockCsr, ImplicitStep, Ordering, System, constrain};
use bevy_cloth::physics::math::{M3, Padded, Scalar};
use bevy_cloth::physics::solve::{
    BlockJacobi, ConjugateGradient, IncompleteCholesky, LinearSolver, Multigrid, Preconditioner, PreconditionerKind,
    Solved, Target, preconditioner,
};
use bevy_cloth::physics::{Cloth, Fabric, RestShape, SolverKind, SolverSettings, StepOutcome};

use crate::meshes::{TestMesh, crumpled, random_vector, rng};

const KINDS: [PreconditionerKind; 3] =
    [PreconditionerKind::BlockJacobi, PreconditionerKind::IncompleteCholesky, PreconditionerKind::Multigrid];

/// A system of a cloth with these pins, at the state given.
fn system<T: Scalar>(
    shape: &RestShape,
    fabric: &Fabric,
    state: (&[DVec3], &[DVec3]),
    dt: f64,
    pins: &[u32],
) -> System<T> {
    let ordering = Ordering::new(shape);
    let mut system = System::new(shape, fabric, &ordering);
    let inner = |values: &[DVec3]| -> Vec<_> { ordering.outer.iter().map(|&v| values[v as usize]).collect() };
    let (x, velocities) = (inner(state.0), inner(state.1));
    let areas = ordering.outer.iter().map(|&v| shape.vertex_areas[v as usize]);
    let masses: Vec<_> = areas.map(|area| area * f64::from(fabric.density)).collect();
    let gravity = DVec3::new(0.0, -9.81, 0.0);
    let inertial: Vec<_> = x.iter().zip(&velocities).map(|(&x, &v)| x + dt * v).collect();
    system.assemble(&ImplicitStep::backward_euler(&x, &inertial, dt, gravity), &masses);
    let pinned: Vec<_> = ordering.outer.iter().map(|v| pins.contains(v)).collect();
    constrain(&mut system.matrix, &mut system.rhs, &pinned, |_| Padded::zero());
    system
}

/// A sheet of n × n, hung by two corners from the horizontal, a third of a second later.
fn swinging<T: Scalar>(n: usize, pins: impl Fn(u32) -> bool) -> System<T> {
    let mut mesh = TestMesh::jittered(n, n, 1.0, 1.0, 0.2);
    for p in &mut mesh.positions {
        *p = DVec3::new(p.x, 0.0, -p.y);
    }
    let (shape, fabric) = (mesh.shape(), Fabric::isotropic(0.15, 1000.0, 0.3, 1e-5));
    let pins: Vec<_> = (0..(n * n) as u32).filter(|&v| pins(v)).collect();
    let mut cloth = Cloth::new(shape.clone(), fabric, SolverSettings::default()).unwrap();
    for &pin in &pins {
        cloth.pin(pin, cloth.positions()[pin as usize]);
    }
    for _ in 0..20 {
        assert_eq!(cloth.step(1.0 / 60.0).outcome, StepOutcome::Accepted);
    }
    system(&shape, &fabric, (cloth.positions(), cloth.velocities()), 1.0 / 60.0, &pins)
}

fn corners(n: usize) -> impl Fn(u32) -> bool {
    move |v| v == 0 || v as usize == n - 1
}

fn random<T: Scalar>(count: usize, seed: u64) -> Vec<Padded<T>> {
    let mut rng = rng(seed);
    (0..count).map(|_| Padded::from_f64(random_vector(&mut rng).to_array())).collect()
}

fn dot<T: Scalar>(a: &[Padded<T>], b: &[Padded<T>]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| a.dot_f64(b)).sum()
}

/// P⁻¹ has to be symmetric and positive definite: |uᵀP⁻¹v − vᵀP⁻¹u| relative to √(uᵀP⁻¹u vᵀP⁻¹v).
fn asymmetry<T: Scalar>(a: &BlockCsr<T>, kind: PreconditionerKind) -> f64 {
    let rows = a.pattern().row_count();
    let mut p = preconditioner(kind, a.pattern());
    p.update(a);
    let mut a = a.clone();
    a.interleave();
    let a = &a;
    let mut worst: f64 = 0.0;
    for seed in 0..10 {
        let (u, v) = (random::<T>(rows, 2 * seed), random::<T>(rows, 2 * seed + 1));
        let (mut pu, mut pv) = (vec![Padded::zero(); rows], vec![Padded::zero(); rows]);
        let (uu, vv) = (p.apply(a, &u, &mut pu), p.apply(a, &v, &mut pv));
        assert!((uu - dot(&u, &pu)).abs() < 1e-6 * uu && (vv - dot(&v, &pv)).abs() < 1e-6 * vv, "{kind:?}");
        assert!(uu > 0.0 && vv > 0.0, "{kind:?}: {uu:e} {vv:e}");
        worst = worst.max((dot(&u, &pv) - dot(&v, &pu)).abs() / (uu * vv).sqrt());
    }
    worst
}

/// Iterations until √(rᵀP⁻¹r) is `reduction` times what it was at d = 0.
fn iterations<T: Scalar, P: Preconditioner<T>>(
    system: &(BlockCsr<T>, Vec<Padded<T>>),
    mut p: P,
    reduction: f64,
) -> Solved {
    let (mut a, b) = system.clone();
    let mut z = b.clone();
    p.update(&a);
    let mut interleaved = a.clone();
    interleaved.interleave();
    p.apply(&interleaved, &b, &mut z);
    let target = Target { absolute: reduction * dot(&b, &z).sqrt(), relative: 0.0 };
    let mut d = vec![Padded::zero(); b.len()];
    ConjugateGradient::new(b.len(), p, 2000).solve(&mut a, &b, &mut d, target).unwrap()
}

fn parts<T: Scalar>(system: System<T>) -> (BlockCsr<T>, Vec<Padded<T>>) {
    (system.matrix, system.rhs)
}

#[test]
fn preconditioners_are_symmetric_and_positive_definite() {
    fn check<T: Scalar>(tolerance: f64) {
        let n = 20;
        let system = swinging::<T>(n, corners(n));
        for kind in KINDS {
            let asymmetry = asymmetry(&system.matrix, kind);
            assert!(asymmetry < tolerance, "{kind:?}: {asymmetry:e}");
        }
    }
    check::<f64>(1e-11);
    check::<f32>(1e-3);
    // Several parts, which know of each other only what was before a sweep.
    let system = swinging::<f64>(105, corners(105));
    let asymmetry = asymmetry(&system.matrix, PreconditionerKind::Multigrid);
    assert!(asymmetry < 1e-11, "{asymmetry:e}");
}

#[test]
fn multigrid_takes_few_iterations_and_hardly_more_on_larger_cloths() {
    let count = |n| {
        let system = parts(swinging::<f32>(n, corners(n)));
        let multigrid = iterations(&system, Multigrid::new(system.0.pattern()), 1e-3).iterations;
        let cholesky = iterations(&system, IncompleteCholesky::new(system.0.pattern()), 1e-3).iterations;
        (multigrid, cholesky)
    };
    let (small, _) = count(20);
    let (medium, _) = count(40);
    let (large, _) = count(80);
    assert!(medium <= 15, "{medium}");
    assert!(f64::from(large) <= 1.6 * f64::from(small), "{small} to {large}");
    // Beyond that size a cloth is in parts, which cost something.
    let (large, cholesky) = count(105);
    assert!(f64::from(large) <= 2.0 * f64::from(small), "{small} to {large}");
    assert!(2 * large < cholesky, "{large} against {cholesky}");
}

#[test]
fn single_and_double_precision_take_the_same_iterations() {
    let n = 24;
    let (single, double) = (parts(swinging::<f32>(n, corners(n))), parts(swinging::<f64>(n, corners(n))));
    let single = iterations(&single, Multigrid::new(single.0.pattern()), 1e-4).iterations;
    let double = iterations(&double, Multigrid::new(double.0.pattern()), 1e-4).iterations;
    assert!(single.abs_diff(double) <= 1, "{single} {double}");
}

#[test]
fn pins_do_multigrid_no_harm() {
    let n = 40;
    let cases: [fn(usize, usize) -> bool; 4] = [
        |row, _| row == 0,
        // Whole aggregates of pins.
        |row, _| row < 20,
        |row, column| (7 * row + 5 * column) % 11 == 0,
        |_, _| true,
    ];
    for (i, pinned) in cases.into_iter().enumerate() {
        let system = parts(swinging::<f32>(n, |v| pinned(v as usize / n, v as usize % n)));
        let multigrid = iterations(&system, Multigrid::new(system.0.pattern()), 1e-3);
        let jacobi = iterations(&system, BlockJacobi::new(n * n), 1e-3);
        assert!(
            multigrid.converged && multigrid.iterations <= 1.max(jacobi.iterations / 3),
            "{i}: {multigrid:?} {jacobi:?}"
        );
    }
}

/// Matrices that hardly look like a cloth: a step of 1 s, stiff, crumpled to a ball, pinned here and there.
fn extreme<T: Scalar>(stiffness: f32, seed: u64) -> System<T> {
    let shape = TestMesh::jittered(25, 30, 1.0, 1.0, 0.3).shape();
    let fabric = Fabric::isotropic(0.15, stiffness, 0.3, 1e-3);
    let x = crumpled(&vec![DVec3::ZERO; shape.positions.len()], 0.3, seed);
    let velocities = crumpled(&vec![DVec3::ZERO; x.len()], 10.0, seed + 1);
    system(&shape, &fabric, (&x, &velocities), 1.0, &[0, 24, 300])
}

#[test]
fn extreme_matrices_are_solved_with_every_preconditioner() {
    for stiffness in [1.0, 1e6] {
        let (a, b) = parts(extreme::<f64>(stiffness, 3));
        for kind in KINDS {
            let asymmetry = asymmetry(&a, kind);
            assert!(asymmetry < 1e-6, "{kind:?}: {asymmetry:e}");
        }
        let system = (a, b);
        let jacobi = iterations(&system, BlockJacobi::new(system.1.len()), 1e-3);
        let cholesky = iterations(&system, IncompleteCholesky::new(system.0.pattern()), 1e-3);
        let multigrid = iterations(&system, Multigrid::new(system.0.pattern()), 1e-3);
        assert!(cholesky.converged && multigrid.converged, "{stiffness}: {jacobi:?} {cholesky:?} {multigrid:?}");
    }
}

#[test]
fn extreme_matrices_in_single_precision_leave_preconditioners_finite_and_positive() {
    for stiffness in [1.0, 1e6] {
        let system = extreme::<f32>(stiffness, 5);
        for kind in KINDS {
            asymmetry(&system.matrix, kind);
        }
    }
}

#[test]
fn incomplete_cholesky_gets_over_matrices_it_cannot_factorise() {
    let system = swinging::<f64>(12, corners(12));
    let mut p = IncompleteCholesky::new(system.matrix.pattern());
    // Indefinite beyond every shift: what is left is block Jacobi.
    let mut spoilt = system.matrix.clone();
    for row in 0..system.rhs.len() {
        for slot in spoilt.pattern().clone().row(row) {
            if spoilt.block(slot) != M3::zero() {
                spoilt.set_block(slot, spoilt.diagonal(row) * 2.0);
            }
        }
    }
    p.update(&spoilt);
    let mut jacobi = BlockJacobi::new(system.rhs.len());
    jacobi.update(&spoilt);
    let r = random::<f64>(system.rhs.len(), 1);
    let (mut z, mut expected) = (r.clone(), r.clone());
    p.apply(&spoilt, &r, &mut z);
    jacobi.apply(&spoilt, &r, &mut expected);
    assert_eq!(z, expected);

    // And it recovers: the next matrix is factorised as if nothing had been.
    p.update(&system.matrix);
    p.apply(&system.matrix, &r, &mut z);
    let mut fresh = IncompleteCholesky::new(system.matrix.pattern());
    fresh.update(&system.matrix);
    fresh.apply(&system.matrix, &r, &mut expected);
    assert_eq!(z, expected);
}

#[test]
fn multigrid_takes_loose_pieces_and_tiny_cloths() {
    let tiny = TestMesh::sheet(2, 2, 1.0, 1.0);
    let mut pieces = TestMesh { positions: Vec::new(), triangles: Vec::new(), uvs: Vec::new() };
    for piece in 0..100u32 {
        let corner = |i: u32| DVec3::new(f64::from(i % 2 + 3 * piece), -f64::from(i / 2), 0.0);
        pieces.positions.extend((0..3).map(corner));
        pieces.uvs.extend((0..3).map(|i| [corner(i).x as f32, -corner(i).y as f32]));
        pieces.triangles.push([3 * piece, 3 * piece + 2, 3 * piece + 1]);
    }
    for mesh in [tiny, pieces] {
        let shape = mesh.shape();
        let x = crumpled(&shape.positions, 0.05, 8);
        let zeros = vec![DVec3::ZERO; x.len()];
        let system = parts(system::<f64>(&shape, &Fabric::cotton(), (&x, &zeros), 1.0 / 60.0, &[]));
        let solved = iterations(&system, Multigrid::new(system.0.pattern()), 1e-9);
        assert!(solved.converged && solved.iterations <= 30, "{solved:?}");
    }
}

#[test]
fn every_choice_of_preconditioner_moves_the_cloth_alike() {
    let run = |preconditioner| {
        let kind = SolverKind::ConjugateGradient {
            tolerance: 1e-4,
            relative_tolerance: 0.0,
            max_iterations: 2000,
            preconditioner,
        };
        let shape = TestMesh::sheet(12, 12, 1.0, 1.0).shape();
        let settings = SolverSettings { kind, ..Default::default() };
        let mut cloth = Cloth::new(shape, Fabric::cotton(), settings).unwrap();
        cloth.pin(0, cloth.positions()[0]);
        for _ in 0..10 {
            assert_eq!(cloth.step(1.0 / 60.0).outcome, StepOutcome::Accepted);
        }
        cloth.positions().to_vec()
    };
    let expected = run(PreconditionerKind::Multigrid);
    for kind in KINDS {
        let error = run(kind).iter().zip(&expected).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(error < 1e-5, "{kind:?}: {error:e} m");
    }
}
