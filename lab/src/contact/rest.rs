//! A sheet that has come to rest on something stays at rest.

use bevy::math::DVec3;
use bevy_cloth::physics::{Fabric, Pose};

use super::body::Body;
use super::drop::sheet;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::trial::Trial;
use crate::scenes::{DT, fabric};

/// Time to come to rest in, s.
const SETTLING: f64 = 10.0;
/// Vertices along a side.
const SIDE: u32 = 28;
/// Above what it falls on, m.
const GAP: f64 = 0.02;
/// Steps from one look at depths to the next: meshes take long to measure, and little happens.
const LOOK_EVERY: u32 = 6;
/// Air that stops what hangs free and would swing for long, 1/s.
const THICK_AIR: f32 = 8.0;

/// What a sheet rests on.
#[derive(Clone, Copy, Debug)]
pub enum Bed {
    /// Of 0.3 m.
    Ball,
    /// Of 0.5 m, with sharp edges.
    Box,
    /// A ball of triangles.
    Mesh,
    /// Waves.
    Heightfield,
}

impl Bed {
    /// All.
    pub const ALL: [Self; 4] = [Self::Ball, Self::Box, Self::Mesh, Self::Heightfield];

    /// Its shape, and how high its highest point is.
    fn solid(self) -> (Solid, f64) {
        match self {
            Self::Ball => (Solid::Ball { radius: 0.3 }, 0.3),
            Self::Box => (Solid::Cuboid { half: DVec3::splat(0.25) }, 0.25),
            Self::Mesh => (Solid::faceted_ball(0.3, 32), 0.3),
            Self::Heightfield => (Solid::waves(2.4, 24, |x, z| 0.05 * ((7.0 * x).sin() + (5.0 * z).sin())), 0.1),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Box => "box",
            Self::Mesh => "mesh",
            Self::Heightfield => "heightfield",
        }
    }
}

/// How much a sheet moves that lies on it.
pub fn rows(bed: Bed) -> Vec<Row> {
    let scene = format!("rest on {}", bed.name());
    let (solid, top) = bed.solid();
    let air = Fabric { air_drag: THICK_AIR, ..fabric() };
    let bodies = vec![Body::fixed(solid, 0.5, Pose::IDENTITY)];
    let trial = Trial::new(sheet(SIDE, DVec3::Y * (top + GAP), air), bodies, DT);
    let mut trial = trial.looking_every(LOOK_EVERY);
    trial.run(SETTLING);
    let jitter = trial.jitter(1.0);
    let fallen = 1e3 * (top - trial.highest());
    let mut rows = vec![
        Row::new(&scene, "peak speed/(mm/s)", jitter, Wanted::AtMost(1.0)),
        Row::new(&scene, "highest vertex below the top/mm", fallen, Wanted::AtMost(20.0)),
    ];
    rows.extend(trial.rows(&scene));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_begin_above_their_beds() {
        for bed in Bed::ALL {
            let (solid, top) = bed.solid();
            let cloth = sheet(SIDE, DVec3::Y * (top + GAP), fabric());
            let nearest = cloth.positions().iter().map(|&x| solid.distance(x)).fold(1.0, f64::min);
            assert!((0.5 * GAP..0.06).contains(&nearest), "{bed:?}: {nearest}");
        }
    }
}
