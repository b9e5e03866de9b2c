//! The whole plugin in an app without a window: what surrounds the solver, drawing aside.

use std::time::Instant;

use bevy::camera::primitives::Aabb;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::plugin::{ClothMaterial, ClothMesh, ClothPins, ClothPlugin, ClothSolver, ClothState, ClothSystems};
use indicatif::ProgressBar;
use serde::Serialize;

use super::case::Case;
use super::statistics::{Frames, Spread, median};
use crate::report::{Table, figure, percent};
use crate::scenes::{DT, Sheet, fabric};

/// Cost of an update of the app.
#[derive(Clone, Debug, Serialize)]
pub struct PluginRow {
    /// What was measured.
    #[serde(flatten)]
    pub case: Case,
    /// Vertices of all cloths together.
    pub vertices: usize,
    /// Updates, of one step each.
    pub frames: u32,
    /// Time of `App::update`, ms.
    pub update_ms: Spread,
    /// Median time of `ClothSystems::Collect`, ms.
    pub collect_ms: f64,
    /// Median time of `ClothSystems::Step`, ms.
    pub step_ms: f64,
    /// Median time of `ClothSystems::WriteBack`: positions, normals, bounds, ms.
    pub write_back_ms: f64,
    /// Median of the rest: `ClothSystems::Initialise`, assets, transforms, schedules, ms.
    pub other_ms: f64,
    /// Share of the median update that is not `ClothSystems::Step`.
    pub around: f64,
}

/// Runs a case in the current thread pool.
pub fn measure(case: Case, frames: u32, repeat: u32, progress: &ProgressBar) -> PluginRow {
    let mut times = run(case, frames, progress);
    for _ in 1..repeat {
        times = times.least(run(case, frames, progress));
    }
    let [update, collect, step, write_back, other] = &times.0;
    let (update_ms, step_ms) = (Spread::of(update), median(step));
    PluginRow {
        case,
        vertices: case.vertices(),
        frames,
        update_ms,
        collect_ms: median(collect),
        step_ms,
        write_back_ms: median(write_back),
        other_ms: median(other),
        around: 1.0 - step_ms / update_ms.median,
    }
}

/// Times of updates, and in them of collecting, stepping, writing back and the rest.
fn run(case: Case, frames: u32, progress: &ProgressBar) -> Frames<5> {
    let mut times = Frames::with_capacity(frames);
    let mut app = app(case, |_| {});
    for _ in 0..frames {
        let start = Instant::now();
        app.update();
        let update = start.elapsed();
        let Marks([begin, collected, stepped, initialised, written]) = *app.world().resource::<Marks>();
        let (collect, step, write_back) = (collected - begin, stepped - collected, written - initialised);
        times.push([update, collect, step, write_back, update.saturating_sub(collect + step + write_back)]);
        progress.inc(1);
    }
    times
}

/// When the last update collected, had done so and stepped, had stepped; when it wrote back, and had done so.
#[derive(Resource, Clone, Copy)]
struct Marks([Instant; 5]);

fn mark<const WHICH: usize>(mut marks: ResMut<Marks>) {
    marks.0[WHICH] = Instant::now();
}

/// An app in which the cloths hang, with what else `add` adds to it; every update is one step.
pub(super) fn app(case: Case, add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, ClothPlugin::default()))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1))
        .insert_resource(Time::<Fixed>::from_seconds(DT))
        .insert_resource(Marks([Instant::now(); 5]))
        .add_systems(
            FixedUpdate,
            (
                mark::<0>.before(ClothSystems::Collect),
                mark::<1>.after(ClothSystems::Collect).before(ClothSystems::Step),
                mark::<2>.after(ClothSystems::Step),
            ),
        )
        .add_systems(
            PostUpdate,
            (
                mark::<3>.after(ClothSystems::Initialise).before(ClothSystems::WriteBack),
                mark::<4>.after(ClothSystems::WriteBack),
            ),
        );

    let sheet = Sheet::new(case.side, case.meshing);
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(sheet.mesh());
    for _ in 0..case.cloths {
        app.world_mut().spawn((
            Mesh3d(mesh.clone()),
            ClothMesh::default(),
            ClothMaterial(fabric()),
            ClothSolver(case.quality.settings()),
            ClothPins::indices(sheet.corners),
            // What a visible mesh has: writing back keeps it up to date.
            Aabb::default(),
        ));
    }
    add(&mut app);
    app.finish();
    app.cleanup();
    // The cloths start in the first update; in no more than two, time does not pass.
    for _ in 0..3 {
        app.update();
    }
    assert_eq!(app.world_mut().query::<&ClothState>().iter(app.world()).count(), case.cloths, "every cloth starts");
    app
}

/// The rows for the reader.
pub fn table(rows: &[PluginRow]) -> Table {
    let mut table = Table::new("plugin threads update p95 collect step write-back other around-step");
    for row in rows {
        table.row([
            row.case.name(),
            row.case.threads.to_string(),
            figure(row.update_ms.median),
            figure(row.update_ms.p95),
            figure(row.collect_ms),
            figure(row.step_ms),
            figure(row.write_back_ms),
            figure(row.other_ms),
            percent(row.around),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_crowd_gives_a_sane_row() {
        let row = measure(Case { cloths: 2, ..Case::sheet(6) }, 10, 2, &ProgressBar::hidden());
        assert_eq!(row.vertices, 72);
        assert!(row.collect_ms > 0.0 && row.step_ms > 0.0 && row.write_back_ms > 0.0, "{row:?}");
        assert!(row.update_ms.median > row.step_ms && row.around > 0.0 && row.around < 1.0, "{row:?}");
        assert_eq!(table(&[row]).to_string().lines().count(), 2);
    }

    #[test]
    fn every_update_is_a_step() {
        let mut app = app(Case::sheet(6), |_| {});
        let height = |app: &mut App| {
            let world = app.world_mut();
            let state = world.query::<&ClothState>().single(world).expect("one cloth");
            state.cloth().positions().iter().map(|p| p.y).sum::<f64>()
        };
        for _ in 0..5 {
            let before = height(&mut app);
            app.update();
            assert!(height(&mut app) < before);
        }
    }
}
