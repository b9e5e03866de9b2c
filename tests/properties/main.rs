//! Properties that hold for every mesh, fabric and motion, tried on random ones: the same every time.

mod generators;
mod mesh_input;
mod physics;
mod plugin;

use proptest::test_runner::{Config, RngSeed};

/// So many cases, drawn from a fixed seed, which leave no file behind.
fn cases(cases: u32) -> Config {
    Config { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Config::default() }
}
