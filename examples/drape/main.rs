//! The main example: a cloth hangs, swings and drapes.
//!
//! `cargo run --release --example drape` opens a window, or without a display writes pictures and a mesh.
//! `cargo run --release --example drape -- PATH --node NAME` turns a mesh of any glTF file into cloth.

mod banner;
mod cli;
mod framing;
mod model;
mod rod;
mod sheet;

use bevy::prelude::*;
use clap::Parser;
use cli::Cli;
use example_common::run::{RunOptions, run};
use model::{Model, ModelPlugin};

fn main() -> AppExit {
    match drape(Cli::parse()) {
        Ok(()) => AppExit::Success,
        Err(problem) => {
            eprintln!("error: {problem}");
            AppExit::error()
        }
    }
}

fn drape(cli: Cli) -> Result<(), String> {
    let (scene, model) = match &cli.path {
        Some(path) => (path.display().to_string(), Some(Model::from_cli(&cli, path)?)),
        None if cli.resolution.is_some() => ("sheet".into(), None),
        None => ("banner".into(), None),
    };
    let options = RunOptions {
        name: "drape",
        scene,
        headless: cli.headless || cli.no_pictures,
        pictures: !cli.no_pictures,
        frames: cli.frames,
        out: cli.out,
        json: cli.json,
    };
    run(options, |app| {
        match (model, cli.resolution) {
            (Some(model), _) => app.add_plugins(ModelPlugin(model)),
            (None, Some(resolution)) => app.add_plugins(sheet::SheetPlugin { resolution, fabric: cli.fabric }),
            (None, None) => app.add_plugins(banner::BannerPlugin { fabric: cli.fabric }),
        };
    })
}
