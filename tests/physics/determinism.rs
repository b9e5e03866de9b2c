//! The same input gives the same bits.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

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

/// A cloth in one part must not wait for the thread pool: its threads may be waiting for whoever steps it, as where an App runs
/// in the pool while its systems run elsewhere.
#[test]
fn a_cloth_in_one_part_stays_on_its_thread() {
    let release = Arc::new(AtomicBool::new(false));
    let (here, all_here) = channel();
    let threads = rayon::current_num_threads();
    let pool = thread::spawn({
        let release = Arc::clone(&release);
        move || {
            rayon::broadcast(|_| {
                here.send(()).unwrap();
                while !release.load(Ordering::Acquire) {
                    thread::yield_now();
                }
            });
        }
    });
    (0..threads).for_each(|_| all_here.recv().unwrap());
    let (done, is_done) = channel();
    let cloth = thread::spawn(move || {
        run(SolverSettings::default());
        done.send(()).unwrap();
    });
    let stepped = is_done.recv_timeout(Duration::from_secs(60));
    release.store(true, Ordering::Release);
    cloth.join().unwrap();
    pool.join().unwrap();
    assert_eq!(stepped, Ok(()), "the cloth waited for a pool that had no thread free");
}
