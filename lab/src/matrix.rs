//! The linear system that a step of a cloth solves.

use bevy::math::DVec3;
use bevy_cloth::physics::Cloth;
use bevy_cloth::physics::assembly::{ImplicitStep, System, constrain};
use bevy_cloth::physics::math::{Lanes, V3};

use crate::scenes::DT;

/// A d = b of a backward Euler step of one frame from the state of a cloth, in single precision, its pins taken out.
pub struct StepSystem {
    /// A and b.
    pub system: System<Lanes<8>>,
    inertial: Vec<DVec3>,
}

impl StepSystem {
    /// Of a cloth as it stands.
    pub fn new(cloth: &Cloth) -> Self {
        let mut step = Self {
            system: System::new(cloth.shape(), cloth.fabric()),
            inertial: cloth.positions().iter().zip(cloth.velocities()).map(|(&x, &v)| x + DT * v).collect(),
        };
        step.assemble(cloth);
        let mut held = vec![false; cloth.masses().len()];
        for (vertex, _) in cloth.pinned() {
            held[vertex as usize] = true;
        }
        constrain(&mut step.system.matrix, &mut step.system.rhs, &held, |_| V3::zero());
        step
    }

    /// Fills A and b again for the same cloth in the same state, pinned vertices included.
    pub fn assemble(&mut self, cloth: &Cloth) {
        let step = ImplicitStep::backward_euler(cloth.positions(), &self.inertial, DT, cloth.gravity());
        self.system.assemble(&step, cloth.masses());
    }
}
