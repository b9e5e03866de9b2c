//! The same input gives the same bits.

use bevy_cloth::physics::{Cloth, Fabric, SolverSettings};

use crate::meshes::TestMesh;

fn run(settings: SolverSettings) -> Vec<bevy::math::DVec3> {
    let shape = TestMesh::jittered(15, 15, 1.0, 1.0, 0.2).shape();
    let mut cloth = Cloth::new(shape, Fabric::cotton(), settings).unwrap();
    for vertex in [0, 14] {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    for _ in 0..60 {
        cloth.step(1.0 / 60.0);
    }
    cloth.positions().to_vec()
}

#[test]
fn two_runs_agree_bitwise() {
    for settings in [SolverSettings::default(), SolverSettings::reference()] {
        assert_eq!(run(settings), run(settings));
    }
    assert_ne!(run(SolverSettings::default()), run(SolverSettings::reference()));
}

#[test]
fn every_number_of_threads_gives_the_same_bits() {
    // Large enough for several parts.
    let run = |threads| {
        let shape = TestMesh::jittered(110, 110, 1.0, 1.0, 0.2).shape();
        let mut cloth = Cloth::new(shape, Fabric::cotton(), SolverSettings::default()).unwrap();
        for vertex in [0, 109] {
            cloth.pin(vertex, cloth.positions()[vertex as usize]);
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (0..10).for_each(|_| _ = cloth.step(1.0 / 60.0)));
        cloth.positions().to_vec()
    };
    let alone = run(1);
    assert_eq!(alone, run(2));
    assert_eq!(alone, run(5));
}
