//! Whether a cloth stands still where it must move: where the reference does.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Integrator, SolverSettings};

use super::sample::{SIZE, Sample};
use super::scene::Scene;

/// Steps over which motion is judged.
const WINDOW: u32 = 16;
/// Steps of the reference per step.
const SUBSTEPS: u32 = 4;
/// Acceleration that the default solver leaves, m/s².
const TOLERANCE: f64 = 0.005;
/// The reference moves so many times as far as a frozen cloth.
const RATIO: f64 = 10.0;

/// A state to look back to.
struct Before {
    step: u32,
    time: f64,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

impl Before {
    fn of(cloth: &Cloth, step: u32, time: f64) -> Self {
        Self { step, time, positions: cloth.positions().to_vec(), velocities: cloth.velocities().to_vec() }
    }
}

/// Watches a cloth for stretches of steps without motion.
pub struct Stillness<'a> {
    sample: &'a Sample,
    scene: &'a Scene,
    free: Vec<u32>,
    before: Before,
}

impl<'a> Stillness<'a> {
    /// From the start of a run.
    pub fn new(sample: &'a Sample, scene: &'a Scene, cloth: &Cloth) -> Self {
        Self { sample, scene, free: scene.free(), before: Before::of(cloth, 0, 0.0) }
    }

    /// Whether the cloth, after so many steps and so much time (s), has been frozen of late.
    pub fn is_frozen(&mut self, cloth: &Cloth, steps: u32, time: f64) -> bool {
        if steps - self.before.step < WINDOW {
            return false;
        }
        let before = core::mem::replace(&mut self.before, Before::of(cloth, steps, time));
        let moved = self.moved(cloth, &before);
        let seconds = time - before.time;
        // A tenth of what it would fall, or a thousandth of its size, which a cloth at rest may well stay within.
        let little = (0.05 * cloth.gravity().length() * seconds * seconds).min(1e-3 * SIZE);
        // At rest the solver leaves accelerations of its tolerance, which in long steps would go far.
        let at_rest = (0.5 * TOLERANCE * seconds * seconds).min(0.1 * SIZE);
        moved < little && self.reference(&before, steps) > little.max(at_rest).max(RATIO * moved)
    }

    /// Root mean square over the free vertices, m.
    fn moved(&self, cloth: &Cloth, before: &Before) -> f64 {
        let squares =
            self.free.iter().map(|&v| cloth.positions()[v as usize].distance_squared(before.positions[v as usize]));
        (squares.sum::<f64>() / self.free.len() as f64).sqrt()
    }

    /// How far the reference moves from there, in the same steps, m: f64, factorised, in shorter steps.
    fn reference(&self, before: &Before, steps: u32) -> f64 {
        let mut cloth = self.scene.cloth(self.sample);
        let integrator = Integrator::BackwardEuler;
        cloth.set_settings(SolverSettings { integrator, substeps: SUBSTEPS, ..SolverSettings::reference() });
        cloth.set_state(&before.positions, &before.velocities);
        let mut time = before.time;
        for step in before.step..steps {
            let dt = self.sample.dt_of(step);
            time += dt;
            self.scene.move_pins(&mut cloth, step, time);
            cloth.step(dt);
        }
        self.moved(&cloth, before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::sample::{Held, Start};

    #[test]
    fn a_cloth_that_hangs_is_at_rest_and_one_that_hovers_is_frozen() {
        let sample = Sample { held: Held::Edge, air_drag: 10.0, ..Sample::plain(Start::Rest, 0.05, 500.0, true, 1) };
        let scene = Scene::new(&sample);
        let mut cloth = scene.cloth(&sample);
        let mut hovering = Stillness::new(&sample, &scene, &cloth);
        // The cloth takes no step at all.
        assert!(!hovering.is_frozen(&cloth, WINDOW - 1, 0.05 * f64::from(WINDOW - 1)));
        assert!(hovering.is_frozen(&cloth, WINDOW, 0.05 * f64::from(WINDOW)));
        for _ in 0..600 {
            cloth.step(0.05);
        }
        let mut hanging = Stillness::new(&sample, &scene, &cloth);
        for _ in 0..WINDOW {
            cloth.step(0.05);
        }
        assert!(!hanging.is_frozen(&cloth, WINDOW, 0.05 * f64::from(WINDOW)));
    }
}
