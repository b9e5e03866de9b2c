//! Levels of quality: what a change of level does to a cloth, which is nothing.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, Quality, SolverSettings, StepOutcome};

use crate::meshes::{TestMesh, crumpled, rng};
use rand::Rng;

const DT: f64 = 1.0 / 60.0;

fn hung(fabric: Fabric, quality: Quality) -> Cloth {
    let shape = TestMesh::sheet(13, 13, 1.0, 1.0).shape();
    let mut cloth = Cloth::new(shape, fabric, quality.settings()).unwrap();
    for vertex in [0, 12] {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    cloth
}

/// A level for each step: in turn, there and back between the ends, at random.
fn changes() -> [Box<dyn FnMut(usize) -> Quality>; 3] {
    let mut random = rng(3);
    [
        Box::new(|step| Quality::ALL[step % 5]),
        Box::new(|step| if step % 2 == 0 { Quality::Crowd } else { Quality::Film }),
        Box::new(move |_| Quality::ALL[random.random_range(0..5)]),
    ]
}

#[test]
fn a_change_of_level_leaves_rest_at_rest() {
    let fabric = Fabric { air_drag: 4.0, ..Fabric::wool() };
    let mut settled = hung(fabric, Quality::Film);
    for _ in 0..900 {
        settled.step(DT);
    }
    let rest = settled.positions().to_vec();
    for mut change in changes() {
        let mut cloth = hung(fabric, Quality::Film);
        cloth.set_state(&rest, &vec![DVec3::ZERO; rest.len()]);
        for step in 0..300 {
            cloth.set_settings(change(step).settings());
            assert_eq!(cloth.step(DT).fallbacks, 0);
            let off = cloth.positions().iter().zip(&rest).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(off < 1e-3, "step {step}: {off} m");
            let speed = cloth.velocities().iter().map(|v| v.length()).fold(0.0, f64::max);
            assert!(speed < 0.01, "step {step}: {speed} m/s");
        }
    }
}

#[test]
fn a_change_of_level_leaves_free_fall_exact() {
    for mut change in changes() {
        let shape = TestMesh::sheet(9, 9, 1.0, 1.0).shape();
        let fabric = Fabric { air_drag: 0.0, ..Fabric::cotton() };
        let mut cloth = Cloth::new(shape, fabric, SolverSettings::default()).unwrap();
        let start = cloth.positions().to_vec();
        for step in 1..=60 {
            cloth.set_settings(change(step).settings());
            cloth.step(DT);
            let fallen = 0.5 * 9.81 * (step as f64 * DT).powi(2);
            for (now, start) in cloth.positions().iter().zip(&start) {
                assert!(now.distance(*start - fallen * DVec3::Y) < 1e-5, "step {step}: {now} from {start}");
            }
        }
    }
}

#[test]
fn the_stretch_under_its_weight_is_the_same_at_every_level() {
    let tip = |settings: SolverSettings| {
        let shape = TestMesh::sheet(9, 9, 1.0, 1.0).shape();
        let fabric = Fabric { air_drag: 4.0, ..Fabric::isotropic(0.15, 69.0, 0.0, 1e-5) };
        let mut cloth = Cloth::new(shape, fabric, settings).unwrap();
        for vertex in 0..9 {
            cloth.pin(vertex, cloth.positions()[vertex as usize]);
        }
        for _ in 0..600 {
            cloth.step(DT);
        }
        -1.0 - cloth.positions()[72..].iter().map(|p| p.y).sum::<f64>() / 9.0
    };
    let exact = tip(SolverSettings::reference());
    for level in Quality::ALL {
        let ours = tip(level.settings());
        assert!((ours / exact - 1.0).abs() < 5e-3, "{level}: {ours} m, exactly {exact} m");
    }
}

#[test]
fn a_change_of_level_adds_no_energy() {
    // Of what there is to exchange: the fall of half a metre. Without damping BDF2 itself swings about the true energy, by one
    // per cent in a step of the default.
    for (fabric, of_a_step) in [(Fabric::cotton(), 1e-3), (Fabric::cotton().undamped(), 0.05)] {
        for mut change in changes() {
            let mut cloth = hung(fabric, Quality::Medium);
            let x: Vec<_> = cloth.positions().iter().map(|p| DVec3::new(p.x, 0.0, -p.y)).collect();
            cloth.set_state(&x, &crumpled(&vec![DVec3::ZERO; x.len()], 0.1, 1));
            let start = cloth.energy().total();
            let exchanged = 0.5 * 9.81 * cloth.masses().iter().sum::<f64>();
            let mut last = start;
            for step in 0..300 {
                cloth.set_settings(change(step).settings());
                assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);
                let energy = cloth.energy().total();
                assert!(energy < last + of_a_step * exchanged, "step {step}: from {last} to {energy} J");
                assert!(energy < start + 5e-3 * exchanged, "step {step}: from {start} to {energy} J");
                last = energy;
            }
        }
    }
}

#[test]
fn the_motion_goes_on_as_if_the_level_had_always_been_that() {
    // Substeps alike, so that the step before is of use to the next: only the tolerance changes.
    let run = |first: Quality| {
        let mut cloth = hung(Fabric::cotton(), first);
        let x: Vec<_> = cloth.positions().iter().map(|p| DVec3::new(p.x, 0.0, -p.y)).collect();
        cloth.set_state(&x, &vec![DVec3::ZERO; x.len()]);
        for _ in 0..20 {
            cloth.step(DT);
        }
        cloth.set_settings(Quality::Medium.settings());
        cloth
    };
    let (mut kept, mut changed) = (run(Quality::Medium), run(Quality::Low));
    changed.set_state(kept.positions(), kept.velocities());
    kept.set_settings(Quality::Low.settings());
    let before = kept.positions().to_vec();
    kept.set_settings(Quality::Medium.settings());
    assert_eq!(kept.positions(), before);
    kept.step(DT);
    changed.step(DT);
    // One has the state before the present one, the other has lost it and starts with a midpoint step.
    assert_ne!(kept.positions(), changed.positions());
    let mut straight = run(Quality::Medium);
    straight.step(DT);
    assert_eq!(kept.positions(), straight.positions());
}
