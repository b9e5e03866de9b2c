//! Stepping every cloth.

use bevy::platform::time::Instant;
use bevy::prelude::*;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use super::budget::Keeper;
use super::error::ClothError;
use super::follow::Carried;
use super::state::ClothState;
use crate::physics::StepOutcome;

/// See [`ClothSystems::Step`](super::ClothSystems::Step). Large cloths are cut into parts inside the same thread pool.
pub(super) fn step(time: Res<Time>, mut keeper: ResMut<Keeper>, mut cloths: Query<&mut ClothState>) {
    let start = Instant::now();
    let dt = time.delta_secs_f64();
    let mut cloths: Vec<&mut ClothState> =
        cloths.iter_mut().filter(|state| !state.suspended).map(Mut::into_inner).collect();
    #[cfg(feature = "parallel")]
    cloths.par_iter_mut().for_each(|state| state.tick(dt));
    #[cfg(not(feature = "parallel"))]
    cloths.iter_mut().for_each(|state| state.tick(dt));
    keeper.spent.step += start.elapsed();
}

impl ClothState {
    fn tick(&mut self, dt: f64) {
        if let Some(dt) = self.pace.tick(dt) {
            self.step(dt);
        }
    }

    fn step(&mut self, dt: f64) {
        self.previous_positions.clear();
        self.previous_positions.extend_from_slice(self.cloth.positions());
        self.step_length = dt;
        let report = self.cloth.step(dt);
        self.faults.diverged = match &report.outcome {
            StepOutcome::Accepted => None,
            StepOutcome::Rejected(fault) => Some(ClothError::Diverged { reason: fault.to_string() }),
        };
        self.report = Some(report);
        self.stepped = true;
        self.follower.carried = Carried::default();
        self.revision += 1;
    }
}
