//! What the world says, handed to the physics before a step.

use bevy::math::DVec3;
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::budget::{Keeper, following};
use super::components::{ClothDisabled, ClothGravity, ClothPinTargets};
use super::contact::ClothContact;
use super::id::ClothId;
use super::inertia::ClothInertia;
use super::material::ClothMaterial;
use super::motion::{Place, Places};
use super::parts::ClothPart;
use super::pins::ClothPins;
use super::quality::{ClothDefaultQuality, ClothQuality, ClothSolver};
use super::state::ClothState;
use crate::physics::ContactSettings;

type Described<'a> = (
    Entity,
    &'a mut ClothState,
    Option<&'a ClothId>,
    Option<&'a ClothMaterial>,
    Option<&'a ClothSolver>,
    Option<&'a ClothQuality>,
    Option<&'a ClothContact>,
    Option<Ref<'a, ClothPins>>,
    Option<&'a ClothPinTargets>,
    Option<&'a ClothInertia>,
    Has<ClothDisabled>,
    &'a GlobalTransform,
);

/// See [`ClothSystems::Collect`](super::ClothSystems::Collect).
pub(super) fn collect(
    gravity: Res<ClothGravity>,
    default_quality: Res<ClothDefaultQuality>,
    meshes: Res<Assets<Mesh>>,
    time: Res<Time>,
    mut places: Places,
    mut keeper: ResMut<Keeper>,
    mut cloths: Query<Described>,
) {
    let start = Instant::now();
    let dt = time.delta_secs_f64();
    for (entity, mut state, id, material, solver, quality, contact, pins, targets, inertia, disabled, propagated) in
        &mut cloths
    {
        let state = &mut *state;
        state.collect_solver(solver, *quality.unwrap_or(&default_quality.0));
        state.collect_pace(keeper.tick, id.copied().unwrap_or(ClothId(0)));
        state.collect_material(material, gravity.as_dvec3());
        state.collect_contact(contact);
        state.collect_pin_rules(pins, &meshes);
        state.collect_inertia(inertia);
        if disabled {
            state.suspended = true;
            continue;
        }
        // The transform at the time of the tick, not as it was propagated in the last frame. A hierarchy with a hole in it has no other.
        let place = places.of(entity).unwrap_or(Place::only(*propagated));
        state.follow(&place, dt);
        if !state.suspended && state.pace.is_due() {
            state.breathe();
            state.place_pins(targets, places.times(), state.pace.pending + dt);
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

    /// Levels that take fewer steps than there are ticks take turns. With a budget, that says when. Each cloth counts its ticks
    /// for itself, from the number of its first one on, as it may be put back in time.
    fn collect_pace(&mut self, tick: u32, id: ClothId) {
        let tick = self.ticks.unwrap_or(tick);
        self.ticks = Some(tick.wrapping_add(1));
        if self.share.rung.is_none() && self.pace.is_due() {
            let interval = self.quality.map_or(1, ClothQuality::interval);
            self.pace.following = following(tick, interval, id.phase(interval), self.pace.span);
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
        // Rules speak of the source. Where that was unloaded, the own copy has every attribute that it had.
        let readable = |mesh: &&Mesh| mesh.try_attributes().is_ok();
        let of_part = |part: &ClothPart| {
            let source = meshes.get(&part.source).filter(readable);
            Some((source.or_else(|| meshes.get(&part.own))?, part.range().len()))
        };
        let Some(parts) = self.binding.parts.iter().map(of_part).collect::<Option<Vec<_>>>() else { return };
        let resolved = match rules {
            Some(rules) => rules.resolve(&parts, &self.binding.mesh.positions, &self.binding.shading.rest_normals),
            None => Ok(Vec::new()),
        };
        self.pins_changed = changed;
        self.faults.pins = resolved.map(|pins| self.pins = pins).err();
    }

    /// Keeps the limits there are if the new ones are wrong.
    fn collect_inertia(&mut self, inertia: Option<&ClothInertia>) {
        self.faults.inertia = None;
        match inertia.copied().unwrap_or_default().limits() {
            Ok(limits) => self.limits = limits,
            Err(error) => self.faults.inertia = Some(error),
        }
    }
}
