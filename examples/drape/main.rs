//! The main example: a cloth hangs, swings and drapes.
//!
//! `cargo run --release --example drape` opens a window, or without a display writes pictures and a mesh.
//! `cargo run --release --example drape -- PATH --node NAME` turns a mesh of any glTF file into cloth.

mod banner;
mod cli;
mod framing;
mod model;
mod sheet;

use bevy::prelude::*;
use clap::Parser;
use cli::Cli;
use example_common::{cli::exit, run::run};
use model::{Model, ModelPlugin};

fn main() -> AppExit {
    exit(drape(Cli::parse()))
}

fn drape(cli: Cli) -> Result<(), String> {
    let (scene, model) = match &cli.path {
        Some(path) => (path.display().to_string(), Some(Model::from_cli(&cli, path)?)),
        None if cli.resolution.is_some() => ("sheet".into(), None),
        None => ("banner".into(), None),
    };
    let fabric = cli.fabric();
    run(cli.run.options("drape", scene), |app| {
        match (model, cli.resolution) {
            (Some(model), _) => app.add_plugins(ModelPlugin(model)),
            (None, Some(resolution)) => app.add_plugins(sheet::SheetPlugin { resolution, fabric }),
            (None, None) => app.add_plugins(banner::BannerPlugin { fabric }),
        };
    })
}
