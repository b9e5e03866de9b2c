//! The systems of the budget, and what they remember.

use core::time::Duration;

use bevy::camera::primitives::Aabb;
use bevy::camera::{Camera, Projection};
use bevy::prelude::*;

use super::allocation::{Request, allocate, total};
use super::cost::CostModel;
use super::importance::Seen;
use super::rung::Rung;
use super::stagger::{PERIOD, Turn, following, stagger};
use super::{ClothBudget, ClothBudgetReport, ClothImportance, Share};
use crate::plugin::quality::{ClothDefaultQuality, ClothQuality, ClothSolver};
use crate::plugin::state::ClothState;

/// Share by which what is predicted may exceed the budget before the next round.
const OVER: f64 = 1.05;
/// Rounds without taking anything away after which something is given back.
const CALM: u32 = 4;
/// Weight of the latest frame in an average.
const LATEST: f64 = 1.0 / 16.0;
/// A frame that took this many times the average so far counts as so many only.
const OUTLIER: f64 = 3.0;

/// Time that was spent since the last frame was closed.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::plugin) struct Spent {
    pub collect: Duration,
    pub step: Duration,
    pub write_back: Duration,
    /// What the steps were expected to take one after another, s.
    expected: f64,
    ticks: u32,
}

/// An average that forgets.
#[derive(Clone, Copy, Debug, Default)]
struct Average(Option<f64>);

impl Average {
    fn add(&mut self, value: f64) {
        let known = self.0.unwrap_or(value);
        let value = if known > 0.0 { value.min(OUTLIER * known) } else { value };
        self.0 = Some(known + LATEST * (value - known));
    }

    fn or(&self, otherwise: f64) -> f64 {
        self.0.unwrap_or(otherwise)
    }
}

/// What is remembered from tick to tick and from frame to frame.
#[derive(Resource, Default)]
pub(in crate::plugin) struct Keeper {
    pub spent: Spent,
    model: CostModel,
    /// Number of the present tick.
    pub tick: u32,
    /// Rounds since something was last taken away.
    calm: u32,
    /// There is something to [`release`].
    active: bool,
    exhausted: bool,
    lowered: usize,
    /// Time per tick as predicted, where the cloths stand and where they would like to, all steps one after another, s.
    predicted: f64,
    requested: f64,

    /// Time of a frame, s; of these, those with a tick have so many.
    frame: Average,
    ticks: Average,
    /// Time beside the steps: per tick and per frame, s.
    collect: Average,
    write_back: Average,
    /// Time of all steps of a frame as expected, one after another, and as it was, s.
    expected: Average,
    step: Average,
}

impl Keeper {
    /// Time of the steps of a tick, relative to what was expected of them one after another: less where threads share the work,
    /// more where other programs are in the way or a few steps take much longer than most.
    fn slowness(&self) -> f64 {
        let slowness = self.step.or(1.0) / self.expected.or(1.0);
        if slowness.is_finite() { slowness.max(1e-3) } else { 1.0 }
    }

    /// Time that the steps of a tick may take one after another, s.
    fn capacity(&self, budget: ClothBudget) -> f64 {
        let of_a_frame = 1e-3 * f64::from(budget.ms).max(0.0);
        let of_a_tick = (of_a_frame - self.write_back.or(0.0)) / self.ticks.or(1.0).max(1.0) - self.collect.or(0.0);
        of_a_tick.max(0.0) / self.slowness()
    }

    /// Time of a frame in a tick of which steps are expected to take `steps` seconds one after another, ms.
    fn frame_ms(&self, steps: f64) -> f32 {
        let of_a_tick = steps * self.slowness() + self.collect.or(0.0);
        (1e3 * (of_a_tick * self.ticks.or(1.0).max(1.0) + self.write_back.or(0.0))) as f32
    }
}

type Managed<'a> = (
    &'a mut ClothState,
    Has<ClothSolver>,
    Option<&'a ClothQuality>,
    Option<&'a ClothImportance>,
    &'a GlobalTransform,
    Option<&'a Aabb>,
    Option<&'a ViewVisibility>,
    Option<&'a InheritedVisibility>,
);

/// Decides, before a tick, on which rung each cloth stands and when those that are stepped now are stepped again.
pub(in crate::plugin) fn plan(
    budget: Res<ClothBudget>,
    default_quality: Res<ClothDefaultQuality>,
    cameras: Query<(&Camera, &Projection, &GlobalTransform)>,
    mut keeper: ResMut<Keeper>,
    mut cloths: Query<Managed>,
) {
    let keeper = &mut *keeper;
    if !core::mem::replace(&mut keeper.active, true) {
        keeper.spent = Spent::default();
    }
    let (mut states, mut requests) = (Vec::new(), Vec::new());
    let mut new = false;
    for (state, own_settings, quality, weight, transform, aabb, in_view, inherited) in &mut cloths {
        if state.suspended {
            continue;
        }
        let top = if own_settings { Rung::EVERY_TICK } else { Rung::of(*quality.unwrap_or(&default_quality.0)) };
        new |= state.share.rung.is_none_or(|rung| rung < top);
        requests.push(Request {
            costs: keeper.model.per_tick(&state.share.cost, state.cloth.shape().vertex_count()),
            importance: Seen { weight, transform, aabb, in_view, inherited }.importance(cameras.iter()),
            top,
            rung: state.share.rung.unwrap_or(top).max(top),
            last_resort: own_settings,
        });
        states.push(state.into_inner());
    }
    let capacity = keeper.capacity(*budget);
    let over = total(&requests) > OVER * capacity && !keeper.exhausted;
    let round = keeper.tick.is_multiple_of(PERIOD);
    if new || over || round || budget.is_changed() {
        let before = total(&requests);
        keeper.calm = if before > capacity { 0 } else { keeper.calm.saturating_add(u32::from(round)) };
        allocate(&mut requests, capacity, round && keeper.calm >= CALM);
        keeper.exhausted = total(&requests) > capacity;
        take_turns(&mut states, &requests);
    }
    for state in states {
        if let Share { rung: Some(rung), phase: Some(phase), .. } = state.share
            && state.pace.is_due()
        {
            state.pace.following = following(keeper.tick, rung.interval(), phase, state.pace.span);
        }
    }
    keeper.lowered = requests.iter().filter(|request| request.rung > request.top).count();
    keeper.predicted = total(&requests);
    keeper.requested = requests.iter().map(|request| request.costs[request.top.0]).sum();
}

/// Puts the cloths on their rungs.
fn take_turns(states: &mut [&mut ClothState], requests: &[Request]) {
    let turn = |(state, request): (&mut &mut ClothState, &Request)| {
        let interval = request.rung.interval();
        let stays = state.share.rung.is_some_and(|rung| rung.interval() == interval);
        let phase = state.share.phase.filter(|_| stays);
        Turn { interval, phase, cost: request.costs[request.rung.0] * f64::from(interval) }
    };
    let mut turns: Vec<_> = states.iter_mut().zip(requests).map(turn).collect();
    stagger(&mut turns);
    for ((state, request), turn) in states.iter_mut().zip(requests).zip(turns) {
        (state.share.rung, state.share.phase) = (Some(request.rung), turn.phase);
    }
}

/// Takes note, after a tick, of what its steps cost.
pub(in crate::plugin) fn observe(mut keeper: ResMut<Keeper>, mut cloths: Query<&mut ClothState>) {
    let keeper = &mut *keeper;
    keeper.spent.ticks += 1;
    for mut state in &mut cloths {
        let state = &mut *state;
        if let (Some(report), Some(rung)) = (state.report_of_this_tick(), state.share.rung) {
            let vertices = state.cloth.shape().vertex_count();
            keeper.spent.expected += keeper.model.of(&state.share.cost, vertices, rung);
            keeper.model.observe(&mut state.share.cost, vertices, rung, report.total.as_secs_f64());
        }
    }
}

/// Adds up a frame, and reports.
pub(in crate::plugin) fn close_frame(mut keeper: ResMut<Keeper>, mut report: ResMut<ClothBudgetReport>) {
    let keeper = &mut *keeper;
    let spent = core::mem::take(&mut keeper.spent);
    keeper.frame.add((spent.collect + spent.step + spent.write_back).as_secs_f64());
    keeper.write_back.add(spent.write_back.as_secs_f64());
    if spent.ticks > 0 {
        keeper.ticks.add(spent.ticks.into());
        keeper.collect.add(spent.collect.as_secs_f64() / f64::from(spent.ticks));
    }
    if spent.expected > 0.0 {
        keeper.expected.add(spent.expected);
        keeper.step.add(spent.step.as_secs_f64());
    }
    *report = ClothBudgetReport {
        requested_ms: keeper.frame_ms(keeper.requested),
        predicted_ms: keeper.frame_ms(keeper.predicted),
        measured_ms: (1e3 * keeper.frame.or(0.0)) as f32,
        lowered: keeper.lowered,
        exhausted: keeper.exhausted,
    };
}

/// Whether a budget has gone and its cloths do not know.
pub(in crate::plugin) fn is_left_over(budget: Option<Res<ClothBudget>>, keeper: Res<Keeper>) -> bool {
    budget.is_none() && keeper.active
}

/// Gives everything back when there is no budget any more.
pub(in crate::plugin) fn release(
    mut keeper: ResMut<Keeper>,
    mut report: ResMut<ClothBudgetReport>,
    mut cloths: Query<&mut ClothState>,
) {
    *keeper = Keeper { tick: keeper.tick, ..default() };
    *report = ClothBudgetReport::default();
    for mut state in &mut cloths {
        state.share = Share::default();
    }
}
