//! The noise floor: how far apart motions are that begin all but the same.

use bevy::math::DVec3;
use bevy_cloth::physics::SolverSettings;
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use super::body::{Body, advance, mean_square_distance};
use super::reference::FRAMES;
use super::scene::Stage;

/// How far off each coordinate begins, at most, m.
pub const PERTURBATION: f64 = 1e-6;

/// Motions beside the unperturbed one.
const ENSEMBLE: u64 = 4;

/// Root mean square distance of perturbed motions from the unperturbed one, over all vertices and frames, m, by the default
/// method. Methods that differ by less than this cannot be told apart.
pub fn floor(stage: &Stage) -> f64 {
    let plain = run(stage, None);
    let squares = (0..ENSEMBLE).map(|seed| {
        let perturbed = run(stage, Some(seed));
        plain.iter().zip(&perturbed).map(|(a, b)| mean_square_distance(a, b)).sum::<f64>()
    });
    (squares.sum::<f64>() / (ENSEMBLE as f64 * f64::from(FRAMES))).sqrt()
}

/// The frames of a motion, perturbed by this seed.
fn run(stage: &Stage, seed: Option<u64>) -> Vec<Vec<DVec3>> {
    let mut cloth = stage.cloth(Stage::fabric(), SolverSettings::default());
    if let Some(seed) = seed {
        let mut random = StdRng::seed_from_u64(seed);
        let mut offset = || random.random_range(-PERTURBATION..=PERTURBATION);
        let mut positions = stage.shape.positions.clone();
        for x in &mut positions {
            *x += DVec3::new(offset(), offset(), offset());
        }
        cloth.place(&positions);
    }
    (0..FRAMES)
        .map(|frame| {
            advance(&mut cloth, stage, frame);
            cloth.positions().to_vec()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trade::scene::Scene;

    #[test]
    fn noise_is_more_than_the_perturbation_and_less_than_the_errors() {
        let noise = floor(&Stage::new(Scene::Sheet, 8));
        assert!(noise > PERTURBATION && noise < 1e-3, "{noise}");
    }
}
