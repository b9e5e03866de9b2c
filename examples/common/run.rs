//! Runs a scene the best way the machine allows.

use crate::{
    host::{NO_ADAPTER_HINT, find_adapter, has_display},
    off_screen, windowed,
};
use bevy::prelude::*;
use std::path::PathBuf;

/// How to run, from the command line.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Name of the example, for files and the window's title.
    pub name: &'static str,
    /// What is shown, for the summary.
    pub scene: String,
    /// Do not open a window.
    pub headless: bool,
    /// Draw pictures when there is no window.
    pub pictures: bool,
    /// Frames until the end.
    pub frames: Option<u32>,
    /// Folder for pictures and meshes.
    pub out: PathBuf,
    /// File for the figures.
    pub json: Option<PathBuf>,
}

/// Runs the scene that `add_scene` adds to the app: in a window, else off-screen to pictures and a mesh, else, without
/// any graphics adapter, to a mesh only. An error is what to tell the user.
pub fn run(options: RunOptions, add_scene: impl FnOnce(&mut App)) -> Result<(), String> {
    let adapter = if options.pictures { find_adapter() } else { None };
    if options.pictures && adapter.is_none() {
        println!("{NO_ADAPTER_HINT}");
    }
    match adapter {
        Some(adapter) if !options.headless && has_display() => windowed::run(options, adapter, add_scene),
        adapter => off_screen::run(options, adapter, add_scene),
    }
}
