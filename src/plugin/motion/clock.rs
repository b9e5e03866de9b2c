//! The time at which a tick sees what is moved once a frame.
//!
//! A tick lies inside of the frame that is being made, of which only the beginning is known. So poses are read late, by the lag L:
//! as late as the longest frame of the last seconds, so that they are always known, and no later. A lag that changed at once would
//! stop all that moves whenever a frame is long; therefore it changes by a tenth of the pace of time at most.

/// Time in which a frame that was longer than others is forgotten, s. A hitch every half second (new levels, garbage) then keeps one lag.
const FORGET: f64 = 2.0;
/// Time in which the lag would become that of the longest frame, s, if the pace allowed.
const ADAPT: f64 = 0.25;
/// Share of the pace of time by which the lag changes at most: a tenth of a speed is not seen.
const DRIFT: f64 = 0.1;
/// A frame so many times as long as most is a hitch.
const HITCH: f64 = 1.5;
/// How far motion is taken to go on during a hitch, s. The game moves things by as much in that frame.
const AHEAD: f64 = 0.1;
/// Weight of a frame in the typical length.
const LATEST: f64 = 0.125;
/// Lags outside of this range (s) come from a clock that was set, and begin anew.
const SANE: core::ops::Range<f64> = -0.1..1.0;

/// The clock of [`super::Motions`]. All times are virtual time, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Clock {
    /// Ends of the last frame, and of this one.
    pub previous: f64,
    now: f64,
    /// Time of the last tick.
    ticked: f64,
    /// Time that the last tick saw; `None` before the first frame that had a length.
    pub sampled: Option<f64>,
    /// How much `sampled` advances per time of ticks.
    rate: f64,
    /// Length of most frames.
    typical: f64,
    /// Length of the longest lately, hitches cut short.
    longest: f64,
}

impl Clock {
    /// A frame begins that ends at `now` and is `delta` long, with `overstep` left from the ticks before it.
    pub fn begin_frame(&mut self, now: f64, delta: f64, overstep: f64) {
        self.now = now;
        self.previous = now - delta;
        self.ticked = self.previous - overstep;
        if delta <= 0.0 {
            return;
        }
        let known = if self.typical > 0.0 { self.typical } else { delta };
        let hitch = delta > HITCH * known;
        let usual = delta.min(HITCH * known);
        self.typical = known + LATEST * (usual - known);
        self.longest = usual.max(self.longest - (self.longest - usual) * (delta / FORGET).min(1.0));
        let lag = self.sampled.map(|sampled| self.ticked - sampled).filter(|lag| SANE.contains(lag)).unwrap_or(delta);
        let sampled = self.ticked - lag;
        self.sampled = Some(sampled);
        // Poses are known up to the last frame's end, and extrapolated by the jitter of frames, or through a hitch.
        let known_until = self.previous + if hitch { AHEAD } else { 0.5 * known };
        let pace = 1.0 + ((lag - self.longest) / ADAPT).clamp(-DRIFT, DRIFT);
        self.rate = pace.min((known_until - sampled) / (now - self.ticked)).max(0.0);
    }

    /// A tick of this frame begins, with `overstep` left after it.
    pub fn begin_tick(&mut self, overstep: f64) {
        let tick = self.now - overstep;
        if let Some(sampled) = &mut self.sampled {
            *sampled += self.rate * (tick - self.ticked).max(0.0);
        }
        self.ticked = tick;
    }

    /// The oldest time that ticks of this frame will ask for.
    pub fn oldest(&self) -> f64 {
        self.sampled.unwrap_or(self.previous)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs frames of these lengths with ticks of `step`, and returns for each tick its time and the time that it saw.
    fn ticks(frames: &[f64], step: f64) -> Vec<(f64, f64)> {
        let (mut clock, mut now, mut overstep, mut seen) = (Clock::default(), 0.0, 0.0, Vec::new());
        for &delta in frames {
            now += delta;
            clock.begin_frame(now, delta, overstep);
            overstep += delta;
            while overstep >= step {
                overstep -= step;
                clock.begin_tick(overstep);
                seen.push((now - overstep, clock.sampled.unwrap()));
            }
        }
        seen
    }

    #[test]
    fn at_even_frames_the_lag_is_one_frame_and_constant() {
        for (frame, step) in [(1.0 / 30.0, 1.0 / 64.0), (1.0 / 60.0, 1.0 / 64.0), (1.0 / 144.0, 1.0 / 60.0)] {
            for (tick, sampled) in &ticks(&vec![frame; 600], step)[100..] {
                assert!((tick - sampled - frame).abs() < 1e-9, "{}", tick - sampled);
            }
        }
    }

    #[test]
    fn uneven_frames_change_the_pace_by_little() {
        let jitter = |i: usize| 1.0 / 60.0 + 3e-3 * ((i * 7919 % 101) as f64 / 50.0 - 1.0);
        let frames: Vec<_> = (0..600).map(jitter).collect();
        let seen = ticks(&frames, 1.0 / 64.0);
        for pair in seen[100..].windows(2) {
            let pace = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
            assert!((0.85..1.15).contains(&pace), "{pace}");
        }
    }

    #[test]
    fn a_hitch_does_not_stop_the_motion() {
        let mut frames = vec![1.0 / 60.0; 300];
        frames[200] = 0.1;
        let seen = ticks(&frames, 1.0 / 64.0);
        for pair in seen[100..].windows(2) {
            let pace = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
            assert!((0.6..1.2).contains(&pace), "{pace}");
        }
    }

    #[test]
    fn no_time_passes_in_a_pause() {
        let mut frames = vec![1.0 / 60.0; 100];
        frames.extend([0.0; 20]);
        frames.extend([1.0 / 60.0; 100]);
        let seen = ticks(&frames, 1.0 / 60.0);
        for (tick, sampled) in &seen[50..] {
            assert!((tick - sampled - 1.0 / 60.0).abs() < 1e-9);
        }
    }
}
