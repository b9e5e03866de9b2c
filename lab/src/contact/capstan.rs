//! A strip around a rod, without gravity, one end pulled: it slides when one tension is e^(μφ) times the other (Euler, Eytelwein).

use core::f64::consts::{FRAC_PI_2, PI};

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, ContactSettings, Fabric, Pose};

use super::body::Body;
use super::row::{Row, Wanted};
use super::solid::Solid;
use super::trial::Trial;
use super::wrap::Wrap;
use crate::scenes::DT;
use crate::validate::strip::mean;

/// Angles of contact and coefficients of friction.
pub const CASES: [(f64, f64); 4] = [(FRAC_PI_2, 0.3), (PI, 0.3), (1.5 * PI, 0.3), (PI, 0.5)];
/// Of the rod, m.
const RADIUS: f64 = 0.1;
/// Edges of the free ends, 1 cm each: short enough that those of a long arc do not meet.
const FREE: u32 = 8;
const ACROSS: u32 = 4;
/// Tensile stiffness, N/m, and how far the strip is stretched at first.
const STIFFNESS: f64 = 1000.0;
const STRETCH: f64 = 5e-3;
/// How fast the end is pulled, m/s, and how far at most, m.
const SPEED: f64 = 0.01;
const FARTHEST: f64 = 0.08;
/// The whole strip slides from when the tension of the end that is held has grown by the first of these; seen enough is at the
/// second.
const SLIDING: [f64; 2] = [1.15, 1.4];

/// The ratio of tensions at which a strip slides.
pub fn holding_ratio(friction: f64, angle: f64) -> f64 {
    (friction * angle).exp()
}

/// Force per width of a strip whose sides are free, without Poisson effect, stretched to λ, N/m: λ k (λ² − 1)/2.
fn tension(stretch: f64) -> f64 {
    0.5 * STIFFNESS * stretch * (stretch * stretch - 1.0)
}

/// Tension between two places of the strip with nothing between them, in edges from its beginning, N/m.
fn tension_between(cloth: &Cloth, wrap: &Wrap, [from, to]: [u32; 2]) -> f64 {
    let [a, b] = [from, to].map(|edges| mean(cloth, &wrap.across(edges, ACROSS)));
    tension(a.distance(b) / (f64::from(to - from) * wrap.edge))
}

/// A strip stretched around a rod, and the way that its last edge is pulled.
fn strip(angle: f64, friction: f64) -> (Wrap, Trial) {
    let fabric = Fabric { air_drag: 0.0, ..Fabric::isotropic(0.15, STIFFNESS as f32, 0.0, 1e-7) };
    let thickness = ContactSettings::default().thickness;
    let wrap = Wrap { before: FREE, after: FREE, ..Wrap::of_angle(angle, RADIUS + thickness, 0.01) };
    // The same places, of a strip that is shorter at rest.
    let mut cloth = Wrap { edge: wrap.edge / (1.0 + STRETCH), ..wrap }.cloth(ACROSS, fabric, friction);
    let placed = wrap.cloth(ACROSS, fabric, friction);
    cloth.set_state(placed.positions(), placed.velocities());
    cloth.set_gravity(DVec3::ZERO);
    let ends = [0, 2 * FREE + wrap.around].map(|edges| wrap.across(edges, ACROSS));
    for vertex in ends.into_iter().flatten() {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    let rod = Body::fixed(Solid::Capsule { half_length: 0.5, radius: RADIUS }, friction, Pose::IDENTITY);
    (Wrap { edge: wrap.edge / (1.0 + STRETCH), ..wrap }, Trial::new(cloth, vec![rod], DT))
}

/// The mean ratio of tensions while the strip slides; NaN if it never does as far as it is pulled.
fn ratio(wrap: &Wrap, trial: &mut Trial, angle: f64) -> f64 {
    let end = 2 * FREE + wrap.around;
    // One edge off the rod, where the fabric may still bend, and one off the pins.
    let spans = [[1, FREE - 1], [end - FREE + 1, end - 1]];
    let direction = DVec3::new(-angle.sin(), angle.cos(), 0.0);
    let pulled: Vec<_> = wrap.across(end, ACROSS).iter().map(|&v| (v, trial.cloth.positions()[v as usize])).collect();
    let (mut sum, mut count) = (0.0, 0.0);
    while trial.time * SPEED < FARTHEST {
        let way = (trial.time + DT) * SPEED;
        for &(vertex, from) in &pulled {
            trial.cloth.pin(vertex, from + way * direction);
        }
        trial.step();
        let [held, pulled] = spans.map(|span| tension_between(&trial.cloth, wrap, span));
        let grown = held / tension(1.0 + STRETCH);
        if grown >= SLIDING[0] {
            sum += pulled / held;
            count += 1.0;
        }
        if grown >= SLIDING[1] {
            break;
        }
    }
    sum / count
}

/// The ratio at which the strip slides, against the formula.
pub fn rows(angle: f64, friction: f64) -> Vec<Row> {
    let scene = format!("capstan φ {:.0}° μ {friction}", angle.to_degrees());
    let (wrap, mut trial) = strip(angle, friction);
    let measured = ratio(&wrap, &mut trial, angle);
    let wanted = Wanted::near(holding_ratio(friction, angle), 0.05);
    let mut rows = vec![Row::new(&scene, "tension ratio", measured, wanted)];
    rows.extend(trial.rows(&scene));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_is_that_of_euler() {
        assert!((holding_ratio(0.5, PI) - 4.8105).abs() < 1e-4);
        assert!((holding_ratio(0.3, 1.5 * PI) - 4.1113).abs() < 1e-4);
        assert_eq!(holding_ratio(0.0, PI), 1.0);
    }

    #[test]
    fn tension_is_read_off_the_free_ends() {
        for (angle, friction) in CASES {
            let (wrap, trial) = strip(angle, friction);
            let (read, known) = (|span| tension_between(&trial.cloth, &wrap, span), tension(1.0 + STRETCH));
            let end = 2 * FREE + wrap.around;
            for span in [[1, FREE - 1], [end - FREE + 1, end - 1]] {
                assert!((read(span) / known - 1.0).abs() < 1e-9, "{} {known}", read(span));
            }
            // The ends do not meet.
            let depth = trial.cloth.positions().iter().map(|&x| trial.bodies[0].solid.distance(x)).fold(1.0, f64::min);
            assert!((depth - 3e-3).abs() < 1e-9, "{depth}");
        }
    }
}
