//! The scene of `capes` with bodies of Avian: their colliders are those of the cloth too.
//!
//! `cargo run --release --features avian3d --example capes_avian`

mod cape;
mod figure;
mod gait;
mod scene;
#[cfg(test)]
mod tests;

use avian3d::prelude::{Collider, PhysicsPlugins, RigidBody};
use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, prelude::*};
use clap::Parser;
use example_common::cli::RunArgs;
use figure::Bodies;
use scene::CapesPlugin;

/// Walks figures of Avian's colliders with capes round a circle: in a window, or off-screen to pictures and a mesh.
#[derive(Parser)]
#[command(name = "capes_avian")]
struct Cli {
    #[command(flatten)]
    run: RunArgs,
}

/// A figure is a body; each of its parts has one of the body's colliders, marked as one for cloth.
const BODIES: Bodies = Bodies {
    engine: |app| {
        app.add_plugins(PhysicsPlugins::default());
    },
    figure: |figure| {
        figure.insert(RigidBody::Kinematic);
    },
    part: |part, capsule| {
        part.insert((Collider::capsule(capsule.radius, 2.0 * capsule.half_length), ClothPhysicsCollider));
    },
};

fn main() -> AppExit {
    let Cli { run } = Cli::parse();
    let fabric = run.fabric.unwrap_or_else(Fabric::wool);
    run.show("capes_avian", CapesPlugin { fabric, bodies: BODIES, columns: 32 })
}
