//! A limit to the time that all cloths together may take: who gives way, by how much, and when it is given back.
//!
//! Each cloth stands on a [`rung`] of one ladder: levels of quality, then steps longer than those of the lowest. In each tick the
//! [`cost`] of every cloth is predicted from what its steps have cost; when they do not fit, or every few ticks, the
//! [`allocation`] moves cloths up or down by [`importance`], and [`stagger`] spreads those that are not stepped in every tick.
//! [`systems`] are the hands of it. Without a [`ClothBudget`] none of them runs.

mod allocation;
mod cost;
mod importance;
mod rung;
mod stagger;
mod systems;

use bevy::prelude::*;

use self::cost::Cost;
pub use self::importance::ClothImportance;
pub(super) use self::rung::Rung;
pub(super) use self::stagger::following;
pub(super) use self::systems::{Keeper, close_frame, is_left_over, observe, plan, release};

/// Optional: the time that all cloths together may take in a frame. While it is there, the plugin lowers the quality of cloths
/// to stay within it, and raises it again when there is time.
///
/// - What counts is the time in which cloths are collected, stepped (side by side, as far as there are threads) and written to
///   their meshes. What a step of each cloth will cost is predicted from what its steps have cost so far; the first frame after
///   many cloths have appeared may take longer, and so may a frame in which other programs are busy.
/// - A cloth is lowered rung by rung: through the levels of [`ClothQuality`](super::ClothQuality) down to the lowest, which takes one
///   step of fourfold length in every fourth tick; then to one step in every eighth. Cloths take their steps in different ticks, so that
///   all ticks cost about the same. The picture is interpolated between two steps, so it is later by as many ticks. Pins stay where
///   their entity is.
/// - The least important cloth is lowered first. Importance is [`ClothImportance`] × the size of the cloth on the largest of the active
///   cameras' screens; × 0.1 if no camera saw the cloth in the last frame, × 0.01 if it is hidden. Each rung further down counts
///   twice as much as the one above.
/// - Quality is never raised beyond what was asked for. A cloth with a [`ClothSolver`](super::ClothSolver) keeps its settings;
///   it takes fewer steps only once all other cloths are on the last rung.
///
/// [`ClothState::quality`](super::ClothState::quality) and [`ClothState::update_interval`](super::ClothState::update_interval) tell
/// how each cloth is solved, [`ClothBudgetReport`] what all of them take. With a budget, motion depends on how long steps took: it is
/// not the same in every run.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct ClothBudget {
    /// Milliseconds per frame; 4 by default. 0, less, or not a number: as little as can be.
    pub ms: f32,
}

impl Default for ClothBudget {
    fn default() -> Self {
        Self { ms: 4.0 }
    }
}

/// What [`ClothBudget`] made of the cloths, once per frame. All zero without one.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct ClothBudgetReport {
    /// What a frame would take, as predicted, if every cloth had what was asked for, ms.
    pub requested_ms: f32,
    /// What it takes as things stand, as predicted, ms.
    pub predicted_ms: f32,
    /// What frames took lately, ms.
    pub measured_ms: f32,
    /// Number of cloths that have less than was asked for.
    pub lowered: usize,
    /// Everything is at the end of the ladder, and it is still too much.
    pub exhausted: bool,
}

/// What the budget knows of a cloth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Share {
    /// Where it stands; `None` without budget.
    pub rung: Option<Rung>,
    /// See [`stagger::Turn::phase`].
    phase: Option<u32>,
    cost: Cost,
}
