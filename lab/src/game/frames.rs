//! How long the frames of a game are.

use core::time::Duration;

use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

/// Lengths of frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Frames {
    /// Each as long as the others: so many a second.
    Even(f64),
    /// Each off by 3 ms at most, at random.
    Jitter(f64),
    /// Shorter and longer by a seventh in turn, as a display of 60 Hz gives 14 and 19 ms.
    InTurn(f64),
    /// Every thirtieth is twice as long: a frame was dropped.
    Dropped(f64),
    /// One of 100 ms, half a second into what is watched.
    Hitch(f64),
}

/// How far a frame is off, s.
const JITTER: f64 = 3e-3;
/// Of 14 and 19 ms from their mean, relative to it.
const IN_TURN: f64 = 0.15;
/// s.
const HITCH: f64 = 0.1;

impl Frames {
    /// Those that are not even, about so many a second.
    pub fn uneven(rate: f64) -> [Self; 4] {
        [Self::Jitter(rate), Self::InTurn(rate), Self::Dropped(rate), Self::Hitch(rate)]
    }

    /// How many a second, about.
    pub fn rate(self) -> f64 {
        match self {
            Self::Even(rate) | Self::Jitter(rate) | Self::InTurn(rate) | Self::Dropped(rate) | Self::Hitch(rate) => {
                rate
            }
        }
    }

    /// For the reader.
    pub fn name(self) -> String {
        match self {
            Self::Even(rate) => format!("{rate} fps"),
            Self::Jitter(rate) => format!("{rate} fps ± 3 ms"),
            Self::InTurn(rate) => {
                let [short, long] = [1.0 - IN_TURN, 1.0 + IN_TURN].map(|part| (1e3 * part / rate).round());
                format!("{short} and {long} ms in turn")
            }
            Self::Dropped(rate) => format!("{rate} fps, each 30th dropped"),
            Self::Hitch(rate) => format!("{rate} fps, one of 100 ms"),
        }
    }

    /// Their lengths, one after the other; the hitch is the first to end later than `watched` + 0.5 s.
    pub fn lengths(self, watched: f64) -> impl Iterator<Item = Duration> {
        let mut random = StdRng::seed_from_u64(13);
        let even = 1.0 / self.rate();
        let mut time = 0.0;
        (0_u64..).map(move |number| {
            let hitch_at = watched + 0.5;
            let length = match self {
                Self::Even(_) => even,
                Self::Jitter(_) => even + random.random_range(-JITTER..=JITTER),
                Self::InTurn(_) => even * if number.is_multiple_of(2) { 1.0 - IN_TURN } else { 1.0 + IN_TURN },
                Self::Dropped(_) => even * if number % 30 == 29 { 2.0 } else { 1.0 },
                Self::Hitch(_) if time < hitch_at && time + even >= hitch_at => HITCH,
                Self::Hitch(_) => even,
            };
            time += length;
            Duration::from_secs_f64(length)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_as_many_a_second_as_they_say() {
        for frames in [Frames::Even(144.0), Frames::Jitter(60.0), Frames::InTurn(60.0)] {
            let time: Duration = frames.lengths(0.0).take(6000).sum();
            assert!((6000.0 / time.as_secs_f64() / frames.rate() - 1.0).abs() < 0.01, "{frames:?}");
        }
    }

    #[test]
    fn there_is_one_hitch_while_something_is_watched() {
        let long: Vec<_> =
            Frames::Hitch(30.0).lengths(2.0).enumerate().take(300).filter(|(_, l)| l.as_millis() > 90).collect();
        assert_eq!(long.len(), 1);
        assert!((70..80).contains(&long[0].0), "{long:?}");
        let doubled = Frames::Dropped(60.0).lengths(0.0).take(90).filter(|length| length.as_millis() > 30).count();
        assert_eq!(doubled, 3);
    }
}
