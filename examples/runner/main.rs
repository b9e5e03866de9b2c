//! A figure as a game moves it: its root once a frame in `Update`, its limbs by an `AnimationPlayer`. It runs in a circle and turns
//! about now and then, and its cape goes along.

#[path = "../capes/cape.rs"]
mod cape;
#[path = "../capes/figure.rs"]
mod figure;
#[path = "../capes/gait.rs"]
mod gait;
mod run;
mod scene;
#[cfg(test)]
mod tests;

use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use clap::Parser;
use example_common::cli::RunArgs;
use scene::RunnerPlugin;

/// A figure that runs in `Update` and is animated, with a cape: in a window, or off-screen to pictures and a mesh.
#[derive(Parser)]
#[command(name = "runner")]
struct Cli {
    #[command(flatten)]
    run: RunArgs,
}

fn main() -> AppExit {
    let Cli { run } = Cli::parse();
    // Raised, so that the cape streams.
    let fabric = Fabric { air_drag: 2.5, ..run.fabric.unwrap_or_else(Fabric::wool) };
    run.show("runner", RunnerPlugin { fabric, columns: 28 })
}
