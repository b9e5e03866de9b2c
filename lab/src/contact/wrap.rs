//! Strips laid over a rod along z.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, ContactSettings, Fabric, SolverSettings};

use crate::validate::strip::{Strip, place};

/// A strip that comes in straight, goes around the origin, and leaves straight. Its coordinate is that of the flat strip.
#[derive(Clone, Copy, Debug)]
pub struct Wrap {
    /// Of the middle of the fabric around the rod, m.
    pub radius: f64,
    /// Length of an edge along the strip, m.
    pub edge: f64,
    /// Edges before the arc.
    pub before: u32,
    /// Edges on the arc.
    pub around: u32,
    /// Edges after it.
    pub after: u32,
    /// The angle at which the arc begins, from x towards y.
    pub from: f64,
}

impl Wrap {
    /// The angle around the rod that an edge takes.
    fn step(&self) -> f64 {
        2.0 * (0.5 * self.edge / self.radius).asin()
    }

    /// An arc of this angle alone, of edges of about the length `about`: as long as makes them a whole number.
    pub fn of_angle(angle: f64, radius: f64, about: f64) -> Self {
        let around = (angle * radius / about).round();
        let edge = 2.0 * radius * (0.5 * angle / around).sin();
        Self { radius, edge, before: 0, around: around as u32, after: 0, from: 0.0 }
    }

    /// Where the point at `s` edges from the beginning is.
    fn at(&self, s: f64) -> DVec3 {
        let (before, arc) = (f64::from(self.before), f64::from(self.around));
        let on_arc = (s - before).clamp(0.0, arc);
        let angle = self.from + self.step() * on_arc;
        let (sin, cos) = angle.sin_cos();
        let straight = (s - before - on_arc) * self.edge;
        self.radius * DVec3::new(cos, sin, 0.0) + straight * DVec3::new(-sin, cos, 0.0)
    }

    /// The strip there, at rest, so many edges wide.
    pub fn cloth(&self, across: u32, fabric: Fabric, friction: f64) -> Cloth {
        let along = self.before + self.around + self.after;
        let width = f64::from(across) * self.edge;
        let strip = Strip::new(f64::from(along) * self.edge, width, along, across);
        let mut cloth = strip.cloth(fabric, SolverSettings::default());
        cloth.set_contact_settings(ContactSettings { friction, ..Default::default() }).expect("settings");
        place(&mut cloth, |x| self.at(x.x / self.edge) + DVec3::Z * (x.z - 0.5 * width));
        cloth
    }

    /// Vertices across the strip at so many edges from the beginning, in order.
    pub fn across(&self, edges: u32, across: u32) -> Vec<u32> {
        let columns = self.before + self.around + self.after + 1;
        (0..=across).map(|row| row * columns + edges).collect()
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::validate::strip::mean;

    #[test]
    fn a_wrapped_strip_is_not_stretched_and_keeps_off_the_rod() {
        let wrap = Wrap { before: 7, after: 9, from: 0.0, ..Wrap::of_angle(PI, 0.053, 0.01) };
        assert!((f64::from(wrap.around) * wrap.step() - PI).abs() < 1e-12 && (wrap.edge - 0.01).abs() < 5e-4);
        let cloth = wrap.cloth(3, Fabric::isotropic(0.15, 1000.0, 0.0, 1e-6), 0.5);
        let x = cloth.positions();
        for edges in 0..wrap.before + wrap.around + wrap.after {
            let (here, next) = (wrap.across(edges, 3), wrap.across(edges + 1, 3));
            let lengths = here.iter().zip(&next).map(|(&a, &b)| x[a as usize].distance(x[b as usize]));
            assert!(lengths.clone().all(|length| (length / wrap.edge - 1.0).abs() < 1e-6));
            assert!(mean(&cloth, &here).truncate().length() > wrap.radius - 1e-9);
            assert!(mean(&cloth, &here).z.abs() < 1e-9);
        }
        let ends = [0, 7 + wrap.around + 9].map(|edges| mean(&cloth, &wrap.across(edges, 3)));
        assert!((ends[0].y + 7.0 * wrap.edge).abs() < 1e-9 && (ends[1].y + 9.0 * wrap.edge).abs() < 1e-9);
        assert!((ends[0].x - 0.053).abs() < 1e-9 && (ends[1].x + 0.053).abs() < 1e-9);
    }
}
