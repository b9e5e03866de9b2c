//! Cloth that lies on a lift: no entity carries it, only what it lies on.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::plugin::ClothCollider;

use super::frames::Frames;
use super::stage::{Moved, Shake, Stage, When, path, sheet, worse};
use crate::row::{Row, Wanted};

/// Half of the height of the lift, m.
const HALF_HEIGHT: f32 = 0.1;
/// Half of its width, m.
const HALF_WIDTH: f32 = 0.5;
/// When it starts, s, and m/s once it goes.
const START: f64 = 2.0;
const SPEED: f64 = 2.0;
/// How long that takes, s.
const SPURT: f64 = 0.5;
/// Up and down instead: how far, m, and how often a second.
const SWING: f64 = 0.5;
const SWINGS: f64 = 0.48;

/// m/s more than on a lift that is moved in `FixedUpdate`: places in f32 are off by 0.1 µm from tick to tick, which contact makes so much
/// of. That is contact's to mend, not motion's; a lift that is dragged shows as 2 to 10 m/s.
const TREMBLING: f64 = 0.5;

/// How a lift goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ride {
    Up,
    UpAndDown,
}

fn height(ride: Ride, time: f64) -> f64 {
    let time = (time - START).max(0.0);
    match ride {
        Ride::Up if time < SPURT => 0.5 * SPEED * time * time / SPURT,
        Ride::Up => SPEED * (time - 0.5 * SPURT),
        Ride::UpAndDown => SWING * (1.0 - (core::f64::consts::TAU * SWINGS * time).cos()),
    }
}

struct Outcome {
    /// m/s.
    fastest: f64,
    /// m.
    rms: f64,
    /// m.
    inside: f64,
    lost: bool,
}

fn outcome(ride: Ride, when: When, fps: f64) -> Outcome {
    let mut stage = Stage::new(64.0, Frames::Even(fps), START, 0);
    let up = path(move |time, transform| transform.translation.y = height(ride, time) as f32);
    let collider = ClothCollider::cuboid(2.0 * HALF_WIDTH, 2.0 * HALF_HEIGHT, 2.0 * HALF_WIDTH);
    let lift = stage.spawn((collider, Transform::IDENTITY, Moved::by(when, &up)), None);
    let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
    let transform = Transform::from_xyz(0.01, HALF_HEIGHT + 0.01, -0.4).with_rotation(flat);
    let cloth = stage.spawn_cloth(sheet(0.8, 0.8, 14), transform, None);
    stage.run(START + SPURT + 0.5);
    let mut shake = Shake::default();
    let (mut inside, mut fastest) = (f64::NEG_INFINITY, 0.0);
    stage.run_and(3.0, |stage| {
        let to_lift = stage.place(lift).affine().as_daffine3().inverse();
        let drawn: Vec<_> =
            stage.drawn_in_world(cloth).iter().map(|&p| to_lift.transform_point3(p).as_vec3().to_array()).collect();
        inside = drawn.iter().map(|&p| depth(Vec3::from(p).as_dvec3())).fold(inside, worse);
        shake.see(&drawn);
        let speed = match ride {
            Ride::Up => DVec3::Y * SPEED,
            Ride::UpAndDown => return,
        };
        let velocities = stage.state(cloth).cloth().velocities();
        fastest = velocities.iter().map(|v| v.distance(speed)).fold(fastest, worse);
    });
    let bottom = stage.place(lift).translation().y - HALF_HEIGHT;
    let lost = stage.drawn_in_world(cloth).iter().any(|p| p.y < f64::from(bottom) - 0.5);
    Outcome { fastest, rms: shake.rms(), inside, lost }
}

/// How deep a point of its frame is in the lift, m.
fn depth(point: DVec3) -> f64 {
    let half = Vec3::new(HALF_WIDTH, HALF_HEIGHT, HALF_WIDTH).as_dvec3();
    (half - point.abs()).min_element()
}

/// A lift that goes up at an even speed: cloth trembles no more than on one that is moved in `FixedUpdate`. One that goes up and
/// down: it is not drawn in it.
pub fn rows(quick: bool) -> Vec<Row> {
    let fps = if quick { &[60.0][..] } else { &[30.0, 60.0, 144.0][..] };
    let mut rows = Vec::new();
    for &fps in fps {
        let mut reference: Option<[f64; 2]> = None;
        for when in [When::FixedUpdate, When::Update] {
            let Outcome { fastest, rms, inside, lost } = outcome(Ride::Up, when, fps);
            let scene = format!("sheet on a lift of {SPEED} m/s, {fps} fps: {}", when.name());
            let [speeds, shakes] = match reference {
                None => [Wanted::Known; 2],
                Some([fastest, rms]) => [Wanted::AtMost(1.5 * fastest + TREMBLING), Wanted::AtMost(1.5 * rms + 0.1)],
            };
            reference.get_or_insert([fastest, 1e3 * rms]);
            rows.push(Row::new(&scene, "fastest against it/(m/s)", fastest, speeds));
            rows.push(Row::new(&scene, "shake, rms/mm", 1e3 * rms, shakes));
            rows.push(Row::new(&scene, "drawn in it/mm", 1e3 * inside, Wanted::AtMost(1.0)));
            rows.push(Row::new(&scene, "lost", f64::from(lost), Wanted::AtMost(0.0)));
        }
        for when in [When::FixedUpdate, When::Update] {
            let Outcome { rms, inside, lost, .. } = outcome(Ride::UpAndDown, when, fps);
            let scene = format!("sheet on a lift up and down, {fps} fps: {}", when.name());
            rows.push(Row::new(&scene, "shake, rms/mm", 1e3 * rms, Wanted::Known));
            rows.push(Row::new(&scene, "drawn in it/mm", 1e3 * inside, Wanted::AtMost(1.0)));
            rows.push(Row::new(&scene, "lost", f64::from(lost), Wanted::AtMost(0.0)));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_that_in_the_box() {
        assert!((depth(DVec3::new(0.0, 0.099, 0.2)) - 1e-3).abs() < 1e-6);
        assert!(depth(DVec3::new(0.0, 0.3, 0.0)) < 0.0 && depth(DVec3::new(0.6, 0.0, 0.0)) < 0.0);
    }

    #[test]
    fn the_lift_starts_gently() {
        assert_eq!(height(Ride::Up, START), 0.0);
        let speed = (height(Ride::Up, 4.0) - height(Ride::Up, 3.9)) / 0.1;
        assert!((speed - SPEED).abs() < 1e-9);
    }
}
