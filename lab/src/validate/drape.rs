//! Cusick's drapemeter: a disc of fabric of 30 cm, held between discs of 18 cm, hangs over their edge; the share of the free ring
//! that its shadow covers is the drape coefficient.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, RestShape, RestShapeOptions, SolverSettings, SurfaceMesh};

use super::Row;
use super::strip::{pin, place, run};
use crate::scenes::DT;

/// m.
const FABRIC: f64 = 0.15;
const DISC: f64 = 0.09;
/// Rings of triangles.
const RINGS: u32 = 30;

/// Against the ranges that are found for fabrics of each class.
pub fn drape() -> Vec<Row> {
    [
        ("silk", Fabric::silk(), [0.20, 0.40]),
        ("cotton", Fabric::cotton(), [0.60, 0.76]),
        ("wool", Fabric::wool(), [0.40, 0.70]),
        ("denim", Fabric::denim(), [0.70, 0.90]),
    ]
    .into_iter()
    .map(|(name, fabric, range)| Row::within("Cusick drape coefficient", name, range, coefficient(fabric)))
    .collect()
}

fn coefficient(fabric: Fabric) -> f64 {
    let (positions, triangles) = disc();
    let mesh = SurfaceMesh { positions: &positions, triangles: &triangles, uvs: None };
    let shape = RestShape::new(&mesh, &RestShapeOptions::default()).expect("a disc is a valid mesh");
    let mut cloth =
        Cloth::new(shape, Fabric { air_drag: 5.0, ..fabric }, SolverSettings::default()).expect("the fabric is valid");
    pin(&mut cloth, |x| x.length() < 1.001 * DISC);
    // Folds need something to begin with.
    place(&mut cloth, |x| x + DVec3::Y * (x.length() - DISC).max(0.0) * 0.02 * (5.0 * x.z.atan2(x.x)).cos());
    run(&mut cloth, DT, 4.0);
    let ring = core::f64::consts::PI * (FABRIC * FABRIC - DISC * DISC);
    (shadow(&cloth) - core::f64::consts::PI * DISC * DISC) / ring
}

/// In the plane y = 0: a ring of 6 i vertices at each i-th radius, so that triangles have nearly equal sides.
fn disc() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut positions = vec![DVec3::ZERO];
    let mut triangles = Vec::new();
    let start = |ring: u32| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) };
    for ring in 1..=RINGS {
        let radius = FABRIC * f64::from(ring) / f64::from(RINGS);
        for i in 0..6 * ring {
            let angle = core::f64::consts::TAU * f64::from(i) / f64::from(6 * ring);
            positions.push(DVec3::new(radius * angle.cos(), 0.0, radius * angle.sin()));
        }
        let outer = |i: u32| start(ring) + i % (6 * ring);
        let inner = |i: u32| start(ring - 1) + if ring == 1 { 0 } else { i % (6 * (ring - 1)) };
        for sector in 0..6 {
            for i in 0..ring {
                let (o, n) = (sector * ring + i, sector * (ring - 1) + i);
                triangles.push([outer(o), inner(n), outer(o + 1)]);
                if i + 1 < ring {
                    triangles.push([inner(n), inner(n + 1), outer(o + 1)]);
                }
            }
        }
    }
    (positions, triangles)
}

/// Area of the projection along y, m²: by points of a fine grid, as folds may lie one over the other.
fn shadow(cloth: &Cloth) -> f64 {
    const POINT: f64 = 5e-4;
    const SIDE: usize = 640;
    let mut covered = vec![false; SIDE * SIDE];
    let point = |i: usize| (i as f64 - 0.5 * SIDE as f64) * POINT;
    let index = |x: f64| ((x / POINT + 0.5 * SIDE as f64).round().max(0.0) as usize).min(SIDE - 1);
    for triangle in &cloth.shape().triangles {
        let [a, b, c] = triangle.vertices.map(|v| cloth.positions()[v as usize]);
        let area = |p: [f64; 2], q: DVec3, r: DVec3| (q.x - p[0]) * (r.z - p[1]) - (q.z - p[1]) * (r.x - p[0]);
        let [low, high] = [DVec3::min, DVec3::max].map(|extreme| extreme(extreme(a, b), c));
        for i in index(low.x)..=index(high.x) {
            for j in index(low.z)..=index(high.z) {
                let p = [point(i), point(j)];
                let sides = [area(p, a, b), area(p, b, c), area(p, c, a)];
                covered[SIDE * i + j] |= sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
            }
        }
    }
    covered.iter().filter(|&&covered| covered).count() as f64 * POINT * POINT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shadow_of_a_flat_disc_is_the_disc() {
        let (positions, triangles) = disc();
        let mesh = SurfaceMesh { positions: &positions, triangles: &triangles, uvs: None };
        let shape = RestShape::new(&mesh, &RestShapeOptions::default()).unwrap();
        assert_eq!(shape.vertex_count() as u32, 1 + 3 * RINGS * (RINGS + 1));
        let cloth = Cloth::new(shape, Fabric::silk(), SolverSettings::default()).unwrap();
        let circle = core::f64::consts::PI * FABRIC * FABRIC;
        assert!((shadow(&cloth) / circle - 1.0).abs() < 5e-3, "{} of {circle}", shadow(&cloth));
    }
}
