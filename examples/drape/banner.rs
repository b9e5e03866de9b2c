//! The default scene: a banner on a rod, let go as if a gust had lifted it.

use crate::{
    model::{Model, ModelPlugin},
    rod,
};
use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use example_common::{
    banner::{HUNG_WIDTH, NODE, RINGS},
    orbit_camera::OrbitCamera,
    scene::SceneCamera,
    stage::Stage,
};
use std::f32::consts::FRAC_PI_2;

/// Height of the rings above the ground in metres.
const HEIGHT: f32 = 2.15;

/// How far the gust has lifted the banner, in radians.
const LIFT: f32 = 1.2;

const RING_RADIUS: f32 = 0.03;

pub struct BannerPlugin {
    pub fabric: Fabric,
}

impl Plugin for BannerPlugin {
    fn build(&self, app: &mut App) {
        let model = Model {
            node: Some(NODE.into()),
            transform: Transform::from_xyz(0.0, HEIGHT, 0.0).with_rotation(Quat::from_rotation_x(-LIFT)),
            // The pleats come from the rings, not from the fabric.
            rest_flat: true,
            framed: false,
            ..Model::new("banner.glb", self.fabric)
        };
        app.add_plugins(ModelPlugin(model)).add_systems(Startup, build);
    }
}

fn build(world: &mut World) {
    let camera = OrbitCamera { focus: Vec3::new(0.0, 1.14, 0.05), distance: 3.2, yaw: 0.48, pitch: 0.05 };
    let stage = Stage { floor: Vec3::ZERO, radius: 1.6, yaw: camera.yaw };
    let camera = world.spawn(camera).id();
    world.insert_resource(SceneCamera(camera));
    stage.build(world, camera);

    let ring_centre = HEIGHT + RING_RADIUS;
    let rod_centre = ring_centre + RING_RADIUS - 1.5 * rod::RADIUS;
    rod::build(world, Vec3::new(0.0, rod_centre, 0.0), HUNG_WIDTH + 0.28);

    let brass = rod::brass(world);
    let sideways = Quat::from_rotation_z(FRAC_PI_2);
    let ring = rod::mesh(world, Torus { minor_radius: 0.004, major_radius: RING_RADIUS });
    for nth in 0..RINGS {
        let x = HUNG_WIDTH * (nth as f32 / (RINGS - 1) as f32 - 0.5);
        world.spawn((ring.clone(), brass.clone(), Transform::from_xyz(x, ring_centre, 0.0).with_rotation(sideways)));
    }
}
