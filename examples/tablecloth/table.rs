//! A round table on four legs.

use bevy::prelude::*;
use bevy_cloth::prelude::*;
use example_common::{
    lathe::turned,
    props::{mesh, solid, wood},
};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// Of the upper side, in metres.
pub const HEIGHT: f32 = 0.74;
/// Of the top, in metres.
pub const RADIUS: f32 = 0.55;

const THICKNESS: f32 = 0.044;
/// Of the rounded edge, in metres: cloth feels a sharp one around it.
const EDGE: f32 = 0.008;

const LEG_RADIUS: f32 = 0.026;
/// Distance of a leg from the middle of the table, in metres.
const LEG_PLACE: f32 = 0.34;

pub fn build(world: &mut World) {
    let wood = wood(world);
    let (half, rim) = (0.5 * THICKNESS, RADIUS);
    let top = mesh(world, turned(&[(0.0, -half), (rim, -half), (rim, half), (0.0, half)], EDGE));
    world.spawn((
        Name::new("Table top"),
        top,
        wood.clone(),
        Transform::from_xyz(0.0, HEIGHT - half, 0.0),
        ClothCollider::cylinder(RADIUS, THICKNESS).with_friction(0.4),
    ));
    let length = HEIGHT - THICKNESS;
    for nth in 0..4 {
        let place = Quat::from_rotation_y(FRAC_PI_4 + FRAC_PI_2 * nth as f32) * (LEG_PLACE * Vec3::X);
        solid(
            world,
            Cylinder::new(LEG_RADIUS, length),
            &wood,
            Transform::from_translation(place + 0.5 * length * Vec3::Y),
        );
    }
}
