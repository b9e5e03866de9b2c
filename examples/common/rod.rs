//! A rod between two posts, to hang cloth from.

use crate::props::{brass, mesh, wood};
use bevy::prelude::*;
use std::f32::consts::FRAC_PI_2;

/// In metres.
pub const RADIUS: f32 = 0.016;

/// Of the rings on the rod, in metres.
pub const RING_RADIUS: f32 = 0.03;

/// The rod along x with this centre, its posts, and their feet on the ground at y = 0.
pub fn build(world: &mut World, centre: Vec3, length: f32) {
    let wood = wood(world);
    let brass = brass(world);
    let rod = mesh(world, Cylinder::new(RADIUS, length));
    let sideways = Quat::from_rotation_z(FRAC_PI_2);
    world.spawn((rod, wood.clone(), Transform::from_translation(centre).with_rotation(sideways)));

    let height = centre.y + 0.05;
    let post = mesh(world, Cylinder::new(1.6 * RADIUS, height));
    let finial = mesh(world, Sphere::new(2.4 * RADIUS));
    let foot = mesh(world, Cylinder::new(0.12, 0.03));
    for x in [centre.x - 0.5 * length, centre.x + 0.5 * length] {
        world.spawn((post.clone(), wood.clone(), Transform::from_xyz(x, 0.5 * height, centre.z)));
        world.spawn((foot.clone(), wood.clone(), Transform::from_xyz(x, 0.015, centre.z)));
        world.spawn((finial.clone(), brass.clone(), Transform::from_xyz(x, height + 0.02, centre.z)));
    }
}

/// A rod with rings that hold a cloth gathered to `width`: `rings` of them, evenly spread along x, their lowest points at
/// `height` and z = 0.
pub fn build_with_rings(world: &mut World, height: f32, width: f32, rings: usize) {
    let ring_centre = height + RING_RADIUS;
    build(world, Vec3::new(0.0, ring_centre + RING_RADIUS - 1.5 * RADIUS, 0.0), width + 0.28);
    let brass = brass(world);
    let ring = mesh(world, Torus { minor_radius: 0.004, major_radius: RING_RADIUS });
    let sideways = Quat::from_rotation_z(FRAC_PI_2);
    for nth in 0..rings {
        let x = width * (nth as f32 / (rings - 1) as f32 - 0.5);
        world.spawn((ring.clone(), brass.clone(), Transform::from_xyz(x, ring_centre, 0.0).with_rotation(sideways)));
    }
}
