//! A table cloth falls over a laid table.

mod dishes;
mod scene;
mod table;
#[cfg(test)]
mod tests;

use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use clap::Parser;
use example_common::cli::RunArgs;
use scene::TableclothPlugin;

/// Drops a table cloth over a laid table: in a window, or off-screen to pictures and a mesh.
#[derive(Parser)]
#[command(name = "tablecloth")]
struct Cli {
    /// Vertices along each side of the cloth.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=200))]
    resolution: u32,

    #[command(flatten)]
    run: RunArgs,
}

fn main() -> AppExit {
    let Cli { resolution, run } = Cli::parse();
    let fabric = run.fabric.unwrap_or_else(Fabric::cotton);
    run.show("tablecloth", TableclothPlugin { fabric, resolution })
}
