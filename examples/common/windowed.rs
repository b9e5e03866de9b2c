//! A scene in a window, with an orbit camera, keys and an overlay.

use crate::{
    controls::ControlsPlugin,
    host::Adapter,
    orbit_camera::OrbitCameraPlugin,
    overlay::OverlayPlugin,
    plugins,
    run::RunOptions,
    scene::{ScenePlugin, SceneState},
    summary::{StepFiguresPlugin, Summary},
};
use bevy::{ecs::message::MessageCursor, prelude::*};
use bevy_cloth::prelude::*;

#[derive(Resource, Clone)]
struct Run {
    options: RunOptions,
    adapter: String,
}

/// Runs until the window is closed.
pub fn run(options: RunOptions, adapter: Adapter, add_scene: impl FnOnce(&mut App)) -> Result<(), String> {
    let run = Run { options, adapter: adapter.name.clone() };
    let mut app = App::new();
    app.add_plugins((plugins::windowed(run.options.name, adapter), ClothPlugin::default()))
        .add_plugins((ClothDiagnosticsPlugin, ClothDebugPlugin))
        .add_plugins((ScenePlugin, OrbitCameraPlugin, ControlsPlugin, OverlayPlugin, StepFiguresPlugin))
        .insert_resource(run)
        .add_systems(Startup, draw_no_gizmos)
        .add_systems(Last, (stop, summarise).chain());
    add_scene(&mut app);
    match app.run() {
        AppExit::Success => Ok(()),
        AppExit::Error(_) => Err("the run failed".into()),
    }
}

/// The keys switch them on.
fn draw_no_gizmos(mut gizmos: ResMut<GizmoConfigStore>) {
    let (_, shown) = gizmos.config_mut::<ClothGizmos>();
    *shown = ClothGizmos { edges: false, pins: false, normals: false, stretch: false, ..default() };
}

/// Ends the run when the scene cannot be shown or, once it is complete, when the frames asked for are over.
fn stop(state: Res<SceneState>, run: Res<Run>, mut frames: Local<u32>, mut exit: MessageWriter<AppExit>) {
    if let SceneState::Failed(reason) = &*state {
        error!("{reason}");
        exit.write(AppExit::error());
    } else if *state == SceneState::Ready {
        *frames += 1;
        if run.options.frames.is_some_and(|limit| *frames >= limit) {
            exit.write(AppExit::Success);
        }
    }
}

/// Prints the figures of the run at its end.
fn summarise(world: &mut World, mut exits: Local<MessageCursor<AppExit>>) {
    let ends = exits.read(world.resource::<Messages<AppExit>>()).next().is_some();
    if !ends || *world.resource::<SceneState>() != SceneState::Ready {
        return;
    }
    let run = world.resource::<Run>().clone();
    let summary = Summary { adapter: Some(run.adapter), ..Summary::of(world, &run.options.scene) };
    println!("{summary}");
    if let Some(Err(problem)) = run.options.json.map(|path| summary.write_json(&path)) {
        error!("{problem}");
        world.write_message(AppExit::error());
    }
}
