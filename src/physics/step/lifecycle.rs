//! What a cloth is told between steps.

use bevy::math::{DAffine3, DMat3, DVec3};

use super::plan::Impact;
use super::terms::longest_sides;
use super::{Engine, History, Pins, State, Step, Stepper};
use crate::physics::assembly::{ElasticEnergy, Ordering};
use crate::physics::cloth::{ClothFault, Earlier, Remembered, SolverSettings, StepReport, Turns};
use crate::physics::contact::Contact;
use crate::physics::material::Fabric;
use crate::physics::math::Scalar;
use crate::physics::mesh::RestShape;

/// Change of lengths by a map, relative and twice, up to which it is rigid: the energy stays what it was.
const RIGID: f64 = 1e-9;

impl<T: Scalar> Engine for Stepper<T> {
    fn pieces(&mut self, step: &Step) -> u32 {
        Stepper::pieces(self, step)
    }

    fn step(&mut self, step: &Step, report: &mut StepReport) -> Result<(), ClothFault> {
        Stepper::step(self, step, report)
    }

    fn advance(&mut self, state: &mut State) {
        core::mem::swap(state, &mut self.next);
        // `next` holds the state before this substep now: it is history.
        core::mem::swap(&mut self.next, &mut self.history.state);
    }

    fn energy(&self, positions: &[DVec3]) -> ElasticEnergy {
        self.terms.system.energy(positions)
    }

    fn set_fabric(&mut self, shape: &RestShape, fabric: &Fabric) {
        self.terms.system.set_fabric(shape, fabric);
        self.terms.contact.set_fabric(fabric);
        self.newton.damping = fabric.damping.into();
        self.account.stored = None;
    }

    fn measure(&mut self, shape: &RestShape, fabric: &Fabric, ordering: &Ordering) {
        self.terms.system.measure(shape, fabric, ordering);
        self.terms.contact.measure(longest_sides(shape, ordering));
        self.account.stored = None;
    }

    fn map(&mut self, map: DAffine3, state: &State, pins: &Pins) {
        let before = &mut self.history.state;
        let drifted = pins.mean(&state.positions) - pins.mean(&before.positions);
        let drift = pins.mean(&before.velocities);
        before.map_earlier(map, drifted, drift);
        if map.matrix3.determinant() < 0.0 {
            self.terms.system.mirror();
        }
        self.account.stored = None;
    }

    fn set_settings(&mut self, settings: &SolverSettings) {
        self.newton.settings = *settings;
    }

    fn contacts(&self, positions: &[DVec3]) -> Vec<Contact> {
        self.terms.contact.show(positions)
    }

    fn carry(&mut self, map: DAffine3, x: &[DVec3]) {
        self.history.state.map(map, DVec3::ZERO);
        let gram = map.matrix3.transpose() * map.matrix3;
        if !(gram.abs_diff_eq(DMat3::IDENTITY, RIGID) && map.matrix3.determinant() > 0.0) {
            self.settle(x);
        }
    }

    fn boost(&mut self, velocity: DVec3) {
        let History { state, dt, .. } = &mut self.history;
        state.velocities.iter_mut().for_each(|v| *v += velocity);
        let way = velocity * dt.unwrap_or(0.0);
        state.positions.iter_mut().for_each(|x| *x -= way);
    }

    fn restart(&mut self) {
        self.terms.contact.forget();
        self.impact = Impact::NONE;
        self.history.dt = None;
        self.account.surplus = 0.0;
        self.account.stored = None;
    }

    fn settle(&mut self, x: &[DVec3]) {
        self.terms.system.settle(x);
        self.account.stored = None;
    }

    fn remembered(&self, ordering: &Ordering) -> Remembered {
        let History { state, dt, changed } = &self.history;
        let earlier = dt.map(|dt| Earlier {
            dt,
            positions: ordering.inner.iter().map(|&v| state.positions[v as usize]).collect(),
            velocities: ordering.inner.iter().map(|&v| state.velocities[v as usize]).collect(),
        });
        Remembered {
            earlier,
            changed: *changed,
            energy_now: self.account.stored,
            surplus: self.account.surplus,
            impact: self.impact,
            touches: self.terms.contact.memories().into(),
            held: (0..).zip(self.terms.system.held()).filter(|(_, held)| **held).map(|(vertex, _)| vertex).collect(),
            turns: Turns::new(&self.terms.system.turns()),
        }
    }

    fn turn_count(&self) -> usize {
        self.terms.system.turns().len()
    }

    fn remember(&mut self, remembered: &Remembered, ordering: &Ordering) {
        let mut held = vec![false; ordering.outer.len()];
        remembered.held.iter().for_each(|&vertex| held[vertex as usize] = true);
        self.terms.system.hold(&held);
        self.terms.system.set_turns(&remembered.turns.to::<T>());
        self.terms.contact.forget();
        self.terms.contact.recall_all(&remembered.touches);
        let state = &mut self.history.state;
        if let Some(Earlier { positions, velocities, .. }) = &remembered.earlier {
            for (inner, &outer) in ordering.outer.iter().enumerate() {
                state.positions[inner] = positions[outer as usize];
                state.velocities[inner] = velocities[outer as usize];
            }
        }
        self.history.dt = remembered.earlier.as_ref().map(|earlier| earlier.dt);
        self.history.changed = remembered.changed;
        self.account.stored = remembered.energy_now;
        self.account.surplus = remembered.surplus;
        self.impact = remembered.impact;
    }
}
