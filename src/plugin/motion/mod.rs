//! Where the entities are that hold cloth or touch it, at the time of a tick.
//!
//! Games move entities in different schedules, and the fixed loop runs before most of them. In a frame that has two ticks, an entity
//! that `Update` moves stands still between these two, and moves twice as far before the next one. So:
//!
//! - A transform that a fixed schedule writes counts as it is, in the tick that writes it.
//! - A transform that is written once a frame (in `Update`, by `AnimationPlayer` in `PostUpdate`, in `PreUpdate`) is noted at the end of
//!   each frame. A tick interpolates between these notes at a time of its own ([`clock`]), about one frame late.
//! - A transform that an engine eases between ticks for the eye (`TransformInterpolation`) is moved by the ticks: easing does not count
//!   as motion.
//!
//! Each of these rules is applied to translation, rotation and scale separately ([`way`]), and to every entity up to the root, because a
//! bone may be animated under a body that a fixed schedule moves. Cloths, pins and colliders all see the same time. A transform that
//! changes while no time passes, or that changes its velocity by more than a motion does, has jumped: all ticks from then on see it in
//! its new place.

mod clock;
mod felt;
mod glide;
mod way;

use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use self::clock::Clock;
use self::way::{Change, Way};

pub(super) use felt::{Carry, Felt, Limits, Motion};
pub(super) use glide::{Glides, TargetWays};

/// Change of speed within a frame from which on a thing has jumped, m/s: [`ClothInertia::jump_speed`](super::ClothInertia).
const JUMP: f32 = 8.0;
/// The same of a turn, rad/s: a cape swings half a meter behind the axis of its wearer.
const TURN: f32 = 16.0;
/// Ticks for which an entity is remembered that nobody asks for.
const FORGET: u32 = 30;
/// Smallest factor of a scale over the largest that is not flat: the inverse of less is rounding.
const FLAT: f32 = 1e-6;

/// The past of all entities that hold a cloth or are solid for it, and of those above them.
#[derive(Resource)]
pub(super) struct Motions {
    /// Off in schedules that run once a frame: there, what is moved before [`ClothSystems::Collect`](super::ClothSystems::Collect)
    /// is known for the time of the step.
    enabled: bool,
    clock: Clock,
    nodes: EntityHashMap<Node>,
    /// Counts ticks.
    tick: u32,
    /// Time that the tick before this one saw, s.
    seen_before: Option<f64>,
    /// Whether the last frame had a length.
    time_passed: bool,
    /// See [`ClothTeleport`], and the tick that takes note of it.
    teleported: Vec<(Entity, u32)>,
}

/// The past of an entity in the space of its parent.
struct Node {
    parent: Option<Entity>,
    translation: Way<Vec3>,
    rotation: Way<Quat>,
    scale: Way<Vec3>,
    /// Tick that it was last asked for in.
    ticked: u32,
    /// Tick in which its past was replaced, because it jumped.
    rewritten: u32,
}

/// Where an entity is at the time of a tick.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub now: GlobalTransform,
    /// Where it was in the last tick, as its past is known now, if the last tick saw it elsewhere. From here to `now` it moved; from
    /// where it was seen to here it jumped.
    pub before: Option<GlobalTransform>,
    /// Whether [`ClothTeleport`] says that it did not move here.
    pub teleported: bool,
}

impl Place {
    /// Of an entity that nothing else is known of.
    pub fn only(now: GlobalTransform) -> Self {
        Self { now, before: None, teleported: false }
    }
}

impl Motions {
    pub fn new(enabled: bool) -> Self {
        Self {
            enabled,
            clock: Clock::default(),
            nodes: EntityHashMap::default(),
            tick: 0,
            seen_before: None,
            time_passed: false,
            teleported: Vec::new(),
        }
    }

    /// The time that ticks see, and the end of the last frame, s; `None` where they see everything as it is.
    pub fn times(&self) -> Option<(f64, f64)> {
        self.enabled.then_some(())?;
        Some((self.clock.sampled?, self.clock.previous))
    }

    /// Says that an entity and those above it have always been where they are now.
    fn forget(&mut self, entity: Entity, transforms: &Query<&Transform>, parents: &Query<&ChildOf>) {
        self.teleported.push((entity, self.tick.wrapping_add(1)));
        for entity in core::iter::once(entity).chain(parents.iter_ancestors(entity)) {
            if let (Some(node), Ok(transform)) = (self.nodes.get_mut(&entity), transforms.get(entity)) {
                node.forget(self.clock.previous, transform);
            }
        }
    }

    /// Says that everything has always been where it is now: the world was put back into another state.
    pub fn forget_all(&mut self, transforms: &Query<&Transform>) {
        let time = self.clock.previous;
        for (&entity, node) in &mut self.nodes {
            if let Ok(transform) = transforms.get(entity) {
                node.forget(time, transform);
            }
        }
    }

    fn is_teleported(&self, entity: Entity) -> bool {
        self.teleported.contains(&(entity, self.tick))
    }

    /// Takes note of an entity in this tick; `None` if it has no place between its places, which is then as it is.
    fn follow(&mut self, entity: Entity, transform: &Transform, parent: Option<Entity>) -> Option<&Node> {
        if !is_sane(transform) {
            self.nodes.remove(&entity);
            return None;
        }
        let (time, tick) = (self.clock.previous, self.tick);
        let node = self.nodes.entry(entity).or_insert_with(|| Node::new(time, transform, parent));
        if node.parent == parent {
            node.tick(time, transform, tick == node.ticked);
        } else {
            *node = Node { rewritten: tick, ..Node::new(time, transform, parent) };
        }
        node.ticked = tick;
        Some(node)
    }
}

impl Node {
    fn new(time: f64, transform: &Transform, parent: Option<Entity>) -> Self {
        Self {
            parent,
            translation: Way::new(time, transform.translation),
            rotation: Way::new(time, transform.rotation),
            scale: Way::new(time, transform.scale),
            ticked: 0,
            rewritten: 0,
        }
    }

    fn end_frame(&mut self, time: f64, transform: &Transform, oldest: f64) {
        self.translation.end_frame(time, transform.translation, oldest, leaps);
        self.rotation.end_frame(time, transform.rotation, oldest, spins);
        self.scale.end_frame(time, transform.scale, oldest, mirrors);
    }

    fn tick(&mut self, time: f64, transform: &Transform, again: bool) {
        self.translation.tick(time, transform.translation, again);
        self.rotation.tick(time, transform.rotation, again);
        self.scale.tick(time, transform.scale, again);
    }

    fn forget(&mut self, time: f64, transform: &Transform) {
        self.translation.forget(time, transform.translation);
        self.rotation.forget(time, transform.rotation);
        self.scale.forget(time, transform.scale);
    }

    fn at(&self, time: f64) -> Transform {
        Transform {
            translation: self.translation.at(time),
            rotation: self.rotation.at(time),
            // What shrinks does not go on to nothing.
            scale: self.scale.at_most(time),
        }
    }
}

/// Whether a translation changed its velocity by more than a motion does.
fn leaps(change: Change<Vec3>) -> bool {
    change.mean.distance(change.before) > JUMP
}

fn spins(change: Change<Quat>) -> bool {
    change.mean.distance(change.before) > TURN
}

/// Nothing is turned inside out on its way.
fn mirrors(change: Change<Vec3>) -> bool {
    (change.from * change.to).min_element() <= 0.0
}

/// Whether a transform can be mixed with another.
fn is_sane(transform: &Transform) -> bool {
    let scale = transform.scale.abs();
    transform.is_finite() && scale.min_element() > FLAT * scale.max_element()
}

/// Before the fixed loop: takes note of what the last frame moved, and sets the clock of this one.
pub(super) fn before_ticks(
    time: Res<Time<Virtual>>,
    fixed: Res<Time<Fixed>>,
    mut motions: ResMut<Motions>,
    transforms: Query<(&Transform, Option<&ChildOf>)>,
) {
    let motions = &mut *motions;
    let delta = time.delta_secs_f64();
    motions.clock.begin_frame(time.elapsed_secs_f64(), delta, fixed.overstep().as_secs_f64());
    let next = motions.tick.wrapping_add(1);
    let (previous, oldest) = (motions.clock.previous, motions.clock.oldest());
    let time_passed = core::mem::replace(&mut motions.time_passed, delta > 0.0);
    motions.nodes.retain(|&entity, node| {
        let Ok((transform, parent)) = transforms.get(entity) else { return false };
        if next.wrapping_sub(node.ticked) > FORGET || !is_sane(transform) {
            return false;
        }
        let parent = parent.map(ChildOf::parent);
        if parent != node.parent {
            *node = Node { ticked: node.ticked, rewritten: next, ..Node::new(previous, transform, parent) };
        } else if time_passed {
            node.end_frame(previous, transform, oldest);
        } else if !node.is_seen_at(transform) {
            node.forget(previous, transform);
            node.rewritten = next;
        }
        true
    });
}

impl Node {
    fn is_seen_at(&self, transform: &Transform) -> bool {
        let Transform { translation, rotation, scale } = *transform;
        self.translation.seen() == translation && self.rotation.seen() == rotation && self.scale.seen() == scale
    }
}

/// First in each tick: sets the time that it sees.
pub(super) fn begin_tick(fixed: Res<Time<Fixed>>, mut motions: ResMut<Motions>) {
    motions.seen_before = motions.clock.sampled;
    motions.clock.begin_tick(fixed.overstep().as_secs_f64());
    motions.tick = motions.tick.wrapping_add(1);
    let tick = motions.tick;
    motions.teleported.retain(|&(_, when)| when == tick);
}

/// After the fixed loop: what its systems moved after the cloth was collected is not a frame's motion.
pub(super) fn after_ticks(mut motions: ResMut<Motions>, transforms: Query<&Transform>) {
    let previous = motions.clock.previous;
    for (&entity, node) in &mut motions.nodes {
        if let Ok(transform) = transforms.get(entity) {
            node.tick(previous, transform, true);
        }
    }
}

/// Gives transforms at the time of the tick.
#[derive(SystemParam)]
pub(super) struct Places<'w, 's> {
    motions: ResMut<'w, Motions>,
    transforms: Query<'w, 's, &'static Transform>,
    parents: Query<'w, 's, &'static ChildOf>,
    helper: TransformHelper<'w, 's>,
}

impl Places<'_, '_> {
    /// Where an entity is; `None` in a hierarchy with a hole.
    pub fn of(&mut self, entity: Entity) -> Option<Place> {
        let Self { motions, transforms, parents, helper } = self;
        let Some((time, _)) = motions.times() else {
            let now = helper.compute_global_transform(entity).ok()?;
            let mut chain = core::iter::once(entity).chain(parents.iter_ancestors(entity));
            let teleported = chain.any(|entity| motions.is_teleported(entity));
            return Some(Place { now, before: teleported.then_some(now), teleported });
        };
        let tick = motions.tick;
        let (mut rewritten, mut teleported) = (false, false);
        let mut local = |entity: Entity| {
            let transform = transforms.get(entity).ok()?;
            teleported |= motions.is_teleported(entity);
            let node = motions.follow(entity, transform, parents.get(entity).ok().map(ChildOf::parent));
            rewritten |= node.is_some_and(|node| node.rewritten == tick);
            Some(node.map_or(*transform, |node| node.at(time)))
        };
        let mut now = GlobalTransform::from(local(entity)?);
        for ancestor in parents.iter_ancestors(entity) {
            now = local(ancestor)? * now;
        }
        let before = if rewritten || teleported { self.in_the_tick_before(entity) } else { None };
        Some(Place { now, before, teleported })
    }

    /// Where an entity was in the last tick, as the past is told now.
    fn in_the_tick_before(&self, entity: Entity) -> Option<GlobalTransform> {
        let time = self.motions.seen_before?;
        let local = |entity: Entity| {
            let transform = self.transforms.get(entity).ok()?;
            Some(self.motions.nodes.get(&entity).map_or(*transform, |node| node.at(time)))
        };
        let mut before = GlobalTransform::from(local(entity)?);
        for ancestor in self.parents.iter_ancestors(entity) {
            before = local(ancestor)? * before;
        }
        Some(before)
    }

    /// The times of [`Motions::times`].
    pub fn times(&self) -> Option<(f64, f64)> {
        self.motions.times()
    }
}

/// Trigger it after moving an entity that holds cloth or is solid for it, so that this is not taken for a motion:
/// `commands.trigger(ClothTeleport { entity })`. What cloth hangs there is carried along as it is, folds and swing included.
///
/// Jumps are recognized without it where they change the speed of what holds the cloth by more than 8 m/s
/// ([`ClothInertia::jump_speed`](super::ClothInertia::jump_speed)). It is for smaller ones: a cut, a snap to a grid.
#[derive(EntityEvent, Clone, Copy, Debug, Reflect)]
pub struct ClothTeleport {
    /// The entity that was moved.
    pub entity: Entity,
}

pub(super) fn teleport(
    teleport: On<ClothTeleport>,
    mut motions: ResMut<Motions>,
    transforms: Query<&Transform>,
    parents: Query<&ChildOf>,
) {
    motions.forget(teleport.entity, &transforms, &parents);
}
