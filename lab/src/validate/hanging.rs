//! Cloth that has come to rest under its weight.

use bevy::math::DVec3;
use bevy_cloth::physics::{Fabric, SolverSettings};

use super::Row;
use super::strip::{Strip, mean, pin, place, run, vertices};
use crate::scenes::DT;

/// Air that brings it to rest soon, 1/s.
const THICK_AIR: f32 = 40.0;

/// λ(λ²−1)/2 = ρ g s/k at the distance s from the free end: at ρ = 0.324 kg/m² and L = 1 m the tip drops 22.06 mm for
/// k = 69 N/m and 0.7816 mm for k = 2030 N/m.
pub fn stretch() -> Vec<Row> {
    let mut rows = Vec::new();
    for (stiffness, expected) in [(69.0, 22.06), (2030.0, 0.7816)] {
        let fabric = Fabric { damping: 0.0, air_drag: THICK_AIR, ..Fabric::isotropic(0.324, stiffness, 0.0, 1e-6) };
        for cells in [15, 31] {
            for rate in [30.0, 60.0, 240.0] {
                let strip = Strip { length: 1.0, width: 1.0, along: cells, across: cells };
                let mut cloth = strip.cloth(fabric, SolverSettings::default());
                place(&mut cloth, |x| DVec3::new(x.z, -x.x, 0.0));
                pin(&mut cloth, |x| x.x == 0.0);
                run(&mut cloth, 1.0 / rate, 3.0);
                let tip = vertices(&cloth, |x| x.x == 1.0);
                let drop = -1e3 * (mean(&cloth, &tip).y + 1.0);
                let parameters = format!("k {stiffness} N/m, {cells}², {rate} Hz");
                rows.push(Row::new("stretch/mm", parameters, expected, drop, 5e-3));
            }
        }
    }
    rows
}

/// Sag over span, for lengths over span.
const CATENARIES: [(f64, f64); 4] = [(1.05, 0.1393), (1.2, 0.2923), (1.5, 0.5026), (2.0, 0.7964)];

pub fn catenary() -> Vec<Row> {
    let strip = Strip { length: 1.0, width: 0.05, along: 60, across: 3 };
    let fabric = Fabric { air_drag: THICK_AIR / 4.0, ..Fabric::isotropic(0.15, 2000.0, 0.0, 1e-7) };
    CATENARIES
        .into_iter()
        .map(|(ratio, expected)| {
            let span = 1.0 / ratio;
            let mut cloth = strip.cloth(fabric, SolverSettings::default());
            // From the shape of a V, which has the length.
            let slope = (1.0 - span * span).sqrt();
            place(&mut cloth, |x| DVec3::new(span * x.x, -slope * x.x.min(1.0 - x.x), x.z));
            pin(&mut cloth, |x| x.x == 0.0 || x.x == 1.0);
            run(&mut cloth, DT, 8.0);
            let sag = -cloth.positions().iter().map(|x| x.y).fold(0.0, f64::min) / span;
            Row::new("catenary: sag/span", format!("length/span {ratio}"), expected, sag, 1e-2)
        })
        .collect()
}
