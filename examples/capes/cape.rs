//! A cape, held along a collar.

use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, prelude::*};
use example_common::{
    paint::{mix, paint, to_texture},
    props::{mesh, woven},
    sheet::grid_mesh,
};

/// Of the collar and of the hem, in metres above the ground.
const COLLAR: f32 = 1.49;
const HEM: f32 = 0.42;

/// Half axes of the collar and of the hem: sideways and backwards, in metres.
const COLLAR_SIZE: Vec2 = Vec2::new(0.20, 0.10);
const HEM_SIZE: Vec2 = Vec2::new(0.58, 0.52);

/// How far collar and hem reach round to each side, from the middle of the back, in radians.
const REACH: Vec2 = Vec2::new(1.05, 1.35);

pub struct Cape {
    pub fabric: Fabric,
    pub colour: [f32; 3],
    /// Cells from side to side.
    pub columns: usize,
}

impl Cape {
    /// Hangs it round the shoulders of a figure.
    pub fn hang(self, world: &mut World, figure: Entity) {
        let Self { fabric, colour, columns } = self;
        // Seen from behind, from the left to the right.
        let cape = grid_mesh(columns, columns, |uv| {
            let size = COLLAR_SIZE.lerp(HEM_SIZE, uv.y);
            let reach = REACH.x + (REACH.y - REACH.x) * uv.y;
            let (side, back) = (reach * (1.0 - 2.0 * uv.x)).sin_cos();
            Vec3::new(size.x * side, COLLAR + (HEM - COLLAR) * uv.y, -size.y * back)
        });
        let cape = mesh(world, cape);
        let look = woven(world, bordered(colour), Vec2::ONE);
        world.spawn((
            Name::new("Cape"),
            cape,
            look,
            Transform::default(),
            ChildOf(figure),
            ClothMesh::default(),
            ClothMaterial(fabric),
            ClothPins::where_position(|place| place.y > COLLAR - 1e-3),
        ));
    }
}

const GOLD: [f32; 3] = [0.86, 0.64, 0.26];

/// One colour, with a trim on all edges but the collar.
fn bordered(colour: [f32; 3]) -> Image {
    to_texture(paint(256, 256, |uv| {
        let to_edge = uv.x.min(1.0 - uv.x).min(1.0 - uv.y);
        let trim = (0.025..0.05).contains(&to_edge) || (0.062..0.07).contains(&to_edge);
        if trim { GOLD } else { mix(colour, [0.0; 3], 0.06 * (120.0 * uv.x).sin().abs()) }
    }))
}
