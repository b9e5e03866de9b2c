//! What colliders cost that are far away.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Collider, Pose, SolverSettings};

use super::row::{Row, Wanted};
use super::solid::Solid;
use super::timing::{Timed, side_by_side};
use crate::bench::statistics::Frames;
use crate::scenes::{DT, Meshing, Sheet};

/// Numbers of colliders.
const COUNTS: [u32; 3] = [0, 1, 1000];

impl Timed for Cloth {
    fn frame(&mut self, frame: &mut dyn FnMut(&mut dyn FnMut())) {
        frame(&mut || {
            self.step(DT);
        });
    }
}

/// The hung sheet of n × n vertices, and so many balls where it never comes.
fn scene(n: u32, colliders: u32) -> Cloth {
    let mut cloth = Sheet::new(n, Meshing::Grid).hang(SolverSettings::default());
    let place = |i: u32| DVec3::new(f64::from(i % 10), f64::from(i / 100), f64::from(i / 10 % 10)) * 2.0;
    let ball = |i: u32| {
        let pose = Pose::at(place(i) + DVec3::new(20.0, 0.0, 0.0));
        Collider::fixed(i.into(), Solid::Ball { radius: 0.3 }.shape(), pose, 0.5)
    };
    cloth.set_colliders((0..colliders).map(ball)).expect("colliders");
    cloth
}

/// The time of steps with far colliders in that of those without.
pub fn rows(n: u32, frames: u32, repeat: u32) -> Vec<Row> {
    let (_, Frames(times)) = side_by_side(frames, repeat, || COUNTS.map(|count| scene(n, count)));
    // All frames are the same in all scenes and runs: their sum is what says the most.
    let [none, one, many] = times.map(|times| times.iter().sum::<core::time::Duration>().as_secs_f64());
    let scene = format!("far colliders, hung {n}²");
    vec![
        Row::new(&scene, "time with one", one / none, Wanted::AtMost(1.02)),
        Row::new(&scene, "time with a thousand", many / none, Wanted::AtMost(1.1)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_colliders_change_nothing() {
        let [mut alone, mut far] = [0, 1000].map(|count| scene(6, count));
        assert_eq!(far.colliders().len(), 1000);
        for _ in 0..30 {
            alone.step(DT);
            far.step(DT);
        }
        assert_eq!(alone.positions(), far.positions());
        assert!(rows(6, 4, 2).iter().all(|row| row.measured > 0.1));
    }
}
