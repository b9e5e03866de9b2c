//! Bevy's default plugins, set up for a window, for pictures without a window, or for neither.

use crate::host::Adapter;
use bevy::{
    app::PluginGroupBuilder,
    asset::UnapprovedPathMode,
    gltf::GltfPlugin,
    log::LogPlugin,
    prelude::*,
    render::{RenderPlugin, pipelined_rendering::PipelinedRenderingPlugin, settings::WgpuSettings},
    window::{ExitCondition, WindowPlugin},
    winit::WinitPlugin,
};
use bevy_cloth::prelude::ATTRIBUTE_CLOTH_PIN;

/// The repository's assets, wherever the example is run from.
const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets");

/// Log filter with a renderer. A software driver, OpenGL and a bare X server are welcome fallbacks here: no warnings
/// about what they lack. Assets that fail to load are reported by the scene.
const DRAWING_LOG: &str = "warn,wgpu=error,wgpu_hal::gles=off,naga=error,winit=error,bevy_asset::server=off,\
                           bevy_render::renderer=error,bevy_core_pipeline=error,bevy_pbr=error";

/// Log filter without a renderer: Bevy wonders about each part of it that is not there.
const NOT_DRAWING_LOG: &str = "warn,bevy_asset::server=off,bevy_render=off,bevy_gizmos_render=off,bevy_gltf=error";

/// Plugins for a window with this title.
pub fn windowed(title: &str, adapter: Adapter) -> PluginGroupBuilder {
    shared(Some(adapter))
        .set(WindowPlugin { primary_window: Some(Window { title: title.into(), ..default() }), ..default() })
}

/// Plugins without a window. The caller runs [`App::update`] itself. Without an adapter nothing is drawn, but
/// assets, scenes and materials work as usual.
pub fn off_screen(adapter: Option<Adapter>) -> PluginGroupBuilder {
    shared(adapter)
        .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
        .disable::<WinitPlugin>()
        // The same picture every time: each update draws what it has just simulated.
        .disable::<PipelinedRenderingPlugin>()
}

fn shared(adapter: Option<Adapter>) -> PluginGroupBuilder {
    let log = if adapter.is_some() { DRAWING_LOG } else { NOT_DRAWING_LOG };
    let settings = adapter.map_or_else(|| WgpuSettings { backends: None, ..default() }, |adapter| adapter.settings);
    DefaultPlugins
        .set(LogPlugin { filter: log.into(), ..default() })
        .set(RenderPlugin {
            render_creation: settings.into(),
            // What is drawn must not depend on how fast pipelines compile.
            synchronous_pipeline_compilation: true,
            ..default()
        })
        // A model named on the command line may lie anywhere.
        .set(AssetPlugin { file_path: ASSETS.into(), unapproved_path_mode: UnapprovedPathMode::Allow, ..default() })
        // Bevy strips the underscore of `_CLOTH_PIN`.
        .set(GltfPlugin::default().add_custom_vertex_attribute("CLOTH_PIN", ATTRIBUTE_CLOTH_PIN))
}
