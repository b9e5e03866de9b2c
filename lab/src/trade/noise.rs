//! The noise floor: how far apart motions are that begin all but the same.

use bevy::math::DVec3;
use bevy_cloth::physics::SolverSettings;
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use super::body::{Body, Ruler, advance};
use super::errors::{Errors, Trace};
use super::reference::FRAMES;
use super::scene::Stage;

/// How far off each coordinate begins, at most, m.
pub const PERTURBATION: f64 = 1e-6;

/// Motions beside the unperturbed one.
const ENSEMBLE: u64 = 4;

/// Root mean square errors of perturbed motions against the unperturbed one, by the default method; of the shape at rest, the
/// perturbation itself. Methods that differ by less than this cannot be told apart.
pub fn floor(stage: &Stage) -> Errors {
    let mut ruler = Ruler::new(stage);
    let plain = run(stage, None, &mut ruler);
    let mut floor = Errors::default();
    let square = |sum: &mut f64, error: f64| *sum += error * error / ENSEMBLE as f64;
    for seed in 0..ENSEMBLE {
        let errors = run(stage, Some(seed), &mut ruler).errors(&plain, &ruler);
        square(&mut floor.motion_m, errors.motion_m);
        square(&mut floor.stretch, errors.stretch);
        square(&mut floor.energy, errors.energy);
    }
    Errors {
        motion_m: floor.motion_m.sqrt(),
        settled_m: PERTURBATION,
        stretch: floor.stretch.sqrt(),
        energy: floor.energy.sqrt(),
    }
}

/// A motion, perturbed by this seed.
fn run(stage: &Stage, seed: Option<u64>, ruler: &mut Ruler) -> Trace {
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
    let mut trace = Trace::default();
    for frame in 0..FRAMES {
        advance(&mut cloth, stage, frame);
        trace.push(&cloth, ruler);
    }
    trace
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trade::scene::Scene;

    #[test]
    fn noise_is_more_than_the_perturbation_and_less_than_the_errors() {
        let noise = floor(&Stage::new(Scene::Sheet, 8));
        assert!(noise.motion_m > PERTURBATION && noise.motion_m < 1e-3, "{noise:?}");
        assert!(noise.stretch > 0.0 && noise.stretch < 0.1 && noise.energy < 0.01, "{noise:?}");
    }
}
