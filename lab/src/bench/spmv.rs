//! The yardstick: one product of the cloth's own matrix with a vector, timed in the same run.

use std::hint::black_box;
use std::time::{Duration, Instant};

use bevy_cloth::physics::Cloth;
use bevy_cloth::physics::math::V3;

use super::statistics::median;
use crate::matrix::StepSystem;

/// Products are timed for this long, and at least so many of them.
const DURATION: Duration = Duration::from_millis(100);
const LEAST: usize = 50;

/// Median time of one [`multiply`](bevy_cloth::physics::assembly::BlockCsr::multiply) of the matrix of this cloth as it
/// stands, ms.
pub fn time(cloth: &Cloth) -> f64 {
    let matrix = StepSystem::new(cloth).system.matrix;
    let x: Vec<_> = cloth.positions().iter().map(|x| V3::from_f64(x.to_array())).collect();
    let mut y = vec![V3::zero(); x.len()];

    let begin = Instant::now();
    let mut times = Vec::new();
    while times.len() < LEAST || begin.elapsed() < DURATION {
        let start = Instant::now();
        matrix.multiply(black_box(&x), &mut y);
        black_box(&y);
        times.push(start.elapsed());
    }
    median(&times)
}
