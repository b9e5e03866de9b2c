//! A scene without a window: the same frames every time, to pictures, a mesh and figures.

use crate::{
    capture::{aim_at_image, take_picture},
    export::write_cloths,
    host::Adapter,
    orbit_camera::OrbitCameraPlugin,
    plugins,
    run::RunOptions,
    scene::{SceneCamera, ScenePlugin, SceneState, cloth_error},
    summary::{StepFiguresPlugin, Summary},
};
use bevy::{app::PluginsState, prelude::*, tasks::tick_global_task_pools_on_main_thread, time::TimeUpdateStrategy};
use bevy_cloth::prelude::*;
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    path::Path,
    time::{Duration, Instant},
};

/// Steps per second of game time; one step is one frame.
const FRAME_RATE: f64 = 60.0;

/// Frames when the user does not say.
const DEFAULT_FRAMES: u32 = 300;

/// Pictures per run, evenly spread; the last frame is one of them.
const PICTURES: u32 = 4;

/// How long assets may take to load.
const LOADING_LIMIT: Duration = Duration::from_secs(60);

/// Runs the frames asked for and writes what came out.
pub fn run(options: RunOptions, adapter: Option<Adapter>, add_scene: impl FnOnce(&mut App)) -> Result<(), String> {
    create_folder(&options.out)?;
    let adapter_name = adapter.as_ref().map(|adapter| adapter.name.clone());
    let mut app = start(adapter, add_scene)?;
    let camera = app.world().resource::<SceneCamera>().0;
    if adapter_name.is_some() {
        aim_at_image(app.world_mut(), camera);
    }

    let frames = options.frames.unwrap_or(DEFAULT_FRAMES);
    let picture_frames: Vec<u32> = (1..=PICTURES).map(|nth| (frames * nth).div_ceil(PICTURES)).collect();
    let mut pictures = Vec::new();
    let bar = progress_bar(frames);
    for frame in 1..=frames {
        if let Err(problem) = step(&mut app) {
            bar.abandon();
            return Err(format!("frame {frame}: {problem}"));
        }
        if adapter_name.is_some() && picture_frames.contains(&frame) {
            stop_time(&mut app);
            let path = options.out.join(format!("{}-{frame:04}.png", options.name));
            take_picture(&mut app, camera, &path)?;
            pictures.push(path);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();

    let mesh = options.out.join(format!("{}.glb", options.name));
    write_cloths(app.world_mut(), &mesh)?;

    let mut summary = Summary::of(app.world_mut(), &options.scene);
    summary.adapter = adapter_name;
    summary.pictures = pictures;
    summary.mesh = Some(mesh);
    println!("{summary}");
    for file in summary.pictures.iter().chain(&summary.mesh) {
        println!("wrote {}", file.display());
    }
    match options.json {
        Some(path) => summary.write_json(&path),
        None => Ok(()),
    }
}

/// The scene, complete, before its first step; without an adapter nothing can be drawn.
pub fn start(adapter: Option<Adapter>, add_scene: impl FnOnce(&mut App)) -> Result<App, String> {
    let mut app = App::new();
    // Pictures show the state after a step, not one between two steps.
    app.add_plugins((plugins::off_screen(adapter), ClothPlugin::default().without_interpolation()))
        .add_plugins((ScenePlugin, OrbitCameraPlugin, StepFiguresPlugin))
        .insert_resource(Time::<Fixed>::from_hz(FRAME_RATE));
    stop_time(&mut app);
    add_scene(&mut app);
    while app.plugins_state() == PluginsState::Adding {
        tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    load(&mut app)?;
    Ok(app)
}

/// One step, which is one frame.
pub fn step(app: &mut App) -> Result<(), String> {
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.update();
    cloth_error(app.world_mut()).map_or(Ok(()), Err)
}

fn create_folder(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("cannot create the folder {}: {error}", folder.display()))
}

fn stop_time(app: &mut App) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
}

/// Updates with the time standing still until the scene is complete, so that every run starts the same.
fn load(app: &mut App) -> Result<(), String> {
    let start = Instant::now();
    loop {
        app.update();
        match app.world().resource::<SceneState>() {
            SceneState::Loading if start.elapsed() > LOADING_LIMIT => return Err("loading took too long".into()),
            SceneState::Loading => std::thread::sleep(Duration::from_millis(1)),
            SceneState::Ready => return Ok(()),
            SceneState::Failed(reason) => return Err(reason.clone()),
        }
    }
}

fn progress_bar(frames: u32) -> ProgressBar {
    let bar = ProgressBar::new(frames.into());
    if let Ok(style) = ProgressStyle::with_template("{bar:40} frame {pos}/{len}, {per_sec}, {eta} to go") {
        bar.set_style(style);
    }
    bar
}
