//! The default scene: a banner on a rod, let go as if a gust had lifted it.

use crate::model::{Model, ModelPlugin};
use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use example_common::{
    banner::{HUNG_WIDTH, NODE, RINGS},
    orbit_camera::OrbitCamera,
    rod,
    scene::SceneCamera,
    stage::Stage,
};

/// Height of the rings above the ground in metres.
const HEIGHT: f32 = 2.15;

/// How far the gust has lifted the banner, in radians.
const LIFT: f32 = 1.2;

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

    rod::build_with_rings(world, HEIGHT, HUNG_WIDTH, RINGS);
}
