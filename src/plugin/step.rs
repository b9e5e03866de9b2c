//! Stepping every cloth.

use bevy::prelude::*;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use super::error::ClothError;
use super::state::ClothState;
use crate::physics::StepOutcome;

/// See [`ClothSystems::Step`](super::ClothSystems::Step). Large cloths are cut into parts inside the same thread pool.
pub(super) fn step(time: Res<Time>, mut cloths: Query<&mut ClothState>) {
    let dt = time.delta_secs_f64();
    let mut cloths: Vec<&mut ClothState> =
        cloths.iter_mut().filter(|state| !state.suspended).map(Mut::into_inner).collect();
    #[cfg(feature = "parallel")]
    cloths.par_iter_mut().for_each(|state| state.step(dt));
    #[cfg(not(feature = "parallel"))]
    cloths.iter_mut().for_each(|state| state.step(dt));
}

impl ClothState {
    fn step(&mut self, dt: f64) {
        self.previous_positions.clear();
        self.previous_positions.extend_from_slice(self.cloth.positions());
        let report = self.cloth.step(dt);
        self.faults.diverged = match &report.outcome {
            StepOutcome::Accepted => None,
            StepOutcome::Rejected(fault) => Some(ClothError::Diverged { reason: fault.to_string() }),
        };
        self.report = Some(report);
        self.stepped = true;
        self.revision += 1;
    }
}
