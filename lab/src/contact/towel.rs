//! A towel over a rod, longer on one side: friction holds it up to a ratio of lengths that is known.

use core::f64::consts::PI;

use bevy_cloth::physics::{ContactSettings, Fabric, Pose};

use super::body::Body;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::trial::Trial;
use super::wrap::Wrap;
use crate::scenes::DT;
use crate::validate::strip::mean;

/// Of the rod, m.
const RADIUS: f64 = 0.05;
/// Of fabric and rod both.
const FRICTION: f64 = 0.5;
/// Edges of the shorter side, 1 cm each, and across.
const SHORT: u32 = 20;
const ACROSS: u32 = 6;
/// Length of the longer side in the shorter, where it stays and where it slides: a sixth off what holds.
const STAYS: u32 = 5;
const SLIDES: u32 = 7;
/// Time to come to rest, s.
const ONSET: f64 = 1.0;

/// The most that the longer side may be in the shorter one of `short` (m), of a towel that bends around `radius` (m).
///
/// On the rod dT/dθ = μ T + w R (μ sin θ + cos θ): the fabric there weighs as well. So T = e^(μθ) (T₀ + w R I), where at θ = π
/// the integral I is 2μ (1 + e^(−μπ))/(1 + μ²).
fn holding_ratio(friction: f64, short: f64, radius: f64) -> f64 {
    let around = 2.0 * friction * (1.0 + (-friction * PI).exp()) / (1.0 + friction * friction);
    (friction * PI).exp() * (1.0 + around * radius / short)
}

fn towel(ratio: u32) -> (Wrap, Trial) {
    let fabric = Fabric::isotropic(0.3, 1000.0, 0.0, 1e-6);
    let thickness = ContactSettings::default().thickness;
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
    let holds = holding_ratio(FRICTION, f64::from(SHORT) * wrap.edge, wrap.radius);
    let stays = format!("towel {STAYS}:1, {holds:.2}:1 hold");
    let mut rows = vec![Row::new(&stays, "slip/mm", slip, Wanted::AtMost(2.0))];
    rows.extend(trial.rows(&stays));
    rows.push(trial.energy_row(&stays));

    let (wrap, mut trial) = towel(SLIDES);
    let end = wrap.across(0, ACROSS);
    let start = mean(&trial.cloth, &end);
    let slides = format!("towel {SLIDES}:1, {holds:.2}:1 hold");
    let mut fall = 0.0_f64;
    trial.run_with(2.0, |trial| fall = start.y - mean(&trial.cloth, &end).y);
    rows.push(Row::new(&slides, "slides by/mm", 1e3 * fall, Wanted::AtLeast(100.0)));
    rows.extend(trial.rows(&slides));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stays_and_what_slides_is_on_either_side_of_what_holds() {
        let (wrap, _) = towel(1);
        let holds = holding_ratio(FRICTION, f64::from(SHORT) * wrap.edge, wrap.radius);
        assert!((holds - 6.0).abs() < 0.1 && f64::from(STAYS) < 0.85 * holds && f64::from(SLIDES) > 1.15 * holds);
        // By small steps along the rod.
        let (mut tension, steps) = (0.2, 100_000);
        for i in 0..steps {
            let (step, angle) = (PI / f64::from(steps), (f64::from(i) + 0.5) * PI / f64::from(steps));
            let (sin, cos) = angle.sin_cos();
            tension += step * (FRICTION * tension + 0.05 * (FRICTION * sin + cos));
        }
        assert!((holding_ratio(FRICTION, 0.2, 0.05) / (tension / 0.2) - 1.0).abs() < 1e-4);
    }
}
