//! What a step does and does not do to a cloth.

use bevy::math::DVec3;
use bevy_cloth::physics::{
    Cloth, ClothFault, Fabric, Integrator, MaterialError, NewClothError, Precision, RestShape, SettingsError,
    SolverKind, SolverSettings, StepOutcome,
};

use crate::meshes::{TestMesh, crumpled};

const DT: f64 = 1.0 / 60.0;

fn cloth(fabric: Fabric, settings: SolverSettings) -> Cloth {
    Cloth::new(TestMesh::sheet(9, 9, 1.0, 1.0).shape(), fabric, settings).unwrap()
}

fn hung(fabric: Fabric, settings: SolverSettings) -> Cloth {
    let mut cloth = cloth(fabric, settings);
    for vertex in [0, 8] {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    cloth
}

#[test]
fn a_hanging_cloth_comes_to_rest() {
    for dt in [1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0] {
        let mut cloth = hung(Fabric { air_drag: 2.0, ..Fabric::cotton() }, SolverSettings::default());
        let start = crumpled(cloth.positions(), 1e-3, 1);
        cloth.set_state(&start, &vec![DVec3::ZERO; start.len()]);
        let energy = cloth.energy().total();
        let mut peak = 0.0_f64;
        for _ in 0..(12.0 / dt) as u32 {
            let report = cloth.step(dt);
            assert_eq!((report.outcome, report.fallbacks), (StepOutcome::Accepted, 0));
            peak = peak.max(cloth.energy().kinetic);
            assert!(cloth.energy().total() < energy + 1e-6);
        }
        let rest = cloth.energy().kinetic;
        assert!(rest < 1e-6 * peak, "{rest:e} of {peak:e} J at {dt}");
        let jitter = fast_acceleration(&mut cloth, dt);
        assert!(jitter < 0.01, "{jitter} m/s² at {dt}");
    }
}

/// Root mean square acceleration above 15 Hz over the next second, m/s²: what is left of it after a moving average.
fn fast_acceleration(cloth: &mut Cloth, dt: f64) -> f64 {
    let mut velocities = vec![cloth.velocities().to_vec()];
    for _ in 0..(1.0 / dt) as u32 {
        cloth.step(dt);
        velocities.push(cloth.velocities().to_vec());
    }
    let window = (1.0 / (15.0 * dt)).round() as usize;
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for vertex in 0..velocities[0].len() {
        let change = |from: usize, to: usize| (velocities[to][vertex] - velocities[from][vertex]) / dt;
        for step in window..velocities.len() - window {
            let start = step - window / 2;
            let slow = change(start, start + window) / window as f64;
            sum += (change(step, step + 1) - slow).length_squared();
            count += 1.0;
        }
    }
    (sum / count).sqrt()
}

#[test]
fn backward_euler_loses_energy_in_every_step() {
    let settings = SolverSettings { integrator: Integrator::BackwardEuler, ..Default::default() };
    let mut cloth = hung(Fabric::cotton().undamped(), settings);
    let start = crumpled(cloth.positions(), 0.01, 1);
    cloth.set_state(&start, &vec![DVec3::ZERO; start.len()]);
    let mut last = cloth.energy().total();
    for _ in 0..600 {
        cloth.step(DT);
        let energy = cloth.energy().total();
        assert!(energy < last + 1e-6, "energy rose from {last} to {energy} J");
        last = energy;
    }
}

/// Angular momentum kept after a second of free spin at 1 Hz without air.
fn spin_kept(settings: SolverSettings) -> f64 {
    let mut cloth = cloth(Fabric { air_drag: 0.0, ..Fabric::denim() }, settings);
    cloth.set_gravity(DVec3::ZERO);
    let x = cloth.positions().to_vec();
    let spin = core::f64::consts::TAU * DVec3::Z;
    let v: Vec<_> = x.iter().map(|&x| spin.cross(x - DVec3::new(0.5, -0.5, 0.0))).collect();
    cloth.set_state(&x, &v);
    let momentum = |cloth: &Cloth| -> DVec3 {
        let terms = cloth.positions().iter().zip(cloth.velocities()).zip(cloth.masses());
        terms.map(|((x, &v), &m)| m * x.cross(v)).sum()
    };
    let before = momentum(&cloth);
    for _ in 0..60 {
        cloth.step(DT);
    }
    momentum(&cloth).dot(before) / before.length_squared()
}

#[test]
fn a_spinning_cloth_keeps_spinning() {
    let kept = spin_kept(SolverSettings::default());
    assert!((0.99..1.005).contains(&kept), "BDF2 keeps {kept}");
    let kept = spin_kept(SolverSettings { integrator: Integrator::BackwardEuler, ..Default::default() });
    assert!(kept < 0.5, "backward Euler keeps {kept}");
}

#[test]
fn no_energy_is_gained_from_violent_states() {
    // Crumpled by ten times the edge length, at stiff and soft fabrics and steps up to a second.
    for fabric in [Fabric::silk(), Fabric::canvas(), Fabric::rubber()] {
        for dt in [1.0 / 240.0, DT, 0.25, 1.0] {
            let mut cloth = hung(fabric.undamped(), SolverSettings::default());
            let start = crumpled(cloth.positions(), 1.0, 3);
            cloth.set_state(&start, &crumpled(&vec![DVec3::ZERO; start.len()], 20.0, 4));
            let energy = cloth.energy();
            let limit = energy.total() + 0.1 * (energy.kinetic + energy.membrane + energy.bending);
            let mut fallbacks = 0;
            for step in 0..40 {
                let report = cloth.step(dt);
                assert_eq!(report.outcome, StepOutcome::Accepted);
                fallbacks += report.fallbacks;
                let now = cloth.energy().total();
                assert!(now < limit, "step {step} of {dt} s: {now} J of {limit}");
            }
            assert!(fallbacks < 40, "every step fell back");
        }
    }
}

#[test]
fn rest_does_not_depend_on_step_tolerance_precision_or_solver() {
    let fabric = Fabric { air_drag: 4.0, ..Fabric::wool() };
    let settle = |dt: f64, settings| {
        let mut cloth = hung(fabric, settings);
        for _ in 0..(15.0 / dt) as u32 {
            cloth.step(dt);
        }
        cloth.positions().to_vec()
    };
    let pcg = |tolerance, precision| SolverSettings {
        kind: SolverKind::conjugate_gradient(tolerance),
        precision,
        ..Default::default()
    };
    let reference = settle(1.0 / 60.0, SolverSettings::reference());
    let others = [
        settle(1.0 / 30.0, pcg(1e-2, Precision::Single)),
        settle(1.0 / 120.0, pcg(1e-2, Precision::Double)),
        settle(1.0 / 60.0, pcg(1e-6, Precision::Double)),
    ];
    for other in others {
        let error = reference.iter().zip(&other).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(error < 2e-4, "{error:e} m");
    }
}

#[test]
fn a_quick_solve_stretches_as_an_exact_one() {
    // Falling from the horizontal, for a swing; the mean over it, as single frames are far apart in a chaotic swing.
    let stretch = |settings| {
        let mut mesh = TestMesh::sheet(25, 25, 1.0, 1.0);
        for p in &mut mesh.positions {
            *p = DVec3::new(p.x, 0.0, -p.y);
        }
        let mut cloth = Cloth::new(mesh.shape(), Fabric::isotropic(0.15, 1000.0, 0.3, 1e-5), settings).unwrap();
        for vertex in [0, 24] {
            cloth.pin(vertex, cloth.positions()[vertex as usize]);
        }
        (0..30).map(|_| (cloth.step(DT), cloth.stretch().rms).1).sum::<f64>() / 30.0
    };
    let (quick, exact) = (stretch(SolverSettings::default()), stretch(SolverSettings::reference()));
    assert!((quick / exact - 1.0).abs() < 0.02, "{quick} against {exact}");
}

#[test]
fn material_damping_damps_deformation() {
    let kinetic = |damping: f32| {
        let mut cloth = cloth(Fabric { damping, ..Fabric::jersey().undamped() }, SolverSettings::reference());
        cloth.set_gravity(DVec3::ZERO);
        let x: Vec<_> = cloth.positions().iter().map(|&p| p * 1.05).collect();
        cloth.set_state(&x, &vec![DVec3::ZERO; x.len()]);
        (0..30).map(|_| (cloth.step(1e-3), cloth.energy().kinetic).1).fold(0.0, f64::max)
    };
    assert!(kinetic(0.05) < 0.5 * kinetic(0.0));
}

#[test]
fn a_step_of_zero_does_nothing_and_bad_steps_are_refused() {
    let mut cloth = hung(Fabric::silk(), SolverSettings::default());
    for _ in 0..10 {
        cloth.step(DT);
    }
    let (x, v) = (cloth.positions().to_vec(), cloth.velocities().to_vec());
    assert_eq!(cloth.step(0.0).outcome, StepOutcome::Accepted);
    assert_eq!((cloth.positions(), cloth.velocities()), (&x[..], &v[..]));
    for dt in [-DT, f64::NAN, f64::INFINITY] {
        assert_eq!(cloth.step(dt).outcome, StepOutcome::Rejected(ClothFault::TimeStep));
        assert_eq!(cloth.positions(), x);
    }
}

#[test]
fn a_step_that_fails_leaves_the_cloth_where_it_was_and_the_next_one_works() {
    for settings in [SolverSettings::default(), SolverSettings::reference()] {
        let mut cloth = hung(Fabric::silk(), settings);
        cloth.step(DT);
        let x = cloth.positions().to_vec();
        let mut v = cloth.velocities().to_vec();
        v[40] = DVec3::NAN;
        cloth.set_state(&x, &v);
        assert_eq!(cloth.step(DT).outcome, StepOutcome::Rejected(ClothFault::NotFinite));
        assert_eq!(cloth.positions(), x);
        assert!(cloth.velocities().iter().all(|&v| v == DVec3::ZERO));
        assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);

        let target = cloth.pin_target(0).unwrap();
        cloth.pin(0, DVec3::NAN);
        assert!(matches!(cloth.step(DT).outcome, StepOutcome::Rejected(_)));
        cloth.pin(0, target);
        assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);
        assert!(cloth.positions().iter().all(|x| x.is_finite()));
    }
}

#[test]
fn fabric_and_settings_change_on_the_fly() {
    let mut cloth = hung(Fabric::jersey(), SolverSettings::default());
    for _ in 0..300 {
        cloth.step(DT);
    }
    let (soft, before) = (cloth.stretch().max, cloth.positions().to_vec());
    let bad = Fabric { density: f32::NAN, ..Fabric::denim() };
    assert!(matches!(cloth.set_fabric(bad), Err(MaterialError::OutOfRange { constant: "density", .. })));
    assert_eq!(*cloth.fabric(), Fabric::jersey());
    cloth.set_fabric(Fabric::denim()).unwrap();
    cloth.set_settings(SolverSettings { substeps: 2, ..SolverSettings::reference() });
    assert_eq!(cloth.positions(), before);
    assert!((cloth.masses().iter().sum::<f64>() - 0.4).abs() < 1e-6);
    for _ in 0..300 {
        cloth.step(DT);
    }
    assert!(cloth.stretch().max < 0.3 * soft, "{} of {soft}", cloth.stretch().max);
}

#[test]
fn stretch_counts_yarns_not_shear() {
    let shape: RestShape = TestMesh::sheet(4, 4, 1.0, 1.0).shape();
    let mut cloth = Cloth::new(shape, Fabric::cotton(), SolverSettings::default()).unwrap();
    let mut deform = |f: &dyn Fn(DVec3) -> DVec3| {
        let x: Vec<_> = cloth.shape().positions.iter().map(|&p| f(p)).collect();
        cloth.set_state(&x, &vec![DVec3::ZERO; x.len()]);
        cloth.stretch()
    };
    let stretched = deform(&|p| DVec3::new(1.1 * p.x, p.y, p.z));
    assert!((stretched.max - 0.1).abs() < 1e-12 && (stretched.rms - 0.1 / 2f64.sqrt()).abs() < 1e-12);
    let angle = 0.4_f64;
    let sheared = deform(&|p| DVec3::new(p.x + p.y * angle.sin(), p.y * angle.cos(), p.z));
    assert!(sheared.max < 1e-12 && sheared.rms < 1e-12, "{sheared:?}");
}

#[test]
fn invalid_fabrics_make_no_cloth() {
    let shape = TestMesh::sheet(3, 3, 1.0, 1.0).shape();
    let fabric = Fabric { coupling: 1e9, ..Fabric::cotton() };
    let error = Cloth::new(shape, fabric, SolverSettings::default()).err();
    assert!(matches!(error, Some(NewClothError::Fabric(MaterialError::NotPositive { .. }))));
}

#[test]
fn invalid_settings_make_no_cloth() {
    let of = |settings| Cloth::new(TestMesh::sheet(3, 3, 1.0, 1.0).shape(), Fabric::cotton(), settings).err();
    let good = SolverSettings::default();
    assert_eq!(of(good), None);
    let wrong = [
        (SolverSettings { substeps: 0, ..good }, SettingsError::NoSubsteps),
        (SolverSettings { newton_steps: 0, ..good }, SettingsError::NoNewtonSteps),
    ];
    for (settings, error) in wrong {
        assert_eq!(of(settings), Some(NewClothError::Settings(error)));
        assert!(NewClothError::Settings(error).to_string().starts_with("the settings: `"));
    }
}
