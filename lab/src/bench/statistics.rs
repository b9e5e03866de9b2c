//! Times of many frames in a few figures.

use std::time::Duration;

use serde::Serialize;

/// A typical time and a bad one, ms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
}

impl Spread {
    /// Of these times.
    pub fn of(times: &[Duration]) -> Self {
        Self { median: median(times), p95: percentile(times, 0.95) }
    }
}

/// The median, ms.
pub fn median(times: &[Duration]) -> f64 {
    percentile(times, 0.5)
}

/// The least of the times that at least this share of all do not exceed (nearest rank), ms; NaN if there are none.
fn percentile(times: &[Duration], share: f64) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).map_or(f64::NAN, |time| 1e3 * time.as_secs_f64())
}

/// N times of each frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames<const N: usize>(pub [Vec<Duration>; N]);

impl<const N: usize> Frames<N> {
    /// None yet; so many can be added without allocation.
    pub fn with_capacity(frames: u32) -> Self {
        Self(std::array::from_fn(|_| Vec::with_capacity(frames as usize)))
    }

    /// Adds a frame.
    pub fn push(&mut self, frame: [Duration; N]) {
        for (times, time) in self.0.iter_mut().zip(frame) {
            times.push(time);
        }
    }

    /// Of each frame the least times, in this run or another of the same scene.
    pub fn least(self, other: Self) -> Self {
        let mut times = self;
        for (time, again) in times.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *time = (*time).min(*again);
        }
        times
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(values: &[u64]) -> Vec<Duration> {
        values.iter().copied().map(Duration::from_millis).collect()
    }

    #[test]
    fn percentiles_are_nearest_ranks() {
        let spread = Spread::of(&ms(&(1..=100).rev().collect::<Vec<_>>()));
        assert_eq!(spread, Spread { median: 50.0, p95: 95.0 });
        assert_eq!(Spread::of(&ms(&[7])), Spread { median: 7.0, p95: 7.0 });
        assert!(median(&[]).is_nan());
    }

    #[test]
    fn the_least_of_each_frame_is_kept() {
        let (first, second) = (Frames([ms(&[3, 5]), ms(&[1, 1])]), Frames([ms(&[4, 2]), ms(&[0, 7])]));
        assert_eq!(first.least(second), Frames([ms(&[3, 2]), ms(&[0, 1])]));
    }
}
