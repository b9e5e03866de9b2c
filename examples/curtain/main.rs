//! A ball flies into a curtain.

mod ball;
mod scene;
#[cfg(test)]
mod tests;

use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use clap::Parser;
use example_common::cli::RunArgs;
use scene::CurtainPlugin;

/// Throws a ball into a curtain: in a window, or off-screen to pictures and a mesh.
#[derive(Parser)]
#[command(name = "curtain")]
struct Cli {
    #[command(flatten)]
    run: RunArgs,
}

fn main() -> AppExit {
    let Cli { run } = Cli::parse();
    let fabric = run.fabric.unwrap_or_else(Fabric::cotton);
    run.show("curtain", CurtainPlugin { fabric, cells_per_pleat: 8 })
}
