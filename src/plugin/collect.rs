//! What the world says, handed to the physics before a step.

use bevy::math::{DAffine3, DVec3};
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::budget::{Keeper, following};
use super::components::{ClothDisabled, ClothGravity, ClothMesh, ClothPinTargets};
use super::contact::ClothContact;
use super::error::ClothError;
use super::material::ClothMaterial;
use super::pins::ClothPins;
use super::quality::{ClothDefaultQuality, ClothQuality, ClothSolver};
use super::state::{ClothState, representatives, rest_shape, same_scale, usable};
use crate::physics::{Cloth, ContactSettings};

type Described<'a> = (
    Entity,
    &'a mut ClothState,
    &'a ClothMesh,
    Option<&'a ClothMaterial>,
    Option<&'a ClothSolver>,
    Option<&'a ClothQuality>,
    Option<&'a ClothContact>,
    Option<Ref<'a, ClothPins>>,
    Option<&'a ClothPinTargets>,
    Has<ClothDisabled>,
    &'a GlobalTransform,
);

/// See [`ClothSystems::Collect`](super::ClothSystems::Collect).
pub(super) fn collect(
    gravity: Res<ClothGravity>,
    default_quality: Res<ClothDefaultQuality>,
    meshes: Res<Assets<Mesh>>,
    transforms: TransformHelper,
    mut keeper: ResMut<Keeper>,
    mut cloths: Query<Described>,
) {
    let start = Instant::now();
    for (entity, mut state, cloth_mesh, material, solver, quality, contact, pins, targets, disabled, propagated) in
        &mut cloths
    {
        let state = &mut *state;
        state.collect_solver(solver, *quality.unwrap_or(&default_quality.0));
        state.collect_pace(keeper.tick, entity.index_u32());
        state.collect_material(material, gravity.as_dvec3());
        state.collect_contact(contact);
        state.collect_pin_rules(pins, &meshes);
        if disabled {
            state.suspended = true;
            continue;
        }
        // The transform as it is now, not as it was propagated in the last frame. A hierarchy with a hole in it has no other.
        let transform = transforms.compute_global_transform(entity).unwrap_or(*propagated);
        state.collect_transform(&transform, cloth_mesh.teleport_distance.into());
        if !state.suspended && state.pace.is_due() {
            state.place_pins(targets);
        }
    }
    keeper.tick = keeper.tick.wrapping_add(1);
    keeper.spent.collect += start.elapsed();
}

impl ClothState {
    /// Settings given one by one come before a level of quality.
    fn collect_solver(&mut self, solver: Option<&ClothSolver>, asked: ClothQuality) {
        let quality = self.share.rung.map_or(asked, |rung| asked.min(rung.quality()));
        self.quality = solver.is_none().then_some(quality);
        let settings = solver.map_or_else(|| quality.settings(), |solver| solver.0);
        if settings != *self.cloth.settings() || self.faults.solver.is_some() {
            self.faults.solver = settings.validate().err().map(Into::into);
            if self.faults.solver.is_none() {
                self.cloth.set_settings(settings);
            }
        }
    }

    /// Levels that take fewer steps than there are ticks take turns. With a budget, that says when.
    fn collect_pace(&mut self, tick: u32, number: u32) {
        if self.share.rung.is_none() && self.pace.is_due() {
            let interval = self.quality.map_or(1, ClothQuality::interval);
            self.pace.following = following(tick, interval, number % interval, self.pace.span);
        }
    }

    fn collect_material(&mut self, material: Option<&ClothMaterial>, gravity: DVec3) {
        if let Some(material) = material
            && (material.0 != *self.cloth.fabric() || self.faults.material.is_some())
        {
            self.faults.material = self.cloth.set_fabric(material.0).err().map(Into::into);
        }
        if gravity != self.cloth.gravity() {
            self.cloth.set_gravity(gravity);
        }
    }

    fn collect_contact(&mut self, contact: Option<&ClothContact>) {
        let settings = contact.map_or_else(ContactSettings::default, |&contact| contact.into());
        if settings != self.cloth.contact_settings() || self.faults.contact.is_some() {
            self.faults.contact = self.cloth.set_contact_settings(settings).err().map(Into::into);
        }
    }

    /// Evaluates the rules when they changed; keeps the pins there are if they are wrong.
    fn collect_pin_rules(&mut self, rules: Option<Ref<ClothPins>>, meshes: &Assets<Mesh>) {
        let changed = rules.as_ref().map(Ref::last_changed);
        if changed == self.pins_changed {
            return;
        }
        // The own copy has every attribute that the source had, and cannot be unloaded.
        let Some(mesh) = meshes.get(&self.binding.own) else { return };
        let resolved = match rules {
            Some(rules) => rules.resolve(mesh, &self.binding.mesh.positions, &self.binding.shading.rest_normals),
            None => Ok(Vec::new()),
        };
        self.pins_changed = changed;
        self.faults.pins = resolved.map(|pins| self.pins = pins).err();
    }

    /// Takes over the transform of the entity: followed by the pins, or carried to at once after a jump. Without a usable
    /// one the cloth waits.
    fn collect_transform(&mut self, transform: &GlobalTransform, teleport_distance: f64) {
        let followed = usable(transform).and_then(|anchor| {
            let centre = self.binding.centre;
            let moved = anchor.transform_point3(centre).distance(self.seen_anchor.transform_point3(centre));
            self.seen_anchor = anchor;
            if !same_scale(self.binding.rest_linear, anchor.matrix3) {
                return self.rescale_to(anchor);
            }
            if self.suspended || moved > teleport_distance {
                self.carry_to(anchor);
            } else if self.pace.is_due() {
                self.previous_anchor = self.anchor;
                self.anchor = anchor;
            }
            Ok(())
        });
        self.suspended = followed.is_err();
        self.faults.transform = followed.err();
    }

    /// Measures the rest shape again under a transform of another scale, and keeps the deformation.
    fn rescale_to(&mut self, anchor: DAffine3) -> Result<(), ClothError> {
        let Self { cloth: old, binding, .. } = self;
        let shape = rest_shape(&binding.mesh, anchor.matrix3, &binding.options)?;
        let representatives = representatives(&shape);
        let same_vertices = shape.simulated == old.shape().simulated;
        let mut cloth = Cloth::new(shape, *old.fabric(), *old.settings())?;
        cloth.set_gravity(old.gravity());
        cloth.set_contact_settings(old.contact_settings())?;
        if same_vertices {
            cloth.set_state(old.positions(), old.velocities());
        }
        self.cloth = cloth;
        binding.representatives = representatives;
        binding.rest_linear = anchor.matrix3;
        if same_vertices {
            self.carry_to(anchor);
        } else {
            // An absolute weld distance joins other vertices at another scale.
            self.rest_at(anchor);
        }
        Ok(())
    }

    /// Tells the physics where held vertices are to be at the end of the step.
    fn place_pins(&mut self, targets: Option<&ClothPinTargets>) {
        let Self { cloth, binding, pins, anchor, .. } = self;
        cloth.clear_pins();
        for &vertex in &*pins {
            if let Some(simulated) = cloth.shape().simulated[vertex as usize] {
                let local = binding.local(binding.representatives[simulated as usize]);
                cloth.pin(simulated, anchor.transform_point3(local));
            }
        }
        self.faults.pin_targets = None;
        for (&vertex, place) in targets.iter().flat_map(|targets| &targets.0) {
            let count = binding.mesh.positions.len() as u32;
            if vertex >= count {
                self.faults.pin_targets = Some(ClothError::PinTargetIndex { vertex, count });
            } else if !place.is_finite() {
                self.faults.pin_targets = Some(ClothError::PinTargetNotFinite { vertex });
            } else if let Some(simulated) = cloth.shape().simulated[vertex as usize] {
                cloth.pin(simulated, anchor.transform_point3(place.as_dvec3()));
            }
        }
    }
}
