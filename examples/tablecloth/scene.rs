//! The cloth, held above the table by its corners, then let go.

use crate::{dishes, table};
use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, plugin::ClothSystems, prelude::*};
use example_common::{
    clock::SceneClock,
    orbit_camera::OrbitCamera,
    paint::{mix, paint, to_texture},
    props::{mesh, woven},
    scene::SceneCamera,
    sheet::sheet_mesh,
    stage::Stage,
};
use std::collections::BTreeMap;

/// Side of the cloth in metres.
const SIDE: f32 = 1.6;

/// Height of the corners while they are held, in metres.
const HEIGHT: f32 = 1.3;

/// How long they are held, in seconds.
pub const HELD: f32 = 1.05;

/// Squares of the pattern along the side of the cloth.
const SQUARES: f32 = 20.0;

pub struct TableclothPlugin {
    pub fabric: Fabric,
    /// Vertices along each side of the cloth.
    pub resolution: u32,
}

/// A cloth held by its corners for a while.
#[derive(Component)]
struct Held {
    corners: BTreeMap<u32, Vec3>,
}

impl Plugin for TableclothPlugin {
    fn build(&self, app: &mut App) {
        let (resolution, fabric) = (self.resolution, self.fabric);
        app.add_systems(Startup, move |world: &mut World| build(world, resolution, fabric))
            .add_systems(FixedUpdate, hold.before(ClothSystems::Collect));
    }
}

fn build(world: &mut World, resolution: u32, fabric: Fabric) {
    let camera = OrbitCamera { focus: Vec3::new(0.0, 0.62, 0.0), distance: 1.95, yaw: 0.5, pitch: 0.36 };
    let stage = Stage { floor: Vec3::ZERO, radius: 1.3, yaw: camera.yaw };
    let camera = world.spawn(camera).id();
    world.insert_resource(SceneCamera(camera));
    stage.build(world, camera);
    world.spawn(ClothCollider::half_space(Dir3::Y));
    table::build(world);
    dishes::build(world, table::HEIGHT);

    let look = woven(world, gingham(), Vec2::splat(0.5 * SQUARES));
    let mesh = mesh(world, sheet_mesh(SIDE, resolution));
    world.spawn((
        Name::new("Table cloth"),
        mesh,
        look,
        Transform::from_xyz(0.0, HEIGHT, 0.0),
        ClothMesh::default(),
        ClothMaterial(fabric),
        // What lies between the vertices keeps clear of edges too.
        ClothContact { thickness: 0.008, ..default() },
        ClothPinTargets::default(),
        Held { corners: corners(resolution) },
    ));
}

/// Holds the corners, also after a reset, and lets them go.
fn hold(clock: Res<SceneClock>, mut cloths: Query<(&Held, &mut ClothPinTargets)>) {
    for (held, mut targets) in &mut cloths {
        match (clock.0 < HELD, targets.is_empty()) {
            (true, true) => targets.0.clone_from(&held.corners),
            (false, false) => targets.0.clear(),
            _ => {}
        }
    }
}

/// Where the corners are in the cloth's space.
fn corners(resolution: u32) -> BTreeMap<u32, Vec3> {
    let last = resolution - 1;
    let corner = |column: u32, row: u32| {
        let at = Vec2::new(column as f32, row as f32) / last as f32 - 0.5;
        (row * resolution + column, SIDE * Vec3::new(at.x, 0.0, at.y))
    };
    BTreeMap::from([corner(0, 0), corner(last, 0), corner(0, last), corner(last, last)])
}

const LINEN: [f32; 3] = [0.96, 0.94, 0.90];
const RED: [f32; 3] = [0.72, 0.10, 0.12];

/// Checks of two dyed yarns: one of each kind of square.
fn gingham() -> Image {
    to_texture(paint(128, 128, |uv| {
        let dyed = |across: f32| if across < 0.5 { 0.5 } else { 0.0 };
        mix(LINEN, RED, dyed(uv.x) + dyed(uv.y))
    }))
}
