//! The yardstick: one product of the cloth's own matrix with a vector, timed in the same run.

use std::hint::black_box;
use std::time::{Duration, Instant};

use bevy_cloth::physics::Cloth;
use bevy_cloth::physics::assembly::BlockCsr;
use bevy_cloth::physics::math::Padded;

use crate::matrix::{FullMatrix, StepSystem};

/// Of so many products in a row the quickest counts: the first finds its matrix out of the cache.
const TRIES: usize = 3;

/// The matrix of a cloth, and a vector to multiply it with.
pub struct Yardstick {
    full: FullMatrix,
    half: BlockCsr<f32>,
    x: Vec<Padded<f32>>,
    y: Vec<Padded<f32>>,
}

impl Yardstick {
    /// For a cloth as it stands.
    pub fn new(cloth: &Cloth) -> Self {
        let StepSystem { mut system, positions, .. } = StepSystem::new(cloth);
        let x: Vec<_> = positions.iter().map(|x| Padded::from_f64(x.to_array())).collect();
        let full = FullMatrix::new(&system.matrix);
        system.matrix.interleave();
        Self { full, half: system.matrix, y: x.clone(), x }
    }

    /// Time of one product: with both halves of the matrix stored, as everybody has it, which is the yardstick; and as the
    /// solver has it, with one.
    pub fn time(&mut self) -> [Duration; 2] {
        let Self { full, half, x, y } = self;
        let least = |multiply: &mut dyn FnMut()| {
            let times = (0..TRIES).map(|_| {
                let start = Instant::now();
                multiply();
                start.elapsed()
            });
            times.min().unwrap_or_default()
        };
        let full = least(&mut || full.multiply(black_box(x), black_box(y)));
        let half = least(&mut || {
            black_box(half.multiply(black_box(x), black_box(y)));
        });
        [full, half]
    }
}
