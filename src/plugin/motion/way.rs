//! The past of one part of a transform, and where that part was at a time.

use std::collections::VecDeque;

use bevy::math::{Quat, Vec3};

/// Relative change of a value within the fixed loop that counts as rounding: physics engines write a transform back that is not
/// the one they read to the last bit (a tick of Avian or Rapier moves a resting body by up to 4e-7).
const NOISE: f32 = 1e-5;
/// A change in a tick raises the confidence that ticks move this part, a tick without one lowers it by one.
const SURER: u8 = 2;
/// Confidence from which on a change outside of the fixed loop is taken for easing. An eased body shows no change in the ticks in
/// which its eased place happens to be that of the tick: at 144 frames a second and 64 Hz, one in four.
const SURE: u8 = 3;
/// Upper limit of the confidence: what ticks no longer move is seen as moved by frames after so many ticks at most.
const SUREST: u8 = 8;
/// Share of an interval beyond its end within which its last value is taken, so that rounding of times does not extrapolate.
const END: f64 = 1e-6;

/// A translation, rotation or scale.
pub(super) trait Part: Copy + PartialEq {
    /// The value at a share of the way to another.
    fn between(self, to: Self, share: f32) -> Self;
    /// The value after a share of the change that leads from one value to another.
    fn moved_on(self, from: Self, to: Self, share: f32) -> Self;
    /// Whether both differ by rounding only.
    fn is_noise(self, to: Self) -> bool;
}

impl Part for Vec3 {
    fn between(self, to: Self, share: f32) -> Self {
        self.lerp(to, share)
    }

    fn moved_on(self, from: Self, to: Self, share: f32) -> Self {
        self + (to - from) * share
    }

    fn is_noise(self, to: Self) -> bool {
        (to - self).abs().max_element() <= NOISE * self.abs().max_element().max(0.1)
    }
}

impl Part for Quat {
    fn between(self, to: Self, share: f32) -> Self {
        self.slerp(to, share)
    }

    fn moved_on(self, from: Self, to: Self, share: f32) -> Self {
        (Self::IDENTITY.slerp(to * from.inverse(), share) * self).normalize()
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
    /// Whether it was not led here by a motion from the entry before.
    jumped: bool,
}

/// The change that a frame made, and that of the frame before it: values with their times, s.
#[derive(Clone, Copy)]
pub(super) struct Change<T> {
    pub before: Option<(f64, T)>,
    pub from: (f64, T),
    pub to: (f64, T),
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
        Self { seen: value, past: VecDeque::from([Entry { time, value, jumped: false }]), by_ticks: 0 }
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
        }
        let count = self.past.len();
        let (before, from) = (count.checked_sub(2).map(|i| self.past[i]), self.past.back_mut());
        match from {
            Some(last) if stands || last.time >= time => {
                (last.time, last.value) = (time.max(last.time), value);
            }
            Some(last) => {
                let before = before.filter(|_| !last.jumped).map(|before| (before.time, before.value));
                let jumped = jumps(Change { before, from: (last.time, last.value), to: (time, value) });
                self.past.push_back(Entry { time, value, jumped });
            }
            None => self.past.push_back(Entry { time, value, jumped: false }),
        }
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
        self.past.push_back(Entry { time, value, jumped: false });
    }

    /// The value at a time: between those of the frames around it; beyond the last frame, and before a jump, as it went on before.
    pub fn at(&self, time: f64) -> T {
        let after = self.past.partition_point(|entry| entry.time <= time);
        let Some(now) = after.checked_sub(1).map(|index| self.past[index]) else {
            return self.past.front().map_or(self.seen, |first| first.value);
        };
        let next = self.past.get(after);
        if let Some(next) = next {
            let share = (time - now.time) / (next.time - now.time);
            if share > 1.0 - END {
                return next.value;
            }
            if !next.jumped {
                return if now.value == next.value { now.value } else { now.value.between(next.value, share as f32) };
            }
        }
        // A change that was a jump itself says nothing of how it went on.
        match after.checked_sub(2).map(|index| self.past[index]) {
            Some(before) if !now.jumped && before.value != now.value => {
                let share = (time - now.time) / (now.time - before.time);
                if share < END { now.value } else { now.value.moved_on(before.value, now.value, share as f32) }
            }
            _ => now.value,
        }
    }

    /// As [`at`](Self::at), but never beyond the last frame.
    pub fn at_most(&self, time: f64) -> T {
        self.at(self.past.back().map_or(time, |last| time.min(last.time)))
    }
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
        let jumps = |change: Change<Vec3>| change.from.1.distance(change.to.1) > 2.0;
        let mut way = Way::new(0.0, Vec3::ZERO);
        way.end_frame(1.0, Vec3::X, 0.0, jumps);
        way.end_frame(2.0, Vec3::new(2.0, 50.0, 0.0), 0.0, jumps);
        assert_eq!(way.at(1.5), Vec3::X * 1.5);
        assert_eq!(way.at(2.0), Vec3::new(2.0, 50.0, 0.0));
        assert_eq!(way.at(2.5), Vec3::new(2.0, 50.0, 0.0), "nothing is known of what follows a jump");
        way.end_frame(3.0, Vec3::new(3.0, 50.0, 0.0), 0.0, jumps);
        assert_eq!(way.at(2.5), Vec3::new(2.5, 50.0, 0.0));
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
        way.end_frame(1.0, Vec3::X * 2.0, 0.0, NEVER);
        way.tick(1.0, Vec3::X * 2.000001, false);
        assert!((way.at(0.5).x - 1.5).abs() < 1e-5);
    }

    #[test]
    fn turns_go_on_about_their_axis() {
        let turn = |angle: f32| Quat::from_rotation_y(angle);
        let mut way = Way::new(0.0, turn(0.0));
        way.end_frame(1.0, turn(0.2), 0.0, |_| false);
        assert!(way.at(1.5).abs_diff_eq(turn(0.3), 1e-6) && way.at(0.5).abs_diff_eq(turn(0.1), 1e-6));
    }
}
