//! How a cloth follows its entity: what is held goes along, what jumped is carried.

use bevy::math::{DAffine3, DVec3};
use bevy::prelude::*;

use super::components::ClothPinTargets;
use super::error::ClothError;
use super::geometry::extent;
use super::motion::{Carry, Felt, Glides, Motion, Motions, Place, TargetWays};
use super::state::{ClothState, same_scale, usable};

/// Speed at which a vertex that has just come to be held is taken to its place within a tick at most, m/s. Beyond it glides.
const CAUGHT: f64 = 1.8;

/// What a cloth knows of the motion of its entity.
#[derive(Default)]
pub(super) struct Follower {
    /// What it feels of the motion.
    pub felt: Felt,
    /// What it was carried by since the last step.
    pub carried: Carried,
    /// Held vertices on their way to where they are held.
    pub glides: Glides,
    /// Where [`ClothPinTargets`] were.
    pub targets: TargetWays,
    /// Held vertices and their places in the space of the entity, rising, in this step and the one before.
    held: Vec<(u32, DVec3)>,
    held_before: Vec<(u32, DVec3)>,
}

/// What a [`Follower`] must know of the past to go on from there.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Following {
    felt: Felt,
    carried: Carried,
    glides: Glides,
    held: Vec<(u32, DVec3)>,
}

impl Follower {
    /// What it knows of the past.
    pub fn following(&self) -> Following {
        let Self { felt, carried, glides, held, .. } = self;
        Following { felt: *felt, carried: *carried, glides: glides.clone(), held: held.clone() }
    }

    /// Goes on from what was known.
    pub fn go_on(&mut self, Following { felt, carried, glides, held }: &Following) {
        (self.felt, self.carried, self.glides) = (*felt, *carried, glides.clone());
        self.held.clone_from(held);
        self.targets.clear();
    }

    /// Forgets all motion: the cloth was put to rest.
    pub fn rest(&mut self) {
        *self = Self { targets: core::mem::take(&mut self.targets), ..Self::default() };
    }
}

/// A rigid motion that a cloth did not feel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Carried {
    pub map: DAffine3,
    /// Whether some of it was a jump.
    pub jumped: bool,
}

impl Default for Carried {
    fn default() -> Self {
        Self { map: DAffine3::IDENTITY, jumped: false }
    }
}

/// Before the fixed loop: takes note of where the last frame left what [`ClothPinTargets`] hold.
pub(super) fn note_targets(motions: Res<Motions>, mut cloths: Query<(&mut ClothState, &ClothPinTargets)>) {
    let Some((oldest, end)) = motions.times() else { return };
    for (mut state, targets) in &mut cloths {
        state.follower.targets.end_frame(targets, end, oldest);
    }
}

/// After the fixed loop: what its systems moved is not a frame's motion.
pub(super) fn note_targets_of_ticks(motions: Res<Motions>, mut cloths: Query<(&mut ClothState, &ClothPinTargets)>) {
    let Some((_, end)) = motions.times() else { return };
    for (mut state, targets) in &mut cloths {
        state.follower.targets.end_ticks(targets, end);
    }
}

impl ClothState {
    /// Takes over where the entity is in this tick of `dt`. Without a usable transform the cloth waits.
    pub(super) fn follow(&mut self, place: &Place, dt: f64) {
        let followed = usable(&place.now).and_then(|now| self.go_to(now, place.before, dt));
        self.suspended = followed.is_err();
        self.faults.transform = followed.err();
    }

    fn go_to(&mut self, now: DAffine3, before: Option<GlobalTransform>, dt: f64) -> Result<(), ClothError> {
        if !same_scale(self.binding.rest_linear, now.matrix3) {
            self.rescale_to(now)?;
        }
        let placed = core::mem::replace(&mut self.placed, false);
        if self.suspended || (placed && self.is_anchored()) {
            // It was carried along unseen, or put where its entity is drawn.
            self.carry_to(now);
            self.follower.felt = Felt::default();
            return Ok(());
        }
        if let Some(before) = before.and_then(|before| usable(&before).ok())
            && before != self.seen_anchor
            && same_scale(self.binding.rest_linear, before.matrix3)
        {
            let map = before * self.seen_anchor.inverse();
            self.carry(&Carry { map, jumped: true, ..Carry::NOTHING });
            self.seen_anchor = before;
        }
        self.feel(now, dt);
        self.seen_anchor = now;
        if self.pace.is_due() {
            self.previous_anchor = self.anchor;
            self.anchor = now;
        }
        Ok(())
    }

    /// Carries the cloth by what it does not feel of the way of its entity to `now`.
    fn feel(&mut self, now: DAffine3, dt: f64) {
        let before = self.seen_anchor;
        let anchored = self.is_anchored();
        let points = self.binding.corners(&self.pins).map(|p| before.transform_point3(p));
        let middle = 0.5 * (points[0] + points[7]);
        let motion = Motion::between(before, now, middle, dt);
        let felt = &mut self.follower.felt;
        let carry = if anchored {
            felt.feel(&motion, &points, &self.limits)
        } else if felt.jumps(&motion, &points, &self.limits) {
            // Nothing holds it: it follows its entity in jumps only.
            Carry { map: now * before.inverse(), jumped: true, ..Carry::NOTHING }
        } else {
            Carry::NOTHING
        };
        if carry != Carry::NOTHING {
            self.carry(&carry);
        }
        self.cloth.set_wind(-carry.unfelt);
    }

    /// Carries the cloth, with its history and what it shows, by a motion that it does not feel.
    fn carry(&mut self, carry: &Carry) {
        if carry.map != DAffine3::IDENTITY {
            self.cloth.carry(carry.map);
            for place in &mut self.previous_positions {
                *place = carry.map.transform_point3(*place);
            }
            self.anchor = carry.map * self.anchor;
            self.previous_anchor = carry.map * self.previous_anchor;
            let carried = &mut self.follower.carried;
            carried.map = carry.map * carried.map;
            carried.jumped |= carry.jumped;
            self.met.clear();
            self.revision += 1;
        }
        if carry.boost != DVec3::ZERO {
            self.cloth.boost(carry.boost);
        }
    }

    /// Tells the physics where held vertices are to be at the end of the step of `dt`. `times` are those of
    /// [`Motions::times`](super::motion::Motions::times).
    pub(super) fn place_pins(&mut self, targets: Option<&ClothPinTargets>, times: Option<(f64, f64)>, dt: f64) {
        self.collect_held(targets, times);
        self.begin_glides(dt);
        let Self { cloth, anchor, follower: Follower { held, glides, .. }, .. } = self;
        glides.retain(|vertex| held.binary_search_by_key(&vertex, |&(held, _)| held).is_ok());
        glides.advance(*anchor, dt);
        cloth.clear_pins();
        for &(vertex, local) in &*held {
            cloth.pin(vertex, anchor.transform_point3(local + glides.offset(vertex)));
        }
    }

    /// Lists the held vertices with their places in the space of the entity.
    fn collect_held(&mut self, targets: Option<&ClothPinTargets>, times: Option<(f64, f64)>) {
        let Self { cloth, binding, pins, follower, faults, .. } = self;
        let Follower { held, held_before, targets: ways, .. } = follower;
        core::mem::swap(held, held_before);
        held.clear();
        let simulated = &cloth.shape().simulated;
        held.extend(pins.iter().filter_map(|&vertex| {
            let simulated = simulated[vertex as usize]?;
            Some((simulated, binding.local(binding.representatives[simulated as usize])))
        }));
        faults.pin_targets = None;
        let targets = targets.filter(|targets| !targets.is_empty());
        if targets.is_none() {
            ways.clear();
        }
        for (&vertex, &place) in targets.iter().flat_map(|targets| &targets.0) {
            let count = binding.mesh.positions.len() as u32;
            if vertex >= count {
                faults.pin_targets = Some(ClothError::PinTargetIndex { vertex, count });
            } else if !place.is_finite() {
                faults.pin_targets = Some(ClothError::PinTargetNotFinite { vertex });
            } else if let Some(simulated) = simulated[vertex as usize] {
                held.push((simulated, ways.at(vertex, place, times)));
            }
        }
        // Targets come after rules, and the last of those that name one vertex counts.
        held.reverse();
        held.sort_by_key(|&(vertex, _)| vertex);
        held.dedup_by_key(|&mut (vertex, _)| vertex);
    }

    /// Lets what is held somewhere else than it is glide there.
    fn begin_glides(&mut self, dt: f64) {
        let Self { cloth, follower, anchor, previous_anchor, limits, .. } = self;
        let Follower { held, held_before, glides, .. } = follower;
        let far = |offset: DVec3, speed: f64| anchor.transform_vector3(offset).length() > speed * dt;
        let into = previous_anchor.inverse();
        let mut new = Vec::new();
        for &(vertex, local) in &*held {
            match held_before.binary_search_by_key(&vertex, |&(held, _)| held) {
                Ok(index) => {
                    let offset = held_before[index].1 - local;
                    if far(offset, limits.jump_speed) {
                        glides.begin(vertex, offset);
                    }
                }
                Err(_) => {
                    let offset = into.transform_point3(cloth.positions()[vertex as usize]) - local;
                    if far(offset, if limits.jump_speed.is_finite() { CAUGHT } else { f64::INFINITY }) {
                        new.push((vertex, offset));
                    }
                }
            }
        }
        if held_before.is_empty() && new.len() == held.len() && limits.jump_speed.is_finite() {
            self.put_near(&mut new);
        }
        for (vertex, offset) in new {
            self.follower.glides.begin(vertex, offset);
        }
    }

    /// Puts a cloth that was free, and is held further away than it is large, there as it is. Offsets are from where vertices are held
    /// to where they are, in the space of the entity.
    fn put_near(&mut self, offsets: &mut [(u32, DVec3)]) {
        let [low, high] = extent(self.cloth.positions().iter().copied());
        let mean = offsets.iter().map(|&(_, offset)| offset).sum::<DVec3>() / offsets.len().max(1) as f64;
        let way = self.anchor.transform_vector3(mean);
        if way.length() <= low.distance(high) {
            return;
        }
        let anchors = (self.anchor, self.previous_anchor);
        self.carry(&Carry { map: DAffine3::from_translation(-way), jumped: true, ..Carry::NOTHING });
        // The entity did not move.
        (self.anchor, self.previous_anchor) = anchors;
        offsets.iter_mut().for_each(|(_, offset)| *offset -= mean);
    }
}
