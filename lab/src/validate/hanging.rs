//! Cloth that has come to rest under its weight.

use bevy::math::DVec3;
use bevy_cloth::physics::{Fabric, SolverSettings};

use super::Row;
use super::strip::{Pattern, Strip, mean, pin, place, rest, resting, run, vertices};
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
                let strip = Strip::new(1.0, 1.0, cells, cells);
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
    CATENARIES
        .into_iter()
        .map(|(ratio, expected)| {
            let parameters = format!("length/span {ratio}");
            Row::new("catenary: sag/span", parameters, expected, sag(ratio, 60, SolverSettings::default()), 1e-2)
        })
        .collect()
}

/// Sag over span of a strip of so many cells.
pub fn sag(ratio: f64, cells: u32, settings: SolverSettings) -> f64 {
    let strip = Strip::new(1.0, 3.0 / f64::from(cells), cells, 3);
    let fabric = Fabric { air_drag: THICK_AIR / 4.0, ..Fabric::isotropic(0.15, 2000.0, 0.0, 1e-7) };
    let span = 1.0 / ratio;
    let mut cloth = strip.cloth(fabric, settings);
    // From the shape of a V, which has the length.
    let slope = (1.0 - span * span).sqrt();
    place(&mut cloth, |x| DVec3::new(span * x.x, -slope * x.x.min(1.0 - x.x), x.z));
    pin(&mut cloth, |x| x.x == 0.0 || x.x == 1.0);
    run(&mut cloth, DT, 8.0);
    -cloth.positions().iter().map(|x| x.y).fold(0.0, f64::min) / span
}

/// Force per width λ k (λ²−1)/2, k = k0 − k1²/k2, of a sheet stretched by λ whose sides are free to come in, from the change
/// of its energy; the same on any mesh.
pub fn patch() -> Vec<Row> {
    let fabric = Fabric::isotropic(0.15, 500.0, 0.3, 0.0);
    let [k0, k1, k2] = [fabric.warp_stiffness, fabric.coupling, fabric.weft_stiffness].map(f64::from);
    let mut rows = Vec::new();
    for pattern in [Pattern::OneDiagonal, Pattern::Jittered(0.4)] {
        for stretch in [1.01, 1.1, 1.5] {
            let expected = 0.5 * (k0 - k1 * k1 / k2) * stretch * (stretch * stretch - 1.0);
            let energy = |stretch: f64| {
                let mut cloth = Strip { pattern, ..Strip::new(1.0, 1.0, 8, 8) }.cloth(fabric, resting(1e-4));
                cloth.set_gravity(DVec3::ZERO);
                // Held ends are as narrow as the middle becomes.
                let narrow = (1.0 - k1 / k2 * (stretch * stretch - 1.0)).sqrt();
                place(&mut cloth, |x| DVec3::new(stretch * x.x, 0.0, narrow * x.z));
                pin(&mut cloth, |x| x.x == 0.0 || x.x == 1.0);
                // Not from the answer.
                let inner = move |x: DVec3| {
                    if x.x > 0.0 && x.x < 1.0 { x } else { DVec3::new(stretch * x.x, 0.0, narrow * x.z) }
                };
                place(&mut cloth, inner);
                rest(&mut cloth);
                cloth.energy().membrane
            };
            const STEP: f64 = 1e-3;
            let force = (energy(stretch + STEP) - energy(stretch - STEP)) / (2.0 * STEP);
            let parameters = format!("λ {stretch}, {}", pattern.name());
            rows.push(Row::new("patch: force/(N/m)", parameters, expected, force, 5e-3));
        }
    }
    rows
}
