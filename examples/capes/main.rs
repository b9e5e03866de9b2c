//! Capes on figures of capsules that walk.

mod cape;
mod figure;
mod gait;
mod scene;
#[cfg(test)]
mod tests;

use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, prelude::*};
use clap::Parser;
use example_common::cli::RunArgs;
use figure::Bodies;
use scene::CapesPlugin;

/// Walks figures with capes round a circle: in a window, or off-screen to pictures and a mesh.
#[derive(Parser)]
#[command(name = "capes")]
struct Cli {
    #[command(flatten)]
    run: RunArgs,
}

/// Every part of a figure has a collider of its own.
const BODIES: Bodies = Bodies {
    engine: |_| {},
    figure: |_| {},
    part: |part, capsule| {
        part.insert(ClothCollider::from(capsule));
    },
};

fn main() -> AppExit {
    let Cli { run } = Cli::parse();
    let fabric = run.fabric.unwrap_or_else(Fabric::wool);
    run.show("capes", CapesPlugin { fabric, bodies: BODIES, columns: 32 })
}
