//! A step in the steady state allocates nothing, whatever the level of quality. Alone in its process: no other test allocates beside it.

use std::alloc::System;

use bevy::math::DVec3;
use bevy_cloth::physics::{
    Cloth, Fabric, Quality, RestShape, RestShapeOptions, SolverSettings, StepOutcome, SurfaceMesh,
};
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// A square of n × n vertices, held by two corners if `pinned`.
fn sheet(n: u32, pinned: bool, settings: SolverSettings) -> Cloth {
    let vertices = (0..n).flat_map(|row| (0..n).map(move |column| (row, column)));
    let positions: Vec<_> = vertices.map(|(row, column)| DVec3::new(column.into(), 0.0, row.into()) / 50.0).collect();
    let corners = (0..n - 1).flat_map(|row| (0..n - 1).map(move |column| row * n + column));
    let triangles: Vec<_> = corners.flat_map(|a| [[a, a + n, a + 1], [a + 1, a + n, a + n + 1]]).collect();
    let mesh = SurfaceMesh { positions: &positions, triangles: &triangles, uvs: None };
    let shape = RestShape::new(&mesh, &RestShapeOptions::default()).expect("a valid mesh");
    let mut cloth = Cloth::new(shape, Fabric::cotton(), settings).expect("a valid fabric");
    for vertex in [0, n - 1].into_iter().filter(|_| pinned) {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    cloth
}

#[test]
fn steps_do_not_allocate() {
    // A small cloth, a larger one, several parts on several threads, and no pins.
    let cases = [(8, true, 1), (24, true, 1), (105, true, 2), (24, false, 1)];
    for (n, pinned, threads) in cases {
        let mut cloth = sheet(n, pinned, SolverSettings::default());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let (allocated, accepted) = pool.install(|| {
            for _ in 0..10 {
                cloth.step(1.0 / 60.0);
            }
            let before = ALLOCATOR.stats();
            let accepted = (0..20).all(|step| {
                cloth.set_settings(Quality::ALL[step % 5].settings());
                cloth.step(1.0 / 60.0).outcome == StepOutcome::Accepted
            });
            let after = ALLOCATOR.stats();
            let count = |stats: stats_alloc::Stats| stats.allocations + stats.reallocations;
            (count(after) - count(before), accepted)
        });
        assert!(accepted);
        assert_eq!(allocated, 0, "{n}² vertices, pinned: {pinned}, {threads} threads");
    }
}
