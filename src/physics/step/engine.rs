//! What advances a cloth, in either precision.

use bevy::math::{DAffine3, DVec3};

use super::{Pins, State, Step, Stepper};
use crate::physics::assembly::{ElasticEnergy, Ordering};
use crate::physics::cloth::{ClothFault, Precision, Remembered, SolverSettings, StepReport};
use crate::physics::contact::Contact;
use crate::physics::material::Fabric;
use crate::physics::mesh::RestShape;

/// The part of a cloth that depends on the precision.
pub(in crate::physics) trait Engine: Send + Sync {
    /// Substeps that a step should be taken in, as fast as things come in.
    fn pieces(&mut self, step: &Step) -> u32;
    /// Takes a substep.
    fn step(&mut self, step: &Step, report: &mut StepReport) -> Result<(), ClothFault>;
    /// Advances `state` to where the last substep led, and remembers it as earlier.
    fn advance(&mut self, state: &mut State);
    /// Elastic energy at these positions.
    fn energy(&self, positions: &[DVec3]) -> ElasticEnergy;
    /// Changes the material.
    fn set_fabric(&mut self, shape: &RestShape, fabric: &Fabric);
    /// Takes over a shape of the same elements that measure otherwise.
    fn measure(&mut self, shape: &RestShape, fabric: &Fabric, ordering: &Ordering);
    /// Carries what is remembered of earlier states along with the present one, before that is mapped.
    fn map(&mut self, map: DAffine3, state: &State, pins: &Pins);
    /// Changes settings that [`SolverSettings::same_engine`] allows.
    fn set_settings(&mut self, settings: &SolverSettings);
    /// Contacts of the last step, which led to these positions, with vertices as the engine numbers them.
    fn contacts(&self, positions: &[DVec3]) -> Vec<Contact>;
    /// Maps earlier states as the present one was, which is now at `x`.
    fn carry(&mut self, map: DAffine3, x: &[DVec3]);
    /// Changes the velocities of earlier states as those of the present one were.
    fn boost(&mut self, velocity: DVec3);
    /// Forgets earlier states: the present one was put there from outside.
    fn restart(&mut self);
    /// Says that the cloth is at `x` now, whatever was before.
    fn settle(&mut self, x: &[DVec3]);
    /// What the next step depends on beside the state, with vertices in the order of the shape.
    fn remembered(&self, ordering: &Ordering) -> Remembered;
    /// How many turns of mid-edge normals are remembered.
    fn turn_count(&self) -> usize;
    /// Puts back what was remembered by an engine of the same cloth.
    fn remember(&mut self, remembered: &Remembered, ordering: &Ordering);
}

/// The engine of these settings. Its vertices are numbered as `ordering` says.
pub(in crate::physics) fn new(
    shape: &RestShape,
    fabric: &Fabric,
    settings: &SolverSettings,
    ordering: &Ordering,
) -> Box<dyn Engine> {
    match settings.precision {
        Precision::Single => Box::new(Stepper::<f32>::new(shape, fabric, settings, ordering)),
        Precision::Double => Box::new(Stepper::<f64>::new(shape, fabric, settings, ordering)),
    }
}
