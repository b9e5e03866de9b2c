//! `--resolution N`: a square sheet falls from the horizontal while the two corners that hold it draw together.

use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, plugin::ClothSystems, prelude::*};
use example_common::{
    orbit_camera::OrbitCamera,
    props::{mesh, woven},
    rod,
    scene::SceneCamera,
    sheet::{sheet_mesh, stripes},
    stage::Stage,
};
use std::collections::BTreeMap;

/// Side of the sheet in metres.
const SIDE: f32 = 1.6;

/// Height of the held corners above the ground in metres.
const HEIGHT: f32 = 2.0;

/// Distance of the held corners at the end, relative to the side.
const DRAWN_TOGETHER: f32 = 0.72;

/// How long the corners move, in seconds.
const DURATION: f32 = 2.0;

pub struct SheetPlugin {
    pub resolution: u32,
    pub fabric: Fabric,
}

/// The sheet whose corners draw together.
#[derive(Component)]
struct Drawing {
    resolution: u32,
    /// Since the corners began to move, in seconds.
    elapsed: f32,
}

impl Plugin for SheetPlugin {
    fn build(&self, app: &mut App) {
        let (resolution, fabric) = (self.resolution, self.fabric);
        app.add_systems(Startup, move |world: &mut World| build(world, resolution, fabric))
            .add_systems(FixedUpdate, draw_together.before(ClothSystems::Collect));
    }
}

fn build(world: &mut World, resolution: u32, fabric: Fabric) {
    let camera = OrbitCamera { focus: Vec3::new(0.0, 1.1, -0.7), distance: 3.2, yaw: 0.45, pitch: 0.08 };
    let stage = Stage { floor: Vec3::ZERO, radius: 1.6, yaw: camera.yaw };
    let camera = world.spawn(camera).id();
    world.insert_resource(SceneCamera(camera));
    stage.build(world, camera);
    rod::build(world, Vec3::new(0.0, HEIGHT, -0.5 * SIDE), SIDE + 0.2);

    let look = woven(world, stripes(), Vec2::ONE);
    let mesh = mesh(world, sheet_mesh(SIDE, resolution));
    world
        .spawn((
            Name::new("Sheet"),
            mesh,
            look,
            Transform::from_xyz(0.0, HEIGHT, 0.0),
            ClothMesh::default(),
            ClothMaterial(fabric),
            ClothPinTargets(corners(resolution, 0.0)),
            Drawing { resolution, elapsed: 0.0 },
        ))
        .observe(|reset: On<ClothReset>, mut drawings: Query<&mut Drawing>| {
            if let Ok(mut drawing) = drawings.get_mut(reset.entity) {
                drawing.elapsed = 0.0;
            }
        });
}

fn draw_together(time: Res<Time>, mut sheets: Query<(&mut Drawing, &mut ClothPinTargets)>) {
    for (mut drawing, mut targets) in &mut sheets {
        if drawing.elapsed < DURATION {
            drawing.elapsed = (drawing.elapsed + time.delta_secs()).min(DURATION);
            targets.0 = corners(drawing.resolution, drawing.elapsed / DURATION);
        }
    }
}

/// Where the two corners of the −z edge are held, in the sheet's space; `progress` runs from 0 to 1.
fn corners(resolution: u32, progress: f32) -> BTreeMap<u32, Vec3> {
    let apart = 1.0 + (DRAWN_TOGETHER - 1.0) * SmoothStepCurve.sample_clamped(progress);
    let corner = |side: f32| 0.5 * SIDE * Vec3::new(side * apart, 0.0, -1.0);
    BTreeMap::from([(0, corner(-1.0)), (resolution - 1, corner(1.0))])
}
