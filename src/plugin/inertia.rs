//! How much of the motion of its entity a cloth feels, as a component.

use core::f32::consts::TAU;

use bevy::prelude::*;

use super::error::ClothError;
use super::motion::Limits;

/// Optional: how a cloth that is held feels the motion of its entity.
///
/// What it does not feel carries it along as it is, with its folds and its swing. A cloth without this component has the default:
/// it feels every motion that could be real, and neither teleports nor snap-turns. All limits are judged at the held vertices, so that
/// a turn counts by how far it swings them. None depends on the frame rate.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothInertia {
    /// Share of the velocity that is felt: 1 (the default) wholly, 0 not at all. The air is felt wholly all the same.
    pub linear: f32,
    /// Share of the turning that is felt. Default: 1.
    pub angular: f32,
    /// Velocity that is felt at most, m/s. Default: infinity.
    pub max_speed: f32,
    /// Turning that is felt at most, rad/s. Default: infinity.
    pub max_turn: f32,
    /// Acceleration that is felt at most, m/s²: what is faster is felt over a longer time. Default: 100, ten times gravity. A start
    /// at 6 m/s within one frame so stretches a cape of cotton by less than 10 %.
    pub max_acceleration: f32,
    /// Change of velocity from one tick to the next that is a jump and not felt at all, m/s. One that lasts for 0.3 s is taken for a
    /// velocity after all. Default: 8: a dash of 12 m/s is a jump, running at 6 m/s is not.
    pub jump_speed: f32,
}

impl Default for ClothInertia {
    fn default() -> Self {
        Self {
            linear: 1.0,
            angular: 1.0,
            max_speed: f32::INFINITY,
            max_turn: f32::INFINITY,
            max_acceleration: 100.0,
            jump_speed: 8.0,
        }
    }
}

impl ClothInertia {
    /// For capes, skirts and hair of game characters, who run and turn faster than people: three quarters of the motion are felt, 5 m/s
    /// and one turn a second at most.
    pub const fn character() -> Self {
        Self { linear: 0.75, angular: 0.75, max_speed: 5.0, max_turn: TAU, max_acceleration: 100.0, jump_speed: 8.0 }
    }

    /// Every motion is felt, however sudden: for measurements and machines.
    pub const fn unlimited() -> Self {
        Self {
            linear: 1.0,
            angular: 1.0,
            max_speed: f32::INFINITY,
            max_turn: f32::INFINITY,
            max_acceleration: f32::INFINITY,
            jump_speed: f32::INFINITY,
        }
    }

    /// What the motion needs to know.
    pub(super) fn limits(&self) -> Result<Limits, ClothError> {
        let fields = [
            ("linear", self.linear),
            ("angular", self.angular),
            ("max_speed", self.max_speed),
            ("max_turn", self.max_turn),
            ("max_acceleration", self.max_acceleration),
            ("jump_speed", self.jump_speed),
        ];
        if let Some((field, value)) = fields.into_iter().find(|(_, value)| value.is_nan() || *value < 0.0) {
            return Err(ClothError::Inertia { field, value: value.to_string() });
        }
        Ok(Limits {
            linear: self.linear.into(),
            angular: self.angular.into(),
            max_speed: self.max_speed.into(),
            max_turn: self.max_turn.into(),
            max_acceleration: self.max_acceleration.into(),
            jump_speed: self.jump_speed.into(),
        })
    }
}
