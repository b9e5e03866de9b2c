//! What the budget may take away from a cloth, one rung at a time: first substeps, then steps.

use crate::plugin::ClothQuality;

/// A rung of the ladder, counted from the top.
///
/// 0 to 4 are the levels of quality from [`ClothQuality::Film`] down, the last two of which step in every second and fourth tick;
/// 5 is the lowest level with a step in every eighth. A cloth with settings of its own keeps these: 2 is a step in every tick for
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::plugin) struct Rung(pub usize);

/// Number of rungs.
pub(super) const RUNGS: usize = 6;

impl Rung {
    /// The highest with a step in every tick for a cloth with settings of its own.
    pub const EVERY_TICK: Self = Self(2);
    /// The end of the ladder.
    pub const LOWEST: Self = Self(RUNGS - 1);

    /// Where a cloth of this quality stands if nothing is taken away.
    pub fn of(quality: ClothQuality) -> Self {
        Self(match quality {
            ClothQuality::Film => 0,
            ClothQuality::High => 1,
            ClothQuality::Medium => 2,
            ClothQuality::Low => 3,
            ClothQuality::Crowd => 4,
        })
    }

    /// The best quality this rung allows.
    pub fn quality(self) -> ClothQuality {
        match self.0 {
            0 => ClothQuality::Film,
            1 => ClothQuality::High,
            2 => ClothQuality::Medium,
            3 => ClothQuality::Low,
            _ => ClothQuality::Crowd,
        }
    }

    /// Ticks from step to step.
    pub fn interval(self) -> u32 {
        1 << self.0.saturating_sub(Self::EVERY_TICK.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::Quality;

    #[test]
    fn the_ladder_goes_through_the_levels_and_then_through_the_intervals() {
        for level in Quality::ALL.map(ClothQuality::from) {
            assert_eq!((Rung::of(level).quality(), Rung::of(level).interval()), (level, level.interval()));
        }
        assert_eq!(Rung::of(ClothQuality::Medium), Rung::EVERY_TICK);
        let intervals: Vec<_> = (0..RUNGS).map(|rung| Rung(rung).interval()).collect();
        assert_eq!(intervals, [1, 1, 1, 2, 4, 8]);
    }
}
