//! What is so fast that it would be on the other side in a step: a ball against a sheet, a sheet against a wall.

use bevy::math::{DQuat, DVec3};
use bevy_cloth::physics::{Cloth, Pose};

use super::body::Body;
use super::drop::sheet;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::trial::Trial;
use crate::scenes::{DT, fabric};
use crate::validate::strip::{pin, place};

/// m/s.
const SPEED: f64 = 50.0;
/// Vertices along a side.
const SIDE: u32 = 24;
/// Of the ball, m.
const RADIUS: f64 = 0.1;
/// Half the thickness of the wall, m.
const WALL: f64 = 0.005;

/// How a sheet that a ball hits is held.
#[derive(Clone, Copy, Debug)]
pub enum Held {
    /// By its whole border.
    Border,
    /// By its two upper corners.
    Corners,
}

impl Held {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Border, Self::Corners];

    fn holds(self, x: DVec3) -> bool {
        let border = |x: f64| x == 0.0 || (x - 1.0).abs() < 1e-12;
        match self {
            Self::Border => border(x.x) || border(x.z),
            Self::Corners => border(x.x) && x.z == 0.0,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Border => "border",
            Self::Corners => "corners",
        }
    }
}

/// A sheet that hangs in the plane z = 0, its middle at the origin.
pub fn upright(n: u32, held: impl Fn(DVec3) -> bool) -> Cloth {
    let mut cloth = sheet(n, DVec3::ZERO, fabric());
    place(&mut cloth, |x| DVec3::new(x.x - 0.5, 0.5 - x.z, 0.0));
    pin(&mut cloth, held);
    cloth
}

/// How long a sheet that was hit is looked at, s: later it may swing back around the ball.
const LOOK: f64 = 0.1;

/// A ball flies through where the sheet is, and stops behind it: all of the sheet in its way is then before it.
pub fn ball(held: Held) -> Vec<Row> {
    let scene = format!("ball 50 m/s, held by {}", held.name());
    // Half a step before the sheet, so that it is through in the first.
    let centre = |time: f64| DVec3::Z * (SPEED * time - 0.5).min(0.3);
    let body = Body::moving(Solid::Ball { radius: RADIUS }, 0.5, move |time| Pose::at(centre(time)));
    let mut trial = Trial::new(upright(SIDE, |x| held.holds(x)), vec![body], DT);
    let before = trial.cloth.positions().to_vec();
    let (mut behind, mut reach) = (0, 0.0_f64);
    trial.run_with(LOOK, |trial| {
        behind = behind.max(behind_ball(&trial.cloth, &before, centre(trial.time)));
        reach = trial.cloth.positions().iter().map(|x| x.z).fold(reach, f64::max);
    });
    trial.run(1.0 - LOOK);
    let mut rows = vec![
        Row::new(&scene, "vertices behind", behind as f64, Wanted::AtMost(0.0)),
        // The vertices nearest to the foremost point of the ball are beside it.
        Row::new(&scene, "carried along by/mm", 1e3 * reach, Wanted::AtLeast(1e3 * (0.3 + 0.9 * RADIUS))),
    ];
    rows.extend(trial.rows(&scene));
    rows.push(trial.energy_row(&scene));
    rows
}

/// m/s.
const THROWN: f64 = 6.0;

/// Frictions of the ball that is thrown into a curtain.
pub const FRICTIONS: [f64; 3] = [0.0, 0.1, 0.5];

/// A ball that nothing slows flies into a curtain held by its upper edge, and through under it. All of its motion would stretch it by
/// 6 % if it were brought to rest at once; a ball that drags it along as if it were glued, by its whole way.
pub fn thrown(friction: f64) -> Vec<Row> {
    let scene = format!("ball 6 m/s, μ {friction}");
    let centre = |time: f64| DVec3::new(0.0, -0.2, THROWN * time - 0.3);
    let body = Body::moving(Solid::Ball { radius: RADIUS }, friction, move |time| Pose::at(centre(time)));
    let mut trial = Trial::new(upright(2 * SIDE, |x| x.z == 0.0), vec![body], DT);
    let (mut peak, mut rms) = (0.0_f64, 0.0_f64);
    trial.run_with(0.5, |trial| {
        let stretch = trial.cloth.stretch();
        (peak, rms) = (peak.max(stretch.max), rms.max(stretch.rms));
    });
    let mut rows = vec![
        Row::new(&scene, "RMS stretch/%", 100.0 * rms, Wanted::AtMost(5.0)),
        Row::new(&scene, "peak stretch/%", 100.0 * peak, Wanted::Known),
    ];
    rows.extend(trial.rows(&scene));
    rows.push(trial.energy_row(&scene));
    rows
}

/// Vertices that were in the way of the ball, and are in the way that it came by. (Free hems may have closed behind it.)
fn behind_ball(cloth: &Cloth, before: &[DVec3], centre: DVec3) -> usize {
    let in_way = |x: &DVec3| x.x.hypot(x.y) < RADIUS;
    let now = cloth.positions().iter().zip(before).filter(|(x, before)| in_way(before) && in_way(x));
    now.filter(|(x, _)| x.z < centre.z).count()
}

/// How a sheet flies.
#[derive(Clone, Copy, Debug)]
pub enum Flight {
    /// Flat against the wall.
    Flat,
    /// An edge first.
    Edge,
}

impl Flight {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Flat, Self::Edge];
}

/// A sheet is thrown at a wall 1 cm thick: none of it is behind it at last.
pub fn wall(flight: Flight) -> Vec<Row> {
    let scene = format!("wall 50 m/s, {}", if matches!(flight, Flight::Flat) { "flat" } else { "edge first" });
    let half = DVec3::new(3.0, 3.0, WALL);
    let body = Body::fixed(Solid::Cuboid { half }, 0.5, Pose::IDENTITY);
    let mut cloth = sheet(SIDE, DVec3::ZERO, fabric());
    let turn = match flight {
        Flight::Flat => DQuat::from_rotation_x(1.5),
        Flight::Edge => DQuat::from_rotation_x(0.1),
    };
    let positions: Vec<_> = cloth.positions().iter().map(|&x| DVec3::Z * -0.8 + turn * x).collect();
    cloth.set_state(&positions, &vec![DVec3::Z * SPEED; positions.len()]);
    let mut trial = Trial::new(cloth, vec![body], DT);
    trial.run(0.5);
    let behind = trial.cloth.positions().iter().filter(|x| x.z > 0.0).count();
    let mut rows = vec![Row::new(&scene, "vertices behind", behind as f64, Wanted::AtMost(0.0))];
    rows.extend(trial.rows(&scene));
    rows.push(trial.energy_row(&scene));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_that_a_ball_left_behind_is_seen() {
        let cloth = upright(SIDE, |x| Held::Border.holds(x));
        let before = cloth.positions();
        assert!(behind_ball(&cloth, before, DVec3::Z * 0.3) > 10);
        assert_eq!(behind_ball(&cloth, before, DVec3::Z * -0.5), 0);
        assert_eq!(cloth.pinned().count(), 4 * 23);
        assert_eq!(upright(SIDE, |x| Held::Corners.holds(x)).pinned().count(), 2);
    }
}
