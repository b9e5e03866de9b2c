//! A towel over a rod, longer on one side: friction holds it while the longer side weighs less than e^(μπ) times the other.

use core::f64::consts::PI;

use bevy_cloth::physics::{Fabric, Pose};

use super::body::Body;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::trial::Trial;
use super::wrap::Wrap;
use crate::scenes::DT;
use crate::validate::strip::mean;

/// Of the rod, m.
const RADIUS: f64 = 0.05;
/// Of a fabric on a rod, both: e^(μπ) = 4.8.
const FRICTION: f64 = 0.5;
/// Edges of the shorter side, 1 cm each, and across.
const SHORT: u32 = 20;
const ACROSS: u32 = 6;
/// Length of the longer side in the shorter, where it stays and where it slides.
const STAYS: u32 = 2;
const SLIDES: u32 = 6;
/// Time to come to rest, s.
const ONSET: f64 = 1.0;

fn towel(ratio: u32) -> (Wrap, Trial) {
    let fabric = Fabric::isotropic(0.3, 1000.0, 0.0, 1e-6);
    let thickness = bevy_cloth::physics::ContactSettings::default().thickness;
    let wrap = Wrap { before: ratio * SHORT, after: SHORT, ..Wrap::of_angle(PI, RADIUS + thickness, 0.01) };
    let rod = Body::fixed(Solid::Capsule { half_length: 0.5, radius: RADIUS }, FRICTION, Pose::IDENTITY);
    (wrap, Trial::new(wrap.cloth(ACROSS, fabric, FRICTION), vec![rod], DT))
}

/// How far a towel moves that stays, and one that does not.
pub fn rows(seconds: f64) -> Vec<Row> {
    let (wrap, mut trial) = towel(STAYS);
    // Along the arc, where it lies on the rod.
    let vertices: Vec<_> = (1..wrap.around).flat_map(|edge| wrap.across(wrap.before + edge, ACROSS)).collect();
    trial.run(ONSET);
    let start: Vec<_> = vertices.iter().map(|&v| trial.cloth.positions()[v as usize]).collect();
    trial.run(seconds - ONSET);
    let slips = vertices.iter().zip(&start).map(|(&v, x)| trial.cloth.positions()[v as usize].distance(*x));
    let slip = 1e3 * slips.sum::<f64>() / vertices.len() as f64;
    let stays = format!("towel {STAYS}:1");
    let mut rows = vec![Row::new(&stays, "slip/mm", slip, Wanted::AtMost(2.0))];
    rows.extend(trial.rows(&stays));
    rows.push(trial.energy_row(&stays));

    let (wrap, mut trial) = towel(SLIDES);
    let end = wrap.across(0, ACROSS);
    let start = mean(&trial.cloth, &end);
    let slides = format!("towel {SLIDES}:1");
    let mut fall = 0.0_f64;
    trial.run_with(2.0, |trial| fall = start.y - mean(&trial.cloth, &end).y);
    rows.push(Row::new(&slides, "slides by/mm", 1e3 * fall, Wanted::AtLeast(100.0)));
    rows.extend(trial.rows(&slides));
    rows
}
