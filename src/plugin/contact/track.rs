//! Where a collider was in the last ticks.

use std::collections::VecDeque;

use bevy::math::DAffine3;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use parry3d::shape::SharedShape;

use super::bounds::Bounds;
use super::collider::ClothCollider;
use super::error::{ClothColliderError, report};
use super::give::Surroundings;
use super::layers::ClothLayers;
use super::shear::{Sheared, Size};
use crate::physics::Pose;
use crate::plugin::budget::Keeper;
use crate::plugin::motion::{Place, Places};
use crate::plugin::state::usable;

/// Ticks that a collider is drawn ahead of what a tick sees at most: a frame of 1/15 s at 64 Hz and the ticks around it.
const DRAWN_AHEAD: f64 = 8.0;

/// Ticks back that poses are kept: cloth takes steps of twelve ticks at most.
const MEMORY: usize = 16;

/// The scaled shape of a [`ClothCollider`], and its way through the last ticks.
#[derive(Component, Default)]
pub(in crate::plugin) struct Track {
    /// `None` while the collider cannot be used.
    sized: Option<Scaled>,
    /// The present one first.
    moments: VecDeque<Moment>,
    /// Ticks since it last moved.
    still: usize,
    /// Around all moments.
    reach: Option<Bounds>,
}

struct Scaled {
    shape: SharedShape,
    size: Size,
    /// Around the shape, in its own frame.
    bounds: Bounds,
}

struct Moment {
    pose: Pose,
    /// Around the shape on its way to here from the moment before.
    bounds: Bounds,
}

type Followed<'a> = (
    NameOrEntity,
    Ref<'a, ClothCollider>,
    &'a mut Track,
    Option<&'a ClothLayers>,
    Option<&'a ClothColliderError>,
    &'a GlobalTransform,
);

/// Follows every collider, and notes which may be near a cloth.
pub(in crate::plugin) fn track(
    mut commands: Commands,
    mut places: Places,
    mut surroundings: ResMut<Surroundings>,
    mut keeper: ResMut<Keeper>,
    mut colliders: Query<Followed>,
    time: Res<Time>,
) {
    let start = Instant::now();
    let dt = time.delta_secs_f64();
    surroundings.clear();
    for (name, collider, mut track, layers, shown, propagated) in &mut colliders {
        // As it is at the time of the tick, not as it was propagated in the last frame. A hierarchy with a hole in it has no other.
        let place = places.of(name.entity).unwrap_or(Place::only(*propagated));
        if place.teleported {
            track.moments.clear();
        }
        let followed = track.follow(&collider, &place.now, dt);
        if followed.is_err() {
            *track = Track::default();
        }
        if let Some(reach) = track.reach {
            surroundings.add(name.entity, layers.copied().unwrap_or_default(), reach.grown(track.lead()));
        }
        report(&mut commands, &name, shown, followed.err());
    }
    keeper.spent.collect += start.elapsed();
}

impl Track {
    /// The shape, scaled, where it is now; `None` while the collider cannot be used.
    pub fn present(&self) -> Option<(&SharedShape, Pose)> {
        Some((&self.sized.as_ref()?.shape, self.moments.front()?.pose))
    }

    /// Where it was so many ticks ago, or in the first tick that it is known in.
    pub(super) fn pose_before(&self, ticks: u32) -> Option<Pose> {
        Some(self.moments.get(ticks as usize).or(self.moments.back())?.pose)
    }

    /// How far it may be drawn from where it is in this tick, m.
    pub(super) fn lead(&self) -> f64 {
        let (Some(sized), Some(now), Some(before)) = (&self.sized, self.moments.front(), self.moments.get(1)) else {
            return 0.0;
        };
        if now.pose == before.pose {
            return 0.0;
        }
        let radius = sized.bounds.min.abs().max(sized.bounds.max.abs()).length();
        let turned = now.pose.rotation.angle_between(before.pose.rotation);
        let turned = if turned > 0.0 { turned * radius } else { 0.0 };
        DRAWN_AHEAD * (now.pose.translation.distance(before.pose.translation) + turned)
    }

    /// Around the shape, in its own frame.
    pub(super) fn bounds(&self) -> Option<Bounds> {
        Some(self.sized.as_ref()?.bounds)
    }

    /// Forgets its way: it stands here.
    pub fn stand(&mut self, transform: &GlobalTransform) {
        let (Some(sized), Ok(affine)) = (&self.sized, usable(transform)) else { return };
        let (pose, _) = placed(&affine);
        let bounds = sized.bounds.at(&pose);
        (self.still, self.reach) = (0, Some(bounds));
        self.moments.clear();
        self.moments.push_front(Moment { pose, bounds });
    }

    fn follow(
        &mut self,
        collider: &Ref<ClothCollider>,
        transform: &GlobalTransform,
        dt: f64,
    ) -> Result<(), ClothColliderError> {
        collider.validate()?;
        let affine = usable(transform).map_err(|_| ClothColliderError::Transform)?;
        let (pose, size) = placed(&affine);
        let resized = self.resize(collider, size)?;
        self.move_to(pose, f64::from(collider.teleport_speed) * dt, resized);
        Ok(())
    }

    /// Takes over another shape or size; says whether it was another.
    fn resize(&mut self, collider: &Ref<ClothCollider>, size: Size) -> Result<bool, ClothColliderError> {
        let same = |old: &Scaled| old.size.is_about(&size);
        if !collider.is_changed() && self.sized.as_ref().is_some_and(same) {
            return Ok(false);
        }
        let shape = collider.shape();
        // What is not finite cannot be scaled either.
        let bounds =
            |shape: &SharedShape| Bounds::of_shape(&shape.compute_local_aabb()).ok_or(ClothColliderError::Shape);
        bounds(shape)?;
        let shape = size.of(shape)?;
        let bounds = bounds(&shape)?;
        self.sized = Some(Scaled { shape, size, bounds });
        for moment in &mut self.moments {
            moment.bounds = bounds.at(&moment.pose);
        }
        Ok(true)
    }

    /// Takes note of a pose, which it has jumped to if that is further away than `farthest`.
    fn move_to(&mut self, pose: Pose, farthest: f64, resized: bool) {
        let Some(sized) = &self.sized else { return };
        let before = self.moments.front().map(|moment| moment.pose);
        let jumped = |before: &Pose| before.translation.distance(pose.translation) > farthest;
        if before.as_ref().is_some_and(jumped) {
            self.moments.clear();
        }
        let known = !self.moments.is_empty();
        let before = self.moments.front().map_or(pose, |moment| moment.pose);
        self.still = if known && before == pose && !resized { self.still + 1 } else { 0 };
        if self.still > MEMORY {
            // All moments are alike.
            return;
        }
        self.moments.truncate(MEMORY);
        self.moments.push_front(Moment { pose, bounds: sized.bounds.swept(&before, &pose) });
        self.reach = Some(self.moments.iter().fold(Bounds::EMPTY, |reach, moment| reach.and(moment.bounds)));
    }
}

/// Where a transform puts a shape, and how large it makes it.
pub(in crate::plugin) fn placed(affine: &DAffine3) -> (Pose, Size) {
    let (scale, mut rotation, translation) = affine.to_scale_rotation_translation();
    let mut size = Size::Scaled(scale.as_vec3());
    if let Some(sheared) = Sheared::of(affine.matrix3) {
        (rotation, size) = (sheared.rotation, Size::Sheared(sheared.stretch));
    }
    (Pose { translation, rotation: rotation.normalize() }, size)
}

/// A collider that is none any more leaves nothing behind.
pub(in crate::plugin) fn end(removed: On<Remove, ClothCollider>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<(Track, ClothColliderError)>();
    }
}
