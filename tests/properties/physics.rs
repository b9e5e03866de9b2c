//! What every cloth keeps to.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Precision, RestShape, RestShapeOptions, SolverSettings, StepOutcome};
use proptest::prelude::*;

use crate::cases;
use crate::generators::*;

const DT: f64 = 1.0 / 60.0;

fn elastic(cloth: &Cloth) -> f64 {
    let energy = cloth.energy();
    energy.membrane + energy.bending
}

/// Side of the box around it, m.
fn size(positions: &[DVec3]) -> f64 {
    let bounds = positions.iter().fold((DVec3::MAX, DVec3::MIN), |(a, b), &x| (a.min(x), b.max(x)));
    (bounds.1 - bounds.0).max_element()
}

fn largest_distance(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// Deforms a cloth by up to this share of its size.
fn deform(cloth: &mut Cloth, by: f64, off: &[DVec3], velocities: &[DVec3]) {
    let scale = by * size(cloth.positions());
    let positions: Vec<_> = cloth.positions().iter().zip(off).map(|(&x, &off)| x + scale * off).collect();
    cloth.set_state(&positions, &velocities[..positions.len()]);
}

/// Most vertices of a [`surface`].
const MOST: usize = 49;

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn the_rest_shape_has_no_energy_and_stays(surface in surface(), fabric in ordinary_fabric(), motion in rigid_motion()) {
        for (precision, tolerance) in [(Precision::Single, 2e-5), (Precision::Double, 1e-9)] {
            let mut cloth = surface.cloth(fabric, SolverSettings { precision, ..Default::default() });
            cloth.carry(motion);
            cloth.set_gravity(DVec3::ZERO);
            let before = cloth.positions().to_vec();
            let stiffness = f64::from(fabric.warp_stiffness) + f64::from(fabric.warp_bending);
            prop_assert!(elastic(&cloth) < tolerance * tolerance * stiffness, "{} J", elastic(&cloth));
            for _ in 0..10 {
                cloth.step(DT);
            }
            let moved = largest_distance(cloth.positions(), &before) / size(&before);
            prop_assert!(moved < tolerance, "{moved} of its size, {precision:?}");
        }
    }

    #[test]
    fn rigid_motion_changes_no_energy(
        surface in surface(),
        fabric in any_fabric(),
        motion in rigid_motion(),
        off in vectors(MOST),
    ) {
        let mut cloth = surface.cloth(fabric, SolverSettings { precision: Precision::Double, ..Default::default() });
        deform(&mut cloth, 0.05, &off, &[DVec3::ZERO; MOST]);
        let before = elastic(&cloth);
        let moved: Vec<_> = cloth.positions().iter().map(|&x| motion.transform_point3(x)).collect();
        cloth.set_state(&moved, &vec![DVec3::ZERO; moved.len()]);
        let after = elastic(&cloth);
        prop_assert!(before > 0.0 && (after / before - 1.0).abs() < 1e-8, "{before} J, then {after} J");
    }

    #[test]
    fn the_mass_is_that_of_the_area(surface in surface(), fabric in any_fabric()) {
        let area: f64 = surface.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|v| surface.positions[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        }).sum();
        let cloth = surface.cloth(fabric, SolverSettings::default());
        let mass: f64 = cloth.masses().iter().sum();
        prop_assert!((mass / (area * f64::from(fabric.density)) - 1.0).abs() < 1e-9);
        prop_assert!(cloth.masses().iter().all(|&mass| mass > 0.0));
    }

    #[test]
    fn the_order_of_triangles_and_of_their_corners_does_not_matter(
        surface in surface(),
        fabric in ordinary_fabric(),
        order in Just((0..2 * 36).collect::<Vec<usize>>()).prop_shuffle(),
        turns in prop::collection::vec(0..3_usize, 2 * 36),
        off in vectors(MOST),
    ) {
        let run = |surface: &Surface| {
            let mut cloth = surface.cloth(fabric, SolverSettings::reference());
            cloth.pin(0, surface.positions[0]);
            deform(&mut cloth, 0.02, &off, &[DVec3::ZERO; MOST]);
            let energy = elastic(&cloth);
            for _ in 0..5 {
                cloth.step(DT);
            }
            (energy, cloth.positions().to_vec())
        };
        let mut other = surface.clone();
        let order = order.into_iter().filter(|&triangle| triangle < surface.triangles.len());
        other.triangles = order.map(|triangle| {
            let mut corners = surface.triangles[triangle];
            corners.rotate_left(turns[triangle]);
            corners
        }).collect();
        let ((energy, positions), (other_energy, other_positions)) = (run(&surface), run(&other));
        prop_assert!((other_energy / energy - 1.0).abs() < 1e-9, "{energy} J and {other_energy} J");
        let apart = largest_distance(&positions, &other_positions) / size(&positions);
        prop_assert!(apart < 1e-7, "{apart} of its size");
    }

    #[test]
    fn a_free_cloth_keeps_its_momentum(
        surface in surface(),
        fabric in ordinary_fabric(),
        integrator in any_integrator(),
        off in vectors(MOST),
        velocities in vectors(MOST),
    ) {
        let mut cloth = surface.cloth(fabric.undamped(), SolverSettings { integrator, ..Default::default() });
        cloth.set_gravity(DVec3::ZERO);
        deform(&mut cloth, 0.01, &off, &velocities);
        let momentum = |cloth: &Cloth| -> DVec3 {
            cloth.velocities().iter().zip(cloth.masses()).map(|(&v, &mass)| mass * v).sum()
        };
        let (mass, before) = (cloth.masses().iter().sum::<f64>(), momentum(&cloth));
        for _ in 0..5 {
            let report = cloth.step(DT);
            // What the safeguard takes from the velocities, it takes from the momentum.
            prop_assume!(report.fallbacks == 0 && report.velocity_clamps == 0);
        }
        let lost = momentum(&cloth).distance(before) / mass;
        prop_assert!(lost < 1e-4, "{lost} m/s of up to 1.7 m/s");
    }

    #[test]
    fn every_fabric_steps_from_every_state(
        surface in surface(),
        fabric in any_fabric(),
        bending in any_bending(),
        integrator in any_integrator(),
        dt in any_step(),
        off in vectors(MOST),
        velocities in vectors(MOST),
        target in vector(),
    ) {
        let shape = RestShape::new(&surface.mesh(), &RestShapeOptions { bending, ..Default::default() }).expect("valid");
        let mut cloth = Cloth::new(shape, fabric, SolverSettings { integrator, ..Default::default() }).expect("valid");
        let velocities: Vec<_> = velocities.iter().map(|&v| 100.0 * v).collect();
        deform(&mut cloth, 1.0, &off, &velocities);
        cloth.pin(0, target);
        for _ in 0..4 {
            let report = cloth.step(dt);
            prop_assert_eq!(report.outcome, StepOutcome::Accepted);
            prop_assert!(cloth.positions().iter().chain(cloth.velocities()).all(|v| v.is_finite()));
            prop_assert_eq!(cloth.positions()[0], target);
        }
    }
}
