//! A curtain on a rod, gathered by its rings.

use crate::ball;
use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, prelude::*};
use example_common::{
    orbit_camera::OrbitCamera,
    paint::{mix, paint, to_texture},
    pleats::Pleats,
    props::{mesh, woven},
    rod,
    scene::SceneCamera,
    sheet::grid_mesh,
    stage::Stage,
};

/// Height of the rings above the ground in metres.
pub const HEIGHT: f32 = 2.2;
/// From the rings to the hem, in metres.
const LENGTH: f32 = 2.05;
/// Width of the flat cloth in metres.
const CLOTH_WIDTH: f32 = 2.0;
/// It is gathered to this, in metres.
const HUNG_WIDTH: f32 = 1.6;
/// Waves along the rod.
const PLEATS: usize = 8;

pub struct CurtainPlugin {
    pub fabric: Fabric,
    /// Cells of the mesh along each wave.
    pub cells_per_pleat: usize,
}

impl Plugin for CurtainPlugin {
    fn build(&self, app: &mut App) {
        let (fabric, cells_per_pleat) = (self.fabric, self.cells_per_pleat);
        app.add_systems(Startup, move |world: &mut World| build(world, fabric, cells_per_pleat))
            .add_plugins(ball::plugin);
    }
}

fn build(world: &mut World, fabric: Fabric, cells_per_pleat: usize) {
    let camera = OrbitCamera { focus: Vec3::new(0.1, 1.08, -0.35), distance: 3.9, yaw: -2.25, pitch: 0.12 };
    let stage = Stage { floor: Vec3::ZERO, radius: 2.0, yaw: camera.yaw };
    let camera = world.spawn(camera).id();
    world.insert_resource(SceneCamera(camera));
    stage.build(world, camera);
    world.spawn(ClothCollider::half_space(Dir3::Y));
    rod::build_with_rings(world, HEIGHT, HUNG_WIDTH, PLEATS + 1);
    ball::build(world);

    let wave = Pleats::gathered(CLOTH_WIDTH, HUNG_WIDTH, PLEATS);
    let columns = PLEATS * cells_per_pleat;
    let rows = (columns as f32 * LENGTH / CLOTH_WIDTH) as usize;
    let curtain = grid_mesh(columns, rows, |uv| {
        let (place, _) = wave.place(uv.x * CLOTH_WIDTH);
        place - Vec3::new(0.5 * HUNG_WIDTH, uv.y * LENGTH, 0.0)
    });
    let curtain = mesh(world, curtain);
    let look = woven(world, stripes(), Vec2::new(PLEATS as f32, 1.0));
    world.spawn((
        Name::new("Curtain"),
        curtain,
        look,
        Transform::from_xyz(0.0, HEIGHT, 0.0),
        // The pleats come from the rings, not from the fabric.
        ClothMesh { rest_flat: true, ..default() },
        ClothMaterial(fabric),
        // A ring holds each crest.
        ClothPins::where_vertex(move |vertex| {
            let column = vertex.index as usize;
            column <= columns && column.is_multiple_of(cells_per_pleat)
        }),
        // What lies between the vertices keeps clear of the ball too.
        ClothContact { thickness: 0.008, ..default() },
        ClothContacts::default(),
        // The ball goes two cells in a step: what it hits has to follow.
        ClothQuality::High,
    ));
}

const TEAL: [f32; 3] = [0.07, 0.36, 0.40];
const CREAM: [f32; 3] = [0.90, 0.86, 0.76];

/// A broad stripe and a fine one, from top to bottom; a band at the hem.
fn stripes() -> Image {
    to_texture(paint(64, 512, |uv| {
        let stripe = (0.30..0.70).contains(&uv.x) || (0.78..0.82).contains(&uv.x) || (0.18..0.22).contains(&uv.x);
        let band = (0.90..0.96).contains(&uv.y);
        mix(CREAM, TEAL, if stripe != band { 1.0 } else { 0.0 })
    }))
}
