//! When a cloth is stepped: in every tick, or in one of several, with its motion shown over all of them.

/// The rhythm of a cloth. A tick is a run of the schedule of [`ClothPlugin`](super::ClothPlugin).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pace {
    /// Ticks from the last step to the next, over which the motion of the last step is shown.
    pub span: u32,
    /// Ticks since the last step.
    pub since: u32,
    /// Ticks from the next step to the one after it.
    pub following: u32,
    /// Time since the last step, s.
    pub pending: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { span: 1, since: 0, following: 1, pending: 0.0 }
    }
}

impl Pace {
    /// Whether there is a step in the tick that begins.
    pub fn is_due(&self) -> bool {
        self.since + 1 >= self.span
    }

    /// A tick of `dt` seconds: how long the step is that is to be taken in it, if one is, s.
    pub fn tick(&mut self, dt: f64) -> Option<f64> {
        let due = self.is_due();
        self.since += 1;
        self.pending += dt;
        due.then(|| {
            (self.span, self.since) = (self.following.max(1), 0);
            core::mem::take(&mut self.pending)
        })
    }

    /// How much of the motion of the last step is to be shown, `fraction` of a tick after the last one.
    pub fn shown(&self, fraction: f32) -> f32 {
        ((self.since as f32 + fraction) / self.span as f32).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tick_is_a_step_unless_said_otherwise() {
        let mut pace = Pace::default();
        for _ in 0..3 {
            assert_eq!((pace.is_due(), pace.tick(0.25), pace.shown(0.3)), (true, Some(0.25), 0.3));
        }
    }

    #[test]
    fn no_time_is_lost_between_steps_and_the_motion_is_shown_until_the_next() {
        let mut pace = Pace { following: 3, ..Default::default() };
        let steps: Vec<_> = (0..7).map(|_| pace.tick(0.5)).collect();
        assert_eq!(steps, [Some(0.5), None, None, Some(1.5), None, None, Some(1.5)]);
        assert_eq!([pace.shown(0.0), pace.shown(0.5)], [0.0, 0.5 / 3.0]);
        pace.tick(0.5);
        assert_eq!(pace.shown(0.5), 0.5);
        pace.tick(0.5);
        assert!(pace.is_due() && pace.shown(1.0) == 1.0);
    }
}
