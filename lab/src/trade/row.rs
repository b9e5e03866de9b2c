//! What a method costs and how far it is from the truth.

use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use serde::Serialize;

use super::body::{Ruler, advance, body};
use super::errors::{Errors, Trace, mean_square_distance};
use super::method::{Family, Method};
use super::reference::{FRAMES, Reference};
use super::scene::{Scene, Stage};
use crate::report::{Table, figure, percent};

/// Frames that a cloth put to rest is left to itself: two seconds.
const SETTLING_FRAMES: u32 = 120;

/// A method in a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What was simulated.
    pub scene: Scene,
    /// Vertices along a side.
    pub side: u32,
    /// Vertices.
    pub vertices: usize,
    /// What the method is a variant of.
    pub family: Family,
    /// Which variant.
    pub method: String,
    /// Which line of a picture.
    #[serde(skip)]
    pub line: u32,
    /// Time of a frame on one thread, ms: the mean over the frames, of each the least time.
    pub ms: f64,
    /// How far it is from the truth.
    #[serde(flatten)]
    pub errors: Errors,
}

/// Runs a method.
pub fn measure(stage: &Stage, method: &Method, reference: &Reference, repeat: u32, progress: &ProgressBar) -> Row {
    let mut ruler = Ruler::new(stage);
    let mut times = vec![Duration::MAX; FRAMES as usize];
    let mut motion = Trace::default();
    for run in 0..repeat {
        let mut body = body(stage, Stage::fabric(), method.kind);
        for frame in 0..FRAMES {
            let start = Instant::now();
            advance(&mut *body, stage, frame);
            let time = &mut times[frame as usize];
            *time = start.elapsed().min(*time);
            if run == 0 {
                motion.push(&*body, &mut ruler);
            }
        }
    }
    progress.inc(1);
    // The first step finds room for what the others need.
    let interval = method.kind.interval() as usize;
    let count = (times.len() / interval - 1) * interval;
    let ms = 1e3 * times[interval..][..count].iter().sum::<Duration>().as_secs_f64() / count as f64;
    let row = Row {
        scene: stage.scene,
        side: stage.side,
        vertices: stage.shape.vertex_count(),
        family: method.family,
        method: method.name.clone(),
        line: method.line,
        ms,
        errors: Errors { settled_m: settled(stage, method, reference), ..motion.errors(&reference.motion, &ruler) },
    };
    progress.inc(1);
    row
}

/// How far from rest a method leads that begins there.
fn settled(stage: &Stage, method: &Method, reference: &Reference) -> f64 {
    let mut body = body(stage, Stage::settling_fabric(), method.kind);
    body.place(&reference.settled);
    for _ in 0..SETTLING_FRAMES {
        body.frame();
    }
    mean_square_distance(body.positions(), &reference.settled).sqrt()
}

/// Steps that the progress of a row counts.
pub const STEPS: u64 = 2;

/// The rows for the reader.
pub fn table(rows: &[&Row]) -> Table {
    let mut table = Table::new("method variant ms motion/mm settled/mm stretch energy");
    for row in rows {
        table.row([
            row.family.title().into(),
            row.method.clone(),
            figure(row.ms),
            figure(1e3 * row.errors.motion_m),
            figure(1e3 * row.errors.settled_m),
            percent(row.errors.stretch),
            percent(row.errors.energy),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trade::cache::Cache;

    #[test]
    fn a_level_is_near_the_truth_and_the_baseline_comes_nearer_with_substeps() {
        let folder = std::env::temp_dir().join(format!("lab-row-{}", std::process::id()));
        let stage = Stage::new(Scene::Sheet, 8);
        let reference = Reference::new(&stage, &Cache::new(&folder).unwrap()).unwrap();
        std::fs::remove_dir_all(folder).unwrap();
        let row = |method: &Method| measure(&stage, method, &reference, 1, &ProgressBar::hidden());

        let level = row(&Family::Level.methods()[1]);
        let Errors { motion_m, settled_m, stretch, energy } = level.errors;
        assert!(level.ms > 0.0 && (1e-4..0.05).contains(&motion_m), "{level:?}");
        assert!(settled_m < 1e-4 && energy < 0.02 && stretch < 0.5, "{level:?}");
        let xpbd = Family::Xpbd.methods();
        let (coarse, fine) = (row(&xpbd[1]).errors, row(&xpbd[5]).errors);
        assert!(fine.motion_m < 0.5 * coarse.motion_m && fine.motion_m < 0.02, "{coarse:?} {fine:?}");
        assert!(fine.settled_m < coarse.settled_m && fine.settled_m < 1e-3, "{coarse:?} {fine:?}");
    }
}
