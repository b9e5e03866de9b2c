//! Machines that a sheet gets into: a press, a paddle, a belt, stairs.

use bevy::math::{DQuat, DVec3};
use bevy_cloth::physics::Pose;

use super::body::Body;
use super::drop::sheet;
use super::fit::acceleration;
use super::impact::upright;
use super::row::{Row, Wanted};
use super::slope::{Floor, small_sheet};
use super::solid::Solid;
use super::trial::Trial;
use crate::scenes::{DT, fabric};

/// Vertices along a side.
const SIDE: u32 = 24;
/// Between the plates of the press at last, m, and how fast the upper comes, m/s.
const GAP: f64 = 0.03;
const CLOSING: f64 = 1.0;
/// Turns of the paddle a second.
const TURNS: f64 = 10.0;
/// Of the belt, m/s, and its friction.
const BELT: f64 = 2.0;
const FRICTION: f64 = 0.5;
/// From the top of a stair to the next, m: down and forth.
const STAIR: [f64; 2] = [0.15, 0.25];

/// Two plates crush a sheet that stands between them to a gap of 3 cm.
pub fn press() -> Vec<Row> {
    let half = DVec3::new(2.0, 0.1, 2.0);
    let below = Body::fixed(Solid::Cuboid { half }, 0.5, Pose::at(DVec3::NEG_Y * 0.1));
    let top = |time: f64| (1.1 - CLOSING * time).max(GAP);
    let above = Body::moving(Solid::Cuboid { half }, 0.5, move |time| Pose::at(DVec3::Y * (top(time) + 0.1)));
    let mut cloth = upright(SIDE, |_| false);
    // Not upright all through: it knows which way to fold.
    let bent = |x: &DVec3| DVec3::new(x.x, x.y + 0.51, 0.1 * (2.0 * x.y).cos() + 0.02 * x.x);
    let positions: Vec<_> = cloth.positions().iter().map(bent).collect();
    cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
    let mut trial = Trial::new(cloth, vec![below, above], DT);
    trial.run(2.0);
    let out = trial.cloth.positions().iter().filter(|x| x.y < 0.0 || x.y > GAP).count();
    let mut rows = vec![Row::new("press", "vertices out of the gap", out as f64, Wanted::AtMost(0.0))];
    rows.extend(trial.rows("press"));
    rows.push(trial.energy_row("press"));
    rows
}

/// A paddle of 3 cm that turns ten times a second and reaches 5 cm through a hanging sheet: little enough not to wind it up,
/// which nothing could hold.
///
/// In a step it turns by 60°, and what slides off its edge meanwhile is on its other side at the end: from both ends of a step that
/// cannot be told from what went through it. So every substep is judged for itself.
pub fn paddle() -> Vec<Row> {
    let half = DVec3::new(0.25, 0.2, 0.015);
    let pose = |time: f64| Pose {
        translation: DVec3::Z * 0.2,
        rotation: DQuat::from_rotation_y(core::f64::consts::TAU * TURNS * time),
    };
    let body = Body::moving(Solid::Cuboid { half }, 0.3, pose);
    let cloth = upright(SIDE, |x| (x.x == 0.0 || x.x > 0.999) && x.z == 0.0);
    let mut trial = Trial::new(cloth, vec![body], DT);
    trial.run(1.0);
    let mut rows = trial.rows("paddle");
    rows.push(trial.energy_row("paddle"));
    rows
}

/// A sheet laid on a belt is as fast as the belt after v/(μ g), and until then has a = μ g.
pub fn belt(floor: Floor) -> Vec<Row> {
    let scene = format!("belt {}", floor.name());
    let (solid, offset) = floor.solid();
    let body = Body::moving(solid, FRICTION, move |time| Pose::at(offset + DVec3::X * BELT * time));
    let mut trial = Trial::new(small_sheet(FRICTION), vec![body], DT);
    let mut way = vec![trial.centre().x];
    trial.run_with(1.0, |trial| way.push(trial.centre().x));
    let gravity = 9.81;
    // Before it has the speed of the belt, and after.
    let share = |time: f64| (time * BELT / (FRICTION * gravity) / DT) as usize;
    let measured = acceleration(&way[share(0.2)..=share(0.85)], DT);
    let last = way.len() - 1;
    let speed = (way[last] - way[last - 12]) / (12.0 * DT);
    let mut rows = vec![
        Row::new(&scene, "a/(m/s²)", measured, Wanted::near(FRICTION * gravity, 0.02)),
        Row::new(&scene, "speed/(m/s)", speed, Wanted::near(BELT, 0.01)),
    ];
    rows.extend(trial.rows(&scene));
    rows.push(trial.energy_row(&scene));
    rows
}

/// A sheet thrown down stairs.
pub fn stairs() -> Vec<Row> {
    let half = DVec3::new(0.5 * STAIR[1], 0.5, 1.0);
    let part = |i: u32| {
        let top = DVec3::new(STAIR[1] * f64::from(i), -STAIR[0] * f64::from(i), 0.0);
        (top - DVec3::Y * half.y, Solid::Cuboid { half })
    };
    let floor = Solid::Cuboid { half: DVec3::new(5.0, 0.5, 5.0) };
    let mut parts: Vec<_> = (0..6).map(part).collect();
    parts.push((DVec3::new(1.25, -STAIR[0] * 6.0 - 0.5, 0.0), floor));
    let body = Body::fixed(Solid::Compound(parts), 0.3, Pose::IDENTITY);
    let mut cloth = sheet(SIDE, DVec3::new(0.3, 0.4, 0.0), fabric());
    let positions = cloth.positions().to_vec();
    cloth.set_state(&positions, &vec![DVec3::new(3.0, -2.0, 0.5); positions.len()]);
    let mut trial = Trial::new(cloth, vec![body], DT);
    trial.run(3.0);
    let mut rows = trial.rows("stairs");
    rows.push(trial.energy_row("stairs"));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_touch_the_belt_carries_nothing() {
        let mut trial = Trial::new(small_sheet(FRICTION), Vec::new(), DT);
        trial.run(0.5);
        assert!(trial.centre().x.abs() < 1e-6 && trial.centre().y < -1.0);
    }
}
