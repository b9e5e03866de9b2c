//! Bending: rigidity by direction, the heavy elastica, lateral buckling.

use bevy::math::DVec3;
use bevy_cloth::physics::{BendingModel, Cloth, Fabric, SolverSettings};

use super::Row;
use super::strip::{Pattern, Strip, mean, pin, place, rest, resting, vertices};

const GRAVITY: f64 = 9.81;
/// kg/m².
const DENSITY: f64 = 0.15;
/// Of the cylinder that sheets are bent to, in cells: far larger than they are.
const RADIUS: f64 = 200.0;
const DIRECTIONS: [f64; 4] = [0.0, 45.0, 90.0, 135.0];

/// Isotropic, and so stiff that it hardly stretches.
fn sheet(bending: f64, poisson: f64) -> Fabric {
    let fabric = Fabric::isotropic(DENSITY as f32, 2e4, 0.0, bending as f32).undamped();
    Fabric { bending_poisson: poisson as f32, ..fabric }
}

/// Energy of a sheet bent to a cylinder, over what the flexural rigidity asked for gives: of mid-edge normals in every direction on
/// every mesh; of hinges, for comparison, the direction that is furthest off, by a factor that is known too.
pub fn rigidity() -> Vec<Row> {
    let mut rows = Vec::new();
    for pattern in [Pattern::OneDiagonal, Pattern::Alternating, Pattern::Equilateral, Pattern::Jittered(0.3)] {
        for direction in DIRECTIONS {
            let ratio = cylinder(pattern, BendingModel::MidEdge, direction);
            rows.push(Row::new("rigidity/asked", format!("{}, {direction}°", pattern.name()), 1.0, ratio, 5e-2));
        }
    }
    for (pattern, known) in [(Pattern::OneDiagonal, 3.0), (Pattern::Alternating, 1.5)] {
        let ratios = DIRECTIONS.map(|direction| cylinder(pattern, BendingModel::Hinge, direction));
        let worst = ratios.into_iter().max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs())).unwrap_or(f64::NAN);
        rows.push(Row::new("rigidity/asked", format!("hinges, {}, worst", pattern.name()), known, worst, 5e-3));
    }
    rows
}

/// Rigidity over that asked for, for curvature along `direction` degrees from the warp. What the edges of a sheet lose grows with
/// their length, so that three sizes tell the energy of its inside.
fn cylinder(pattern: Pattern, bending: BendingModel, direction: f64) -> f64 {
    const CELLS: u32 = 12;
    let [small, middle, large] = [1, 2, 3].map(|size| energy(pattern, bending, direction, size * CELLS));
    (small - 2.0 * middle + large) / (2.0 * f64::from(CELLS * CELLS))
}

/// In the energy of a cell.
fn energy(pattern: Pattern, bending: BendingModel, direction: f64, cells: u32) -> f64 {
    let side = f64::from(cells);
    let height = if pattern == Pattern::Equilateral { 0.75_f64.sqrt() } else { 1.0 };
    let strip = Strip { pattern, bending, ..Strip::new(side, side * height, cells, cells) };
    let fabric = sheet(1e-3, 0.0);
    let mut cloth = strip.cloth(fabric, SolverSettings::reference());
    let direction = direction.to_radians();
    let along = DVec3::new(direction.cos(), 0.0, -direction.sin());
    place(&mut cloth, |x| {
        let (s, angle) = (x.dot(along), x.dot(along) / RADIUS);
        x + along * (RADIUS * angle.sin() - s) + DVec3::Y * RADIUS * (1.0 - angle.cos())
    });
    let flat = 0.5 * f64::from(fabric.warp_bending) / (RADIUS * RADIUS) * height;
    cloth.energy().bending / flat
}

/// Γ and drop over length.
const ELASTICA: [(f64, f64); 9] = [
    (0.5, 0.0623),
    (1.0, 0.1235),
    (2.0, 0.2385),
    (5.0, 0.4959),
    (10.0, 0.7002),
    (20.0, 0.8299),
    (50.0, 0.9079),
    (100.0, 0.9375),
    (1000.0, 0.9811),
];

/// Drop of the tip of a strip clamped at one end, over its length, for Γ = ρ g L³/D.
pub fn cantilever() -> Vec<Row> {
    let mut rows = Vec::new();
    for pattern in [Pattern::OneDiagonal, Pattern::Alternating, Pattern::Jittered(0.3)] {
        for (gamma, expected) in ELASTICA {
            let drop = drop(pattern, gamma, 40);
            rows.push(Row::new("cantilever: drop/L", format!("Γ {gamma}, {}", pattern.name()), expected, drop, 2e-2));
        }
    }
    rows
}

/// Of a strip of length 1 m and so many cells.
pub fn drop(pattern: Pattern, gamma: f64, cells: u32) -> f64 {
    let cell = 1.0 / f64::from(cells);
    // One cell more, which the clamp holds.
    let strip = Strip { pattern, ..Strip::new(1.0 + cell, 4.0 * cell, cells + 1, 4) };
    let mut cloth = strip.cloth(sheet(DENSITY * GRAVITY / gamma, 0.0), resting(1e-3));
    clamp(&mut cloth, cell);
    rest(&mut cloth);
    let tip = vertices(&cloth, |x| x.x > 1.0 + 0.999 * cell);
    -mean(&cloth, &tip).y
}

/// Holds the first cell.
pub fn clamp(cloth: &mut Cloth, cell: f64) {
    pin(cloth, |x| x.x < 1.001 * cell);
}

/// Γ at which a strip standing on edge, clamped at one end, gives way sideways under its weight:
/// `12.854 (1−ν²) √(2/(1+ν))`.
pub fn buckling() -> Vec<Row> {
    [(0.0, 18.18), (0.3, 14.51)]
        .into_iter()
        .map(|(poisson, expected)| {
            let threshold = buckling_threshold(poisson, expected);
            Row::new("lateral buckling: Γ", format!("ν {poisson}"), expected, threshold, 5e-2)
        })
        .collect()
}

/// A small load sideways deflects the strip by `u ∝ 1/(1 − (Γ/Γ_cr)²)`: so 1/u against Γ² is a line through zero at Γ_cr².
fn buckling_threshold(poisson: f64, about: f64) -> f64 {
    let points = [0.75, 0.9].map(|share| {
        let gamma = share * about;
        (gamma * gamma, 1.0 / deflection(poisson, gamma))
    });
    let [(a, ya), (b, yb)] = points;
    (a + ya * (b - a) / (ya - yb)).sqrt()
}

fn deflection(poisson: f64, gamma: f64) -> f64 {
    const CELLS: u32 = 60;
    let cell = 1.0 / f64::from(CELLS);
    let strip = Strip { pattern: Pattern::Alternating, ..Strip::new(1.0 + cell, 6.0 * cell, CELLS + 1, 6) };
    let bending = DENSITY * GRAVITY / gamma;
    let mut cloth = strip.cloth(Fabric { shear_stiffness: 2e5, ..stiff(sheet(bending, poisson)) }, resting(1e-6));
    // On edge: what was across is up.
    place(&mut cloth, |x| DVec3::new(x.x, x.z, 0.0));
    clamp(&mut cloth, cell);
    cloth.set_gravity(DVec3::new(0.0, -GRAVITY, 1e-4 * GRAVITY));
    rest(&mut cloth);
    let tip = vertices(&cloth, |x| x.x > 1.0 + 0.999 * cell);
    mean(&cloth, &tip).z
}

/// Does not bend in its plane.
fn stiff(fabric: Fabric) -> Fabric {
    Fabric { warp_stiffness: 2e5, weft_stiffness: 2e5, ..fabric }
}
