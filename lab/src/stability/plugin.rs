//! The same samples in the plugin, as a user has them: what the core does not see.
//!
//! A user cannot put a cloth into a state: so a start is reached by grabbing every vertex and letting go again a step later.
//! Pins move with the transform of the entity, and teleport one by one.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;
use std::time::Duration;

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
use bevy::math::DVec3;
use bevy::mesh::{Indices, MeshPlugin, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::physics::{StepOutcome, StepReport};
use bevy_cloth::plugin::{
    ClothError, ClothMaterial, ClothMesh, ClothPinTargets, ClothPins, ClothPlugin, ClothSolver, ClothState,
};
use indicatif::ProgressBar;
use serde::Serialize;

use super::sample::{PinMotion, STEPS, Sample};
use super::scene::Scene;
use super::survey::{Plan, Survey};
use super::trial::{Verdict, message};
use crate::report::{Table, percent};

/// A run in the plugin.
#[derive(Clone, Debug, Serialize)]
pub struct PluginRun {
    /// What was done.
    #[serde(flatten)]
    pub plan: Plan,
    /// The last step of each frame, counted.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// The first thing that was wrong.
    pub wrong: Option<String>,
}

/// Does the first runs that are drawn at random, in order, side by side: in threads of their own, for an app may wait for the
/// thread pool that steps its cloth, whose threads must not be waiting for an app.
pub fn survey(survey: &Survey, runs: u64, progress: &ProgressBar) -> Vec<PluginRun> {
    let run = |plan: &Plan| {
        let plan = plan.clone();
        let mut verdict = Verdict::default();
        let result = catch_unwind(AssertUnwindSafe(|| run(&plan, &mut verdict)));
        let wrong = result.unwrap_or_else(|panic| Err(format!("panic: {}", message(&*panic)))).err();
        progress.inc(1);
        PluginRun { plan, verdict, wrong }
    };
    let plans = survey.random(runs);
    let share = plans.len().div_ceil(thread::available_parallelism().map_or(1, NonZeroUsize::get)).max(1);
    thread::scope(|scope| {
        let start = |plans| scope.spawn(move || -> Vec<_> { <[Plan]>::iter(plans).map(run).collect() });
        let threads: Vec<_> = plans.chunks(share).map(start).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("panics are caught")).collect()
    })
}

/// Says what is wrong first.
fn run(plan: &Plan, verdict: &mut Verdict) -> Result<(), String> {
    let (sample, scene) = (&plan.sample, Scene::new(&plan.sample));
    // Half of the apps step once a frame, whatever its length; half in fixed steps, as is usual.
    let fixed = plan.index.is_multiple_of(2);
    let mut app = app(sample, fixed);
    let cloth = spawn(&mut app, sample, &scene);
    let mut time = 0.0;
    for step in 0..STEPS {
        let dt = sample.dt_of(step);
        time += dt;
        let frame = if fixed && dt == sample.dt {
            TimeUpdateStrategy::FixedTimesteps(1)
        } else {
            TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(dt))
        };
        app.insert_resource(frame);
        move_pins(&mut app, cloth, &scene, sample, step, time);
        app.update();
        let told = check(&app, cloth).map_err(|wrong| format!("frame {step}: {wrong}"))?;
        verdict.count(&told, sample.substeps);
    }
    Ok(())
}

fn app(sample: &Sample, fixed: bool) -> App {
    let plugin = if fixed { ClothPlugin::default() } else { ClothPlugin::new(Update) };
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, plugin))
        .insert_resource(Time::<Fixed>::from_seconds(sample.dt))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    // A hitch is not cut short.
    app.world_mut().resource_mut::<Time<Virtual>>().set_max_delta(Duration::from_secs(10));
    app.finish();
    app.cleanup();
    app
}

/// The cloth, started, with every vertex held where it is to begin.
fn spawn(app: &mut App, sample: &Sample, scene: &Scene) -> Entity {
    let mesh = mesh(scene);
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let away = scene.away.as_vec3();
    let bundle = (
        Mesh3d(mesh),
        Transform::from_translation(away),
        ClothMesh { weld_distance: Some(0.0), bending: sample.bending_model.into(), ..default() },
        ClothMaterial(sample.fabric()),
        ClothSolver(sample.settings()),
        ClothPins::indices(scene.held.clone()),
        // What a visible mesh has: writing back keeps it up to date.
        Aabb::default(),
    );
    let cloth = app.world_mut().spawn(bundle).id();
    app.update();
    let places = scene.positions.iter().map(|&x| (x - scene.away).as_vec3());
    let targets: BTreeMap<u32, Vec3> = (0..).zip(places).collect();
    app.world_mut().entity_mut(cloth).insert(ClothPinTargets(targets));
    cloth
}

fn move_pins(app: &mut App, cloth: Entity, scene: &Scene, sample: &Sample, step: u32, time: f64) {
    if step == 0 {
        return;
    }
    let moved = scene.pins_at(step, time);
    let mut entity = app.world_mut().entity_mut(cloth);
    match (sample.pins, moved.first()) {
        (PinMotion::Moving(_), Some((_, by))) => {
            let place = (scene.away + *by).as_vec3();
            entity.insert((ClothPinTargets::default(), Transform::from_translation(place)));
        }
        (PinMotion::Teleporting(_), _) => {
            let place =
                |(vertex, by): (u32, DVec3)| (vertex, (scene.positions[vertex as usize] - scene.away + by).as_vec3());
            entity.insert(ClothPinTargets(moved.into_iter().map(place).collect()));
        }
        _ => {
            entity.insert(ClothPinTargets::default());
        }
    }
}

/// What the cloth shows must be finite, and it must tell of rejected steps and of nothing else.
fn check(app: &App, cloth: Entity) -> Result<StepReport, String> {
    let entity = app.world().entity(cloth);
    let error = entity.get::<ClothError>();
    let state = entity.get::<ClothState>().ok_or_else(|| format!("no cloth, but {error:?}"))?;
    let report = state.last_report().ok_or("no step was taken")?;
    match (&report.outcome, error) {
        (StepOutcome::Accepted, None) | (StepOutcome::Rejected(_), Some(ClothError::Diverged { .. })) => {}
        (outcome, error) => return Err(format!("the step was {outcome:?}, but the cloth shows {error:?}")),
    }
    let mesh = app.world().resource::<Assets<Mesh>>().get(state.own_mesh()).ok_or("no mesh")?;
    for attribute in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL] {
        match mesh.attribute(attribute) {
            Some(VertexAttributeValues::Float32x3(values)) if values.as_flattened().iter().all(|v| v.is_finite()) => {}
            _ => return Err(format!("`{}` is not finite", attribute.name)),
        }
    }
    let bounds = entity.get::<Aabb>().ok_or("no bounds")?;
    if !(bounds.center.is_finite() && bounds.half_extents.is_finite()) {
        return Err(format!("the bounds are {bounds:?}"));
    }
    Ok(*report)
}

/// The sheet as an asset.
fn mesh(scene: &Scene) -> Mesh {
    let positions: Vec<_> = scene.sheet.positions.iter().map(|p| p.as_vec3().to_array()).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, scene.sheet.uvs.clone())
        .with_inserted_indices(Indices::U32(scene.sheet.triangles.as_flattened().to_vec()))
}

/// What came out, for the reader.
pub fn table(runs: &[PluginRun]) -> Table {
    let mut table = Table::new("in-the-plugin number right wrong fallbacks clamps rejected");
    for (name, fixed) in [("fixed steps", true), ("a step a frame", false)] {
        let of = || runs.iter().filter(move |run| run.plan.index.is_multiple_of(2) == fixed);
        let substeps: f64 = of().map(|run| f64::from(run.verdict.substeps)).sum();
        let share = |count: fn(&Verdict) -> u32| of().map(|run| f64::from(count(&run.verdict))).sum::<f64>() / substeps;
        let wrong = of().filter(|run| run.wrong.is_some()).count();
        if substeps > 0.0 {
            table.row([
                name.to_string(),
                of().count().to_string(),
                (of().count() - wrong).to_string(),
                wrong.to_string(),
                percent(share(|verdict| verdict.fallbacks)),
                percent(share(|verdict| verdict.velocity_clamps)),
                of().map(|run| run.verdict.rejected).sum::<u32>().to_string(),
            ]);
        }
    }
    table
}
