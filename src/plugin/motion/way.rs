//! The past of one part of a transform, and where that part was at a time.

use std::collections::VecDeque;

use bevy::math::{Quat, Vec3};

/// Relative change of a value within the fixed loop that counts as rounding: physics engines write a transform back that is not
/// the one they read to the last bit. About a hundred times the rounding of f32.
const NOISE: f32 = 1e-5;
/// A change in a tick raises the confidence that ticks move this part, a tick without one lowers it by one.
const SURER: u8 = 2;
/// Confidence from which on a change outside of the fixed loop is taken for easing. An eased body shows no change in a tick in
/// which its eased place happens to be that of the tick: the last case of the test of easing below.
const SURE: u8 = 3;
/// Upper limit of the confidence: what ticks no longer move is seen as moved by frames after so many ticks at most.
const SUREST: u8 = 8;
/// Share of an interval beyond its end within which its last value is taken, so that rounding of times does not extrapolate.
const END: f64 = 1e-6;
/// Change of a velocity from one frame to the next, per time, from which on it is no acceleration but a start or a stop, m/s² (rad/s²
/// for turns): the way is not rounded there. Running that begins in one frame of 1/60 s is at 360, a bone that swings by half a
/// radian once a second at 20.
const SUDDEN: f32 = 100.0;

/// A translation, rotation or scale.
pub(super) trait Part: Copy + PartialEq {
    /// The difference to another value: m, or rad about an axis.
    fn to(self, other: Self) -> Vec3;
    /// The value after such a difference.
    fn moved(self, by: Vec3) -> Self;
    /// Whether both differ by rounding only.
    fn is_noise(self, to: Self) -> bool;
}

impl Part for Vec3 {
    fn to(self, other: Self) -> Vec3 {
        other - self
    }

    fn moved(self, by: Vec3) -> Self {
        self + by
    }

    fn is_noise(self, to: Self) -> bool {
        (to - self).abs().max_element() <= NOISE * self.abs().max_element().max(0.1)
    }
}

impl Part for Quat {
    fn to(self, other: Self) -> Vec3 {
        // The shorter way round.
        let other = if self.dot(other) < 0.0 { -other } else { other };
        (other * self.inverse()).to_scaled_axis()
    }

    fn moved(self, by: Vec3) -> Self {
        (Self::from_scaled_axis(by) * self).normalize()
    }

    fn is_noise(self, to: Self) -> bool {
        self.abs_diff_eq(to, NOISE) || self.abs_diff_eq(-to, NOISE)
    }
}

/// A value at the end of a frame.
#[derive(Clone, Copy)]
struct Entry<T> {
    /// s.
    time: f64,
    value: T,
    /// Mean velocity of the frame that led here, and the one at its end, per s.
    mean: Vec3,
    velocity: Vec3,
    /// Whether no motion led here from the entry before.
    jumped: bool,
}

impl<T> Entry<T> {
    fn standing(time: f64, value: T) -> Self {
        Self { time, value, mean: Vec3::ZERO, velocity: Vec3::ZERO, jumped: false }
    }
}

/// A frame's change of a part: the mean velocity of that frame and the velocity before it, per s, and the values at its ends.
#[derive(Clone, Copy)]
pub(super) struct Change<T> {
    pub before: Vec3,
    pub mean: Vec3,
    pub from: T,
    pub to: T,
}

/// The values of one part at the ends of frames, as far back as they are needed.
pub(super) struct Way<T> {
    /// The value that was last seen, whoever wrote it.
    seen: T,
    /// Since a tick last wrote the part; a single entry while it does not change.
    past: VecDeque<Entry<T>>,
    /// Confidence that ticks move the part.
    by_ticks: u8,
}

impl<T: Part> Way<T> {
    /// A part without a past, which is first seen at `time`.
    pub fn new(time: f64, value: T) -> Self {
        Self { seen: value, past: VecDeque::from([Entry::standing(time, value)]), by_ticks: 0 }
    }

    /// The value that was last seen.
    pub fn seen(&self) -> T {
        self.seen
    }

    /// Takes note of the value before the fixed loop runs: the frame that ended at `time` left it. `jumps` says whether a change is
    /// none that can be followed. Entries that are not needed to know the value from `oldest` on are dropped.
    pub fn end_frame(&mut self, time: f64, value: T, oldest: f64, jumps: impl Fn(Change<T>) -> bool) {
        let stands = value == self.seen && self.past.iter().all(|past| past.value == value);
        self.seen = value;
        if stands {
            self.past.truncate(1);
            self.past[0] = Entry::standing(time.max(self.past[0].time), value);
            return;
        }
        let count = self.past.len();
        let last = self.past[count - 1];
        if last.time >= time {
            self.past[count - 1].value = value;
            return;
        }
        let length = time - last.time;
        let mean = last.value.to(value) / length as f32;
        let jump = |before| jumps(Change { before, mean, from: last.value, to: value });
        // After a jump, either it was the beginning of a motion, or the motion before it goes on.
        let jumped = jump(last.mean) && (!last.jumped || jump(last.velocity));
        let velocity = match count.checked_sub(2).map(|index| self.past[index]) {
            _ if jumped => last.velocity,
            Some(before) if !last.jumped => ending(last.mean, last.time - before.time, mean, length),
            _ => mean,
        };
        self.past.push_back(Entry { time, value, mean, velocity, jumped });
        // The entry before the one in use tells how things went on.
        while self.past.len() > 3 && self.past[2].time <= oldest {
            self.past.pop_front();
        }
    }

    /// Takes note of the value in a tick of the fixed loop. What changes there is there at once, and the past ends. `again` says that
    /// this tick has been looked at before, so that it says nothing new about who moves the part.
    pub fn tick(&mut self, time: f64, value: T, again: bool) {
        let changed = value != self.seen;
        if changed && !self.seen.is_noise(value) {
            self.by_ticks = (self.by_ticks + SURER).min(SUREST);
            self.forget(time, value);
        } else {
            self.by_ticks = self.by_ticks.saturating_sub(u8::from(!again));
            if self.by_ticks >= SURE {
                self.forget(time, value);
            } else if changed && let Some(last) = self.past.back_mut() {
                last.value = value;
            }
        }
        self.seen = value;
    }

    /// Forgets the past: the part has always been where it is.
    pub fn forget(&mut self, time: f64, value: T) {
        self.seen = value;
        self.past.clear();
        self.past.push_back(Entry::standing(time, value));
    }

    /// The value at a time. Between frames the way is round where the velocity changes steadily: in straight pieces, each frame would
    /// be a jolt. Beyond the last frame, and before a jump, it goes on as it went before.
    pub fn at(&self, time: f64) -> T {
        let after = self.past.partition_point(|entry| entry.time <= time);
        let Some(now) = after.checked_sub(1).map(|index| self.past[index]) else {
            return self.past.front().map_or(self.seen, |first| first.value);
        };
        let since = (time - now.time) as f32;
        match self.past.get(after) {
            Some(next) if (next.time - time) <= END * (next.time - now.time) => next.value,
            Some(next) if !next.jumped => {
                if now.value == next.value {
                    return now.value;
                }
                let length = (next.time - now.time) as f32;
                let way = next.mean * length;
                now.value.moved(hermite(way, now.velocity * length, next.velocity * length, since / length))
            }
            _ if now.velocity == Vec3::ZERO || since <= 0.0 => now.value,
            _ => now.value.moved(now.velocity * since),
        }
    }

    /// As [`at`](Self::at), but never beyond the last frame.
    pub fn at_most(&self, time: f64) -> T {
        self.at(self.past.back().map_or(time, |last| time.min(last.time)))
    }
}

/// The velocity at the end of the second of two frames with these mean velocities and lengths: that of the parabola through both, unless
/// it started or stopped.
fn ending(before: Vec3, length_before: f64, mean: Vec3, length: f64) -> Vec3 {
    let change = mean - before;
    let share = (length / (length + length_before)) as f32;
    if change.length() > SUDDEN * length as f32 { mean } else { mean + share * change }
}

/// The cubic from 0 to `way` with these tangents, at `u` in 0..1. Tangents are shortened where the curve would run back
/// (Fritsch & Carlson 1980): what stops does not overshoot.
fn hermite(way: Vec3, start: Vec3, end: Vec3, u: f32) -> Vec3 {
    let most = 3.0 * way.length();
    let (start, end) = (start.clamp_length_max(most), end.clamp_length_max(most));
    let (u2, u3) = (u * u, u * u * u);
    way * (3.0 * u2 - 2.0 * u3) + start * (u3 - 2.0 * u2 + u) + end * (u3 - u2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEVER: fn(Change<Vec3>) -> bool = |_| false;

    #[test]
    fn what_frames_move_is_between_their_ends() {
        let mut way = Way::new(0.0, Vec3::ZERO);
        for frame in 1..=4 {
            way.end_frame(f64::from(frame), Vec3::X * frame as f32, f64::from(frame) - 1.5, NEVER);
        }
        assert_eq!(way.at(3.25), Vec3::X * 3.25);
        assert_eq!(way.at(4.5), Vec3::X * 4.5, "beyond the last frame it goes on");
        assert_eq!(way.at_most(4.5), Vec3::X * 4.0);
        assert_eq!(way.at(0.5), Vec3::X, "what is not needed any more is dropped");
    }

    #[test]
    fn a_jump_happens_at_its_end_and_the_motion_goes_on_around_it() {
        let jumps = |change: Change<Vec3>| change.mean.distance(change.before) > 2.0;
        let mut way = Way::new(0.0, Vec3::ZERO);
        way.end_frame(1.0, Vec3::X, 0.0, jumps);
        way.end_frame(2.0, Vec3::new(2.0, 50.0, 0.0), 0.0, jumps);
        assert_eq!(way.at(1.5), Vec3::X * 1.5);
        assert_eq!(way.at(2.0), Vec3::new(2.0, 50.0, 0.0));
        assert_eq!(way.at(2.5), Vec3::new(2.5, 50.0, 0.0), "it goes on as before the jump");
        way.end_frame(3.0, Vec3::new(3.0, 50.0, 0.0), 0.0, jumps);
        assert_eq!(way.at(2.5), Vec3::new(2.5, 50.0, 0.0));
    }

    #[test]
    fn a_jump_that_lasts_is_a_motion() {
        let jumps = |change: Change<Vec3>| change.mean.distance(change.before) > 2.0;
        let mut way = Way::new(0.0, Vec3::ZERO);
        for frame in 1..5 {
            way.end_frame(f64::from(frame), Vec3::X * 10.0 * frame as f32, 0.0, jumps);
        }
        assert_eq!(way.at(0.5), Vec3::ZERO, "the first was none");
        assert_eq!(way.at(3.5), Vec3::X * 35.0);
    }

    #[test]
    fn a_steady_acceleration_is_followed_exactly_and_a_stop_is_not_overshot() {
        let place = |t: f64| Vec3::X * (0.5 * 9.81 * t * t) as f32;
        let mut way = Way::new(0.0, place(0.0));
        for frame in 1..20 {
            let end = f64::from(frame) / 30.0;
            way.end_frame(end, place(end), end - 0.1, NEVER);
            if frame > 3 {
                let between = end - 0.4 / 30.0;
                assert!(way.at(between).distance(place(between)) < 2e-6, "{}", way.at(between) - place(between));
            }
        }
        let last = place(19.0 / 30.0);
        way.end_frame(20.0 / 30.0, last, 0.0, NEVER);
        for share in [0.1, 0.5, 0.9] {
            assert!(way.at((19.0 + share) / 30.0).distance(last) < 1e-6);
        }
    }

    #[test]
    fn what_stands_gives_the_same_bits() {
        let place = Vec3::new(0.1, 1.0 / 3.0, 7.7);
        let mut way = Way::new(0.0, place);
        for frame in 1..10 {
            way.end_frame(f64::from(frame) / 60.0, place, 0.0, NEVER);
            way.tick(f64::from(frame) / 60.0, place, false);
            assert_eq!(way.at(f64::from(frame) / 64.0), place);
            assert_eq!(way.past.len(), 1);
        }
    }

    #[test]
    fn what_ticks_move_is_there_at_once_and_easing_between_them_is_no_motion() {
        let mut way = Way::new(0.0, Vec3::ZERO);
        for frame in 1..20 {
            let (time, place) = (f64::from(frame), Vec3::X * frame as f32);
            // Eased to half way, and written back by the tick, which moves it on.
            way.end_frame(time, place - 0.5, time - 2.0, NEVER);
            way.tick(time, place, false);
            assert_eq!(way.at(time - 0.7), place);
        }
        // Its eased place is that of the tick for once.
        way.end_frame(20.0, Vec3::X * 20.0, 18.0, NEVER);
        way.tick(20.0, Vec3::X * 20.0, false);
        assert_eq!(way.at(19.3), Vec3::X * 20.0);
    }

    #[test]
    fn a_transform_that_is_written_back_with_rounding_keeps_its_past() {
        let mut way = Way::new(0.0, Vec3::X);
        for frame in 1..=3 {
            way.end_frame(f64::from(frame), Vec3::X * (1 + frame) as f32, 0.0, NEVER);
        }
        way.tick(3.0, Vec3::X * 4.000001, false);
        assert!((way.at(2.5).x - 3.5).abs() < 1e-5, "{}", way.at(2.5));
    }

    #[test]
    fn turns_go_on_about_their_axis() {
        let turn = |angle: f32| Quat::from_rotation_y(angle);
        let mut way = Way::new(0.0, turn(0.0));
        for frame in 1..=3 {
            way.end_frame(f64::from(frame), turn(0.2 * frame as f32), 0.0, |_| false);
        }
        assert!(way.at(3.5).abs_diff_eq(turn(0.7), 1e-6) && way.at(2.5).abs_diff_eq(turn(0.5), 1e-6));
    }
}
