//! What is finer than the mesh: a corner and a rod between the vertices of a coarse sheet.

use bevy::math::{DQuat, DVec3};
use bevy_cloth::physics::Pose;

use super::body::Body;
use super::depth;
use super::drop::sheet;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::trial::Trial;
use crate::scenes::{DT, fabric};

/// Vertices along a side, and so the cells of 1 m.
const SIDE: u32 = 8;
const CELL: f64 = 1.0 / 7.0;
/// Samples along an edge of 14 cm: finer than the rod.
const ALONG: u32 = 24;
/// Of the cuboid, m.
const HALF: f64 = 0.25;
/// Of the rod, m.
const ROD: f64 = 0.01;
/// Between the top and the sheet, m.
const GAP: f64 = 0.1;

/// What the sheet falls on.
#[derive(Clone, Copy, Debug)]
pub enum Fine {
    /// A cuboid, a corner of it up.
    Corner,
    /// Thin, horizontal.
    Rod,
}

impl Fine {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Corner, Self::Rod];

    /// With its top, which is the origin, below the inside of a triangle near the middle of the sheet.
    fn body(self) -> Body {
        match self {
            Self::Corner => {
                let half = DVec3::splat(HALF);
                let rotation = DQuat::from_rotation_arc(half.normalize(), DVec3::Y);
                let pose = Pose { translation: DVec3::NEG_Y * half.length(), rotation };
                Body::fixed(Solid::Cuboid { half }, 0.5, pose)
            }
            Self::Rod => {
                let solid = Solid::Capsule { half_length: 1.0, radius: ROD };
                Body::fixed(solid, 0.5, Pose::at(DVec3::NEG_Y * ROD))
            }
        }
    }
}

/// How far it looks through the sheet.
pub fn rows(fine: Fine, seconds: f64) -> Vec<Row> {
    let scene = format!("coarse sheet on {}", if matches!(fine, Fine::Corner) { "corner" } else { "rod" });
    // The middle of the sheet is that of a cell: a third of a cell from there is inside a triangle.
    let middle = DVec3::new(CELL / 6.0, GAP, CELL / 6.0);
    let mut trial = Trial::new(sheet(SIDE, middle, fabric()), vec![fine.body()], DT);
    let (mut deepest, mut lowest) = (f64::NEG_INFINITY, f64::INFINITY);
    trial.run_with(seconds, |trial| {
        deepest = deepest.max(depth::dense(&trial.cloth, &trial.bodies, trial.time, ALONG));
        lowest = lowest.min(trial.highest());
    });
    let thickness = 1e3 * trial.cloth.contact_settings().thickness;
    let mut rows = vec![
        Row::new(&scene, "face depth, dense/mm", 1e3 * deepest, Wanted::AtMost(thickness)),
        Row::new(&scene, "highest vertex below the top/mm", -1e3 * lowest, Wanted::AtMost(50.0)),
    ];
    rows.extend(trial.rows(&scene));
    rows.push(trial.energy_row(&scene));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_is_at_the_origin_and_below_no_vertex() {
        let cloth = sheet(SIDE, DVec3::new(CELL / 6.0, GAP, CELL / 6.0), fabric());
        let nearest = cloth.positions().iter().map(|x| x.x.hypot(x.z)).fold(1.0, f64::min);
        assert!(nearest > 0.4 * CELL, "{nearest}");
        for fine in Fine::ALL {
            let body = fine.body();
            assert!(body.solid.distance(body.pose(0.0).local(DVec3::ZERO)).abs() < 1e-9, "{fine:?}");
            assert!((depth::dense(&cloth, &[body], 0.0, ALONG) + GAP).abs() < 1e-3, "{fine:?}");
        }
    }
}
