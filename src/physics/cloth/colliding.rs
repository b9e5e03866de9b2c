//! What a cloth may touch, and what it did.

use super::Cloth;
use crate::physics::contact::{Collider, ColliderError, Contact, ContactSettings, ContactSettingsError, merged};

impl Cloth {
    /// Sets all colliders that the cloth may touch in the next step, each with its way through it. In the steps after that they stand
    /// still where they ended, until they are set again.
    ///
    /// # Errors
    /// If one of them does not pass [`Collider::validate`]: those that do are set, the first error is told.
    pub fn set_colliders(&mut self, colliders: impl IntoIterator<Item = Collider>) -> Result<(), ColliderError> {
        let mut told = Ok(());
        self.colliders.clear();
        self.colliders.extend(colliders.into_iter().filter(|collider| {
            let valid = collider.validate();
            let is_valid = valid.is_ok();
            if told.is_ok() {
                told = valid;
            }
            is_valid
        }));
        told
    }

    /// The colliders, as they will be in the next step.
    pub fn colliders(&self) -> &[Collider] {
        &self.colliders
    }

    /// How the cloth meets colliders.
    pub fn contact_settings(&self) -> ContactSettings {
        self.contact_settings
    }

    /// Changes how the cloth meets colliders.
    ///
    /// # Errors
    /// If the settings do not pass [`ContactSettings::validate`]: the old ones then stay.
    pub fn set_contact_settings(&mut self, settings: ContactSettings) -> Result<(), ContactSettingsError> {
        settings.validate()?;
        self.contact_settings = settings;
        Ok(())
    }

    /// Where the cloth touched colliders in the last step. Forces are means over the step: times its length they are impulses.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> {
        let last =
            self.engine.contacts(&self.state.positions).into_iter().map(|contact| contact.scaled(self.last_share));
        merged(last.chain(self.earlier_contacts.iter().copied())).into_iter().map(|contact| Contact {
            vertices: contact.vertices.map(|vertex| self.ordering.outer[vertex as usize]),
            ..contact
        })
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{DAffine3, DVec3};
    use parry3d::shape::SharedShape;

    use super::*;
    use crate::physics::assembly::{ElasticEnergy, Ordering};
    use crate::physics::cloth::snapshot::Remembered;
    use crate::physics::cloth::{ClothFault, SolverSettings, StepOutcome, StepReport};
    use crate::physics::contact::Pose;
    use crate::physics::material::Fabric;
    use crate::physics::mesh::{RestShape, RestShapeOptions, SurfaceMesh};
    use crate::physics::step::{self, Engine, Pins, State, Step};

    /// Moves everything by 1 m in each substep, and fails in one. For the rest it is as another.
    struct Failing {
        inner: Box<dyn Engine>,
        at: u32,
        done: u32,
    }

    impl Engine for Failing {
        fn pieces(&mut self, _: &Step) -> u32 {
            4
        }

        fn step(&mut self, _: &Step, _: &mut StepReport) -> Result<(), ClothFault> {
            self.done += 1;
            if self.done == self.at { Err(ClothFault::NotFinite) } else { Ok(()) }
        }

        fn advance(&mut self, state: &mut State) {
            state.positions.iter_mut().for_each(|x| x.y -= 1.0);
        }

        fn energy(&self, _: &[DVec3]) -> ElasticEnergy {
            ElasticEnergy::default()
        }

        fn set_fabric(&mut self, _: &RestShape, _: &Fabric) {}

        fn measure(&mut self, _: &RestShape, _: &Fabric, _: &Ordering) {}

        fn map(&mut self, _: DAffine3, _: &State, _: &Pins) {}

        fn carry(&mut self, _: DAffine3, _: &[DVec3]) {}

        fn boost(&mut self, _: DVec3) {}

        fn remembered(&self, ordering: &Ordering) -> Remembered {
            self.inner.remembered(ordering)
        }

        fn turn_count(&self) -> usize {
            self.inner.turn_count()
        }

        fn remember(&mut self, remembered: &Remembered, ordering: &Ordering) {
            self.inner.remember(remembered, ordering);
        }

        fn set_settings(&mut self, _: &SolverSettings) {}

        fn contacts(&self, positions: &[DVec3]) -> Vec<Contact> {
            let (vertices, weights) = ([0; 3], [1.0, 0.0, 0.0]);
            let point = positions[0];
            vec![Contact { vertices, weights, collider: 1, point, normal: DVec3::Y, force: DVec3::Y }]
        }

        fn restart(&mut self) {}

        fn settle(&mut self, _: &[DVec3]) {}
    }

    #[test]
    fn a_step_that_fails_late_leaves_the_cloth_where_it_was() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Z];
        let mesh = SurfaceMesh { positions: &positions, triangles: &[[0, 2, 1]], uvs: None };
        let shape = RestShape::new(&mesh, &RestShapeOptions::default()).unwrap();
        let mut cloth = Cloth::new(shape, Fabric::cotton(), SolverSettings::default()).unwrap();
        let before = cloth.positions().to_vec();
        let end = Pose::at(DVec3::Y);
        let ball = Collider { end, ..Collider::fixed(1, SharedShape::ball(0.1), Pose::IDENTITY, 0.5) };
        cloth.set_colliders([ball]).unwrap();
        let failing = |cloth: &Cloth, at| {
            let inner = step::new(&cloth.shape, &cloth.fabric, &cloth.settings, &cloth.ordering);
            Box::new(Failing { inner, at, done: 0 })
        };
        cloth.engine = failing(&cloth, 3);
        let report = cloth.step(1.0 / 60.0);
        assert_eq!(report.outcome, StepOutcome::Rejected(ClothFault::NotFinite));
        assert_eq!((cloth.positions(), cloth.colliders()[0].start), (&before[..], end));
        assert!(cloth.velocities().iter().all(|v| *v == DVec3::ZERO) && cloth.earlier_contacts.is_empty());
        cloth.engine = failing(&cloth, 9);
        assert_eq!(cloth.step(1.0 / 60.0).outcome, StepOutcome::Accepted);
        assert_eq!(cloth.positions()[0].y, before[0].y - 4.0);
    }
}
