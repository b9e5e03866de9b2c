//! A curtain and a capsule, one of them moving: what is drawn is not in what is drawn, whatever was simulated when.

use bevy::camera::primitives::Aabb;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::plugin::ClothCollider;

use super::frames::Frames;
use super::stage::{Moved, Stage, When, path, sheet, top_edge, worse};
use crate::row::{Row, Wanted};

/// Of the capsule, m: the radius, and half of the length between its ends' centres.
const RADIUS: f64 = 0.2;
const HALF_LENGTH: f64 = 0.6;
/// How far the rod or the capsule goes to and fro, m, and how often a second.
const AMPLITUDE: f64 = 0.4;
const RATE: f64 = 0.5;
/// Side of the curtain, m, and cells along it.
const SIDE: f32 = 1.6;
const CELLS: u32 = 32;

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moving {
    Rod,
    Capsule,
}

#[derive(Default)]
struct Outcome {
    /// The deepest drawn vertex in the drawn capsule, m.
    drawn: f64,
    /// The deepest simulated vertex in the capsule as it was in the step, m. Known where the capsule stands.
    simulated: f64,
    /// How far pins are drawn from the drawn rod, m.
    pins: f64,
    /// How far a drawn vertex is out of the bounds, m.
    bounds: f64,
    /// In the largest stretch, parts.
    stretch: f64,
}

fn outcome(moving: Moving, when: When, fps: f64, seconds: f64) -> Outcome {
    let mut stage = Stage::new(64.0, Frames::Even(fps), 0.0, 0);
    // The curtain begins a little before the capsule and goes through where it stands.
    let begin = -(RADIUS + 0.05) as f32;
    let wave = |time: f64| (AMPLITUDE * (core::f64::consts::TAU * RATE * time).sin()) as f32;
    let [rod_path, capsule_path] = match moving {
        Moving::Rod => [Some(path(move |time, transform| transform.translation.z = begin + wave(time))), None],
        Moving::Capsule => [None, Some(path(move |time, transform| transform.translation.z = -wave(time)))],
    };
    let moved = |path: Option<_>| path.map_or_else(Moved::default, |path| Moved::by(when, &path));
    let rod = stage.spawn_cloth(
        sheet(SIDE, SIDE, CELLS),
        (top_edge(), Transform::from_xyz(0.0, SIDE, begin), moved(rod_path)),
        None,
    );
    let capsule = ClothCollider::capsule(RADIUS as f32, 2.0 * HALF_LENGTH as f32);
    let middle = Transform::from_xyz(0.0, 0.5 * SIDE, 0.0);
    let capsule = stage.spawn((capsule, middle, moved(capsule_path)), None);
    stage.run(0.1);
    let pins = stage.state(rod).pinned_vertices().to_vec();
    let rest: Vec<_> = stage.drawn(rod).to_vec();
    stage.take_seen();
    let mut outcome = Outcome { drawn: f64::NEG_INFINITY, simulated: f64::NEG_INFINITY, ..Outcome::default() };
    stage.run_and(seconds, |stage| {
        let to_capsule = stage.place(capsule).affine().as_daffine3().inverse();
        let drawn = stage.drawn_in_world(rod);
        let depths = drawn.iter().map(|&p| depth(to_capsule.transform_point3(p)));
        outcome.drawn = depths.fold(outcome.drawn, worse);
        if moving == Moving::Rod {
            let depths = stage.positions(rod).iter().map(|&p| depth(to_capsule.transform_point3(p)));
            outcome.simulated = depths.fold(outcome.simulated, worse);
        }
        let local = stage.drawn(rod);
        let moved = |&v: &u32| f64::from(Vec3::from(local[v as usize]).distance(Vec3::from(rest[v as usize])));
        outcome.pins = pins.iter().map(moved).fold(outcome.pins, worse);
        let out = outside(stage.bounds(rod), local);
        outcome.bounds = worse(outcome.bounds, out);
    });
    outcome.stretch = stage.take_seen().stretch;
    outcome
}

/// How deep a point of its frame is in the capsule, m.
fn depth(point: DVec3) -> f64 {
    let axis = DVec3::Y * point.y.clamp(-HALF_LENGTH, HALF_LENGTH);
    RADIUS - point.distance(axis)
}

/// How far the point that is the farthest out of the bounds is out of them, m.
fn outside(bounds: &Aabb, points: &[[f32; 3]]) -> f64 {
    let (centre, half) = (Vec3::from(bounds.center), Vec3::from(bounds.half_extents));
    let beyond = |&p: &[f32; 3]| f64::from(((Vec3::from(p) - centre).abs() - half).max_element());
    points.iter().map(beyond).fold(0.0, worse)
}

/// How the curtain is drawn.
pub fn rows(quick: bool) -> Vec<Row> {
    let (rates, seconds) = if quick { (&[60.0][..], 1.5) } else { (&[30.0, 60.0, 144.0][..], 4.0) };
    let mut rows = Vec::new();
    for moving in [Moving::Rod, Moving::Capsule] {
        for when in [When::FixedUpdate, When::Update] {
            for &fps in rates {
                let Outcome { drawn, simulated, pins, bounds, stretch } = outcome(moving, when, fps, seconds);
                let what = if moving == Moving::Rod { "rod" } else { "capsule" };
                let scene = format!("curtain, {what} moved in {}, {fps} fps", when.name());
                rows.push(Row::new(&scene, "drawn in the capsule/mm", 1e3 * drawn, Wanted::AtMost(1.0)));
                if moving == Moving::Rod {
                    rows.push(Row::new(&scene, "simulated in it/mm", 1e3 * simulated, Wanted::Known));
                }
                rows.push(Row::new(&scene, "pins off the rod/mm", 1e3 * pins, Wanted::AtMost(0.01)));
                rows.push(Row::new(&scene, "drawn out of the bounds/mm", 1e3 * bounds, Wanted::AtMost(0.01)));
                rows.push(Row::new(&scene, "stretch/%", 100.0 * stretch, Wanted::Known));
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_and_bounds_are_measured() {
        assert!((depth(DVec3::new(0.15, 0.3, 0.0)) - 0.05).abs() < 1e-12);
        assert!((depth(DVec3::new(0.0, 0.9, 0.0)) + 0.1).abs() < 1e-12);
        let bounds = Aabb::from_min_max(Vec3::ZERO, Vec3::ONE);
        assert_eq!(outside(&bounds, &[[0.5, 0.2, 1.0]]), 0.0);
        assert!((outside(&bounds, &[[0.5, -0.25, 1.0]]) - 0.25).abs() < 1e-6);
    }
}
