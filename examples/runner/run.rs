//! Where the runner is, and which way it looks.

use bevy::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// In metres per second.
pub const SPEED: f32 = 3.0;
/// Of the circle, in metres.
const CIRCLE: f32 = 1.4;
/// How long it takes to reach its speed, in seconds.
const SPURT: f32 = 0.6;
/// Runs so long before it turns about, and how long that takes, in seconds.
const LAP: f32 = 2.5;
const ABOUT: f32 = 0.4;

/// Counts the seconds of its run.
#[derive(Component, Default)]
pub struct Runner(pub f32);

impl Runner {
    /// Its place after so many seconds, its feet at the origin, forwards along +z.
    pub fn place(&self) -> Transform {
        let Self(time) = *self;
        let (lap, since) = ((time / LAP).floor(), time % LAP);
        // Forwards on even laps, back on odd ones; about at the beginning of each but the first.
        let turned = if lap < 1.0 { 1.0 } else { (since / ABOUT).min(1.0) };
        let about = PI * (lap - 1.0 + turned);
        let angle = way(time) / CIRCLE;
        let turn = Quat::from_rotation_y(angle);
        Transform::from_translation(turn * (CIRCLE * Vec3::Z))
            .with_rotation(turn * Quat::from_rotation_y(FRAC_PI_2 + about))
    }
}

/// Along the circle, in metres: a lap forwards, a lap back.
fn way(time: f32) -> f32 {
    let spurt = time.min(SPURT);
    let early = SPEED * (0.5 * spurt * spurt / SPURT + (time.min(LAP) - SPURT).max(0.0));
    let later = (time - LAP).max(0.0);
    // From +1 to -1 and back, evenly while it turns about.
    let signed = |lap: u32, since: f32| {
        let sign = if lap.is_multiple_of(2) { -1.0 } else { 1.0 };
        let turning = since.min(ABOUT);
        sign * (turning * turning / ABOUT - turning + (since - ABOUT).max(0.0))
    };
    let laps = (later / LAP) as u32;
    let whole: f32 = (0..laps).map(|lap| signed(lap, LAP)).sum();
    early + SPEED * (whole + signed(laps, later - laps as f32 * LAP))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_never_jumps_and_is_never_faster_than_it_says() {
        let frame = 1.0 / 240.0;
        for k in 0..3000_u16 {
            let time = f32::from(k) * frame;
            let [now, next] = [time, time + frame].map(|time| Runner(time).place());
            let speed = now.translation.distance(next.translation) / frame;
            assert!(speed < 1.02 * SPEED, "{speed} m/s at {time} s");
            let turned = now.rotation.angle_between(next.rotation) / frame;
            assert!(turned < 1.2 * (PI / ABOUT + SPEED / CIRCLE), "{turned} rad/s at {time} s");
        }
    }

    #[test]
    fn it_looks_where_it_runs() {
        for time in [1.5, LAP + 1.5, 2.0 * LAP + 1.5] {
            let [now, next] = [time, time + 0.01].map(|time| Runner(time).place());
            let way = (next.translation - now.translation).normalize();
            assert!(way.dot(now.rotation * Vec3::Z) > 0.99, "{time} s");
        }
    }
}
