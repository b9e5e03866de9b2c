//! Times of scenes that are compared: side by side, so that a busy or a changing machine is so to all of them.

use std::time::Duration;

use cpu_time::ProcessTime;

use crate::bench::statistics::{Frames, median};

/// Something that is stepped.
pub trait Timed {
    /// Prepares a frame, takes it by `frame`, which measures, and looks at what came out.
    fn frame(&mut self, frame: &mut dyn FnMut(&mut dyn FnMut()));
}

/// Processor time of the frames of N scenes: of each frame the least of `repeat` runs. Frames take turns, the scene that
/// begins as well. The scenes of the last run come back.
pub fn side_by_side<S: Timed, const N: usize>(
    frames: u32,
    repeat: u32,
    scenes: impl Fn() -> [S; N],
) -> ([S; N], Frames<N>) {
    let run = || {
        let (mut scenes, mut times) = (scenes(), Frames::with_capacity(frames));
        for frame in 0..frames as usize {
            let mut taken = [Duration::ZERO; N];
            for turn in 0..N {
                let scene = (frame + turn) % N;
                scenes[scene].frame(&mut |step| {
                    let start = ProcessTime::now();
                    step();
                    taken[scene] = start.elapsed();
                });
            }
            times.push(taken);
        }
        (scenes, times)
    };
    let (mut last, mut times) = run();
    for _ in 1..repeat {
        let (scenes, again) = run();
        (last, times) = (scenes, times.least(again));
    }
    (last, times)
}

/// Median and mean, ms.
pub fn median_and_mean(times: &[Duration]) -> [f64; 2] {
    [median(times), 1e3 * times.iter().sum::<Duration>().as_secs_f64() / times.len() as f64]
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Spin(u64);

    impl Timed for Spin {
        fn frame(&mut self, frame: &mut dyn FnMut(&mut dyn FnMut())) {
            let mut sum = 0_u64;
            frame(&mut || (0..self.0).for_each(|i| sum = std::hint::black_box(sum ^ i)));
        }
    }

    #[test]
    fn what_does_more_takes_longer() {
        let (_, times) = side_by_side(8, 3, || [Spin(200_000), Spin(2_000_000)]);
        let [short, long] = times.0.each_ref().map(|times| median_and_mean(times));
        assert!(times.0.iter().all(|times| times.len() == 8));
        assert!(long[0] > 3.0 * short[0] && long[1] > 3.0 * short[1], "{short:?} {long:?}");
    }
}
