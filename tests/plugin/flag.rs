//! A cloth that is plane, with gravity in its plane: it folds and falls as it would in the world.

use bevy::prelude::*;
use bevy_cloth::plugin::*;
use core::f32::consts::{FRAC_PI_2, PI};

use crate::common::*;

/// A sheet of 1 m in the plane z = 0, as a game makes it.
fn plane(cells: u32) -> Mesh {
    Plane3d::new(Vec3::Z, Vec2::splat(0.5)).mesh().subdivisions(cells - 1).build()
}

fn pole() -> ClothPins {
    ClothPins::where_position(|p| p.x < -0.499)
}

/// The lowest point against the lower end of the pole, after some seconds.
fn fallen(seconds: usize, bundle: impl Bundle) -> f32 {
    let mut app = app();
    let cloth = spawn(&mut app, plane(16), (pole(), bundle));
    let lowest = |app: &App| world(app, cloth).iter().map(|p| p.y).fold(f32::MAX, f32::min);
    let before = lowest(&app);
    run(&mut app, 64 * seconds);
    before - lowest(&app)
}

#[test]
fn a_flag_at_its_pole_falls_within_two_seconds_however_it_stands() {
    for fabric in [ClothMaterial::cotton(), ClothMaterial::silk()] {
        for (pole, turn) in [0.0, 0.3, FRAC_PI_2, 2.0, PI].map(|angle| (angle, Quat::from_rotation_y(angle))) {
            let fallen = fallen(2, (fabric, Transform::from_xyz(3.0, 2.0, 1.0).with_rotation(turn)));
            assert!(fallen > 0.2, "{fabric:?} turned by {pole}: {fallen} m");
        }
    }
}

#[test]
fn a_flag_falls_the_same_in_every_run_and_after_a_reset() {
    let mut app = app();
    let one = spawn(&mut app, plane(16), pole());
    run(&mut app, 100);
    let first = local(&app, one);
    let mut other = self::app();
    let two = spawn(&mut other, plane(16), pole());
    run(&mut other, 100);
    assert_eq!(first, local(&other, two));
    app.world_mut().trigger(ClothReset { entity: one });
    run(&mut app, 101);
    let fallen = local(&app, one).iter().map(|p| p.y).fold(f32::MAX, f32::min);
    assert!(fallen < -0.7, "{fallen}");
}

#[test]
fn a_flag_falls_alike_on_every_mesh() {
    let lowest = [12, 24].map(|cells| {
        let mut app = app();
        let cloth = spawn(&mut app, plane(cells), pole());
        run(&mut app, 64);
        world(&app, cloth).iter().map(|p| p.y).fold(f32::MAX, f32::min)
    });
    assert!((lowest[0] - lowest[1]).abs() < 0.1, "{lowest:?}");
}

#[test]
fn a_curtain_that_hangs_does_not_move() {
    let mut app = app();
    let cloth = spawn(&mut app, plane(16), ClothPins::where_position(|p| p.y > 0.499));
    let mut most = 0.0_f32;
    for _ in 0..200 {
        app.update();
        most = local(&app, cloth).iter().map(|p| p.z.abs()).fold(most, f32::max);
    }
    assert!(most < 1e-3, "{most} m");
}

#[test]
fn what_lies_or_leans_begins_at_rest() {
    for angle in [FRAC_PI_2, 0.02] {
        let mut app = app();
        let turned = Transform::from_rotation(Quat::from_rotation_x(angle));
        let cloth = spawn(&mut app, plane(8), turned);
        run(&mut app, 10);
        // Without pins it falls as one piece.
        let velocities = state(&app, cloth).cloth().velocities();
        assert!(velocities.iter().all(|v| v.distance(velocities[0]) < 1e-3), "{angle}");
    }
}
