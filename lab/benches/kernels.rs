//! The parts of a step, one by one, on the swinging sheet: `cargo bench -p lab`.

use bevy_cloth::physics::assembly::System;
use bevy_cloth::physics::math::Padded;
use bevy_cloth::physics::solve::{
    BlockJacobi, IncompleteCholesky, Multigrid, Preconditioner, SolverKind, Target, solver,
};
use bevy_cloth::physics::{Cloth, SolverSettings};
use divan::{Bencher, black_box};
use lab::matrix::{FullMatrix, StepSystem};
use lab::scenes::{DT, Meshing, Sheet};

/// Vertices along a side.
const SIZES: [u32; 3] = [20, 64, 100];

/// A quarter of a second into the swing.
const FRAMES: usize = 15;

fn main() {
    divan::main();
}

fn swinging(side: u32) -> (Cloth, StepSystem) {
    let mut cloth = Sheet::new(side, Meshing::Grid).hang(SolverSettings::default());
    for _ in 0..FRAMES {
        cloth.step(DT);
    }
    let step = StepSystem::new(&cloth);
    (cloth, step)
}

#[divan::bench(args = SIZES)]
fn assembly(bencher: Bencher, side: u32) {
    let (cloth, mut step) = swinging(side);
    bencher.bench_local(|| step.assemble(black_box(cloth.gravity())));
}

#[divan::bench(args = SIZES)]
fn spmv(bencher: Bencher, side: u32) {
    let StepSystem { mut system, .. } = swinging(side).1;
    system.matrix.interleave();
    let mut y = system.rhs.clone();
    bencher.bench_local(|| system.matrix.multiply(black_box(&system.rhs), &mut y));
}

#[divan::bench(args = SIZES)]
fn spmv_both_halves_stored(bencher: Bencher, side: u32) {
    let StepSystem { system, .. } = swinging(side).1;
    let full = FullMatrix::new(&system.matrix);
    let mut y = system.rhs.clone();
    bencher.bench_local(|| full.multiply(black_box(&system.rhs), &mut y));
}

#[divan::bench(args = SIZES)]
fn block_jacobi_update(bencher: Bencher, side: u32) {
    update(bencher, side, |system| BlockJacobi::new(system.rhs.len()));
}

#[divan::bench(args = SIZES)]
fn incomplete_cholesky_update(bencher: Bencher, side: u32) {
    update(bencher, side, |system| IncompleteCholesky::new(system.matrix.pattern()));
}

#[divan::bench(args = SIZES)]
fn multigrid_update(bencher: Bencher, side: u32) {
    update(bencher, side, |system| Multigrid::new(system.matrix.pattern()));
}

#[divan::bench(args = SIZES)]
fn block_jacobi_apply(bencher: Bencher, side: u32) {
    apply(bencher, side, |system| BlockJacobi::new(system.rhs.len()));
}

#[divan::bench(args = SIZES)]
fn incomplete_cholesky_apply(bencher: Bencher, side: u32) {
    apply(bencher, side, |system| IncompleteCholesky::new(system.matrix.pattern()));
}

#[divan::bench(args = SIZES)]
fn multigrid_apply(bencher: Bencher, side: u32) {
    apply(bencher, side, |system| Multigrid::new(system.matrix.pattern()));
}

/// The linear solve of a step, preconditioner included, from no guess.
#[divan::bench(args = SIZES)]
fn solve(bencher: Bencher, side: u32) {
    let (cloth, StepSystem { system, .. }) = swinging(side);
    let mut solver = solver(SolverKind::default(), system.matrix.pattern());
    // √(rᵀP⁻¹r) of an acceleration of 5 mm/s², or three hundredths of what it was.
    let mass = cloth.masses().iter().sum::<f64>();
    let target = Target { absolute: 0.005 * DT * DT * mass.sqrt(), relative: 0.03 };
    let mut d = system.rhs.clone();
    bencher.with_inputs(|| system.matrix.clone()).bench_local_refs(|matrix| {
        d.fill(Padded::zero());
        solver.solve(matrix, black_box(&system.rhs), &mut d, target).expect("the matrix is positive definite")
    });
}

#[divan::bench(args = SIZES)]
fn step(bencher: Bencher, side: u32) {
    let (mut cloth, _) = swinging(side);
    let (positions, velocities) = (cloth.positions().to_vec(), cloth.velocities().to_vec());
    bencher.bench_local(|| {
        cloth.set_state(&positions, &velocities);
        cloth.step(DT)
    });
}

fn update<P: Preconditioner<f32>>(bencher: Bencher, side: u32, new: impl Fn(&System<f32>) -> P) {
    let StepSystem { system, .. } = swinging(side).1;
    let mut preconditioner = new(&system);
    bencher.bench_local(|| preconditioner.update(black_box(&system.matrix)));
}

fn apply<P: Preconditioner<f32>>(bencher: Bencher, side: u32, new: impl Fn(&System<f32>) -> P) {
    let StepSystem { mut system, .. } = swinging(side).1;
    let mut preconditioner = new(&system);
    preconditioner.update(&system.matrix);
    system.matrix.interleave();
    let mut z = system.rhs.clone();
    bencher.bench_local(|| preconditioner.apply(&system.matrix, black_box(&system.rhs), &mut z));
}
