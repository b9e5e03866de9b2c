//! Three figures on a circle.

use crate::{
    cape::Cape,
    figure::{self, Bodies, Figures},
};
use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, plugin::ClothSystems, prelude::*};
use example_common::{
    clock::{SceneClock, SceneReset},
    orbit_camera::OrbitCamera,
    scene::SceneCamera,
    stage::Stage,
};

/// Of the capes.
const COLOURS: [[f32; 3]; 3] = [[0.60, 0.07, 0.11], [0.10, 0.19, 0.45], [0.09, 0.34, 0.20]];

pub struct CapesPlugin {
    pub fabric: Fabric,
    pub bodies: Bodies,
    /// Cells of each cape from side to side.
    pub columns: usize,
}

impl Plugin for CapesPlugin {
    fn build(&self, app: &mut App) {
        let (fabric, bodies, columns) = (self.fabric, self.bodies, self.columns);
        (bodies.engine)(app);
        app.add_systems(Startup, move |world: &mut World| build(world, fabric, bodies, columns))
            .add_systems(FixedUpdate, walk.before(ClothSystems::Collect))
            .add_observer(restart)
            .add_observer(notice_jumps);
    }
}

fn build(world: &mut World, fabric: Fabric, bodies: Bodies, columns: usize) {
    let camera = OrbitCamera { focus: Vec3::new(0.0, 0.85, 0.0), distance: 3.9, yaw: 0.5, pitch: 0.2 };
    let stage = Stage { floor: Vec3::ZERO, radius: 2.2, yaw: camera.yaw };
    let camera = world.spawn(camera).id();
    world.insert_resource(SceneCamera(camera));
    stage.build(world, camera);
    world.spawn(ClothCollider::half_space(Dir3::Y));
    for (nth, colour) in COLOURS.into_iter().enumerate() {
        let share = nth as f32 / COLOURS.len() as f32;
        let figure = figure::build(world, share, bodies);
        Cape { fabric, colour, columns }.hang(world, figure);
    }
}

fn walk(clock: Res<SceneClock>, mut figures: Figures) {
    figures.pose(clock.0);
}

fn restart(_: On<SceneReset>, mut figures: Figures) {
    figures.pose(0.0);
}

/// No part goes as fast as this, unless it is put somewhere else; in metres per second.
const JUMP: f32 = 15.0;

/// After a reset the bodies are somewhere else without having gone there.
fn notice_jumps(made: On<Add, ClothCollider>, mut colliders: Query<&mut ClothCollider>) {
    if let Ok(mut collider) = colliders.get_mut(made.entity) {
        collider.teleport_speed = JUMP;
    }
}
