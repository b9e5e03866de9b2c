//! More than one Newton iteration in a step.

use bevy::math::DVec3;
use bevy_cloth::physics::assembly::{ImplicitStep, Ordering, Projection, System};
use bevy_cloth::physics::{
    Cloth, Fabric, Integrator, Precision, SettingsError, SolverKind, SolverSettings, StepOutcome,
};

use crate::meshes::{TestMesh, crumpled};

const DT: f64 = 1.0 / 60.0;

/// Solved to rounding, so that only the linearisation is between a step and the exact one.
fn exact(newton_steps: u32, integrator: Integrator) -> SolverSettings {
    SolverSettings {
        kind: SolverKind::conjugate_gradient(1e-9),
        precision: Precision::Double,
        integrator,
        newton_steps,
        ..Default::default()
    }
}

/// Crumpled by this amount (m) and in motion: far from what one linearisation describes.
fn crumpled_cloth(amount: f64, pinned: bool, settings: SolverSettings) -> Cloth {
    let shape = TestMesh::jittered(11, 11, 1.0, 1.0, 0.2).shape();
    let mut cloth = Cloth::new(shape, Fabric { damping: 0.0, ..Fabric::jersey() }, settings).unwrap();
    for vertex in [0, 10].into_iter().filter(|_| pinned) {
        cloth.pin(vertex, cloth.positions()[vertex as usize] + 0.02 * DVec3::X);
    }
    let x = crumpled(cloth.positions(), amount, 1);
    let v = crumpled(&vec![DVec3::ZERO; x.len()], 0.5, 2);
    cloth.set_state(&x, &v);
    cloth
}

fn distance(a: &Cloth, b: &Cloth) -> f64 {
    a.positions().iter().zip(b.positions()).map(|(a, b)| a.distance_squared(*b)).sum::<f64>().sqrt()
}

#[test]
fn each_newton_step_leads_nearer_to_the_exact_step() {
    for pinned in [true, false] {
        for integrator in [Integrator::Bdf2, Integrator::BackwardEuler] {
            // The second step is the first that is BDF2's own: from the same state, whatever led there.
            let step = |newton_steps| {
                let mut cloth = crumpled_cloth(0.005, pinned, exact(60, integrator));
                assert_eq!(cloth.step(DT).fallbacks, 0);
                cloth.set_settings(exact(newton_steps, integrator));
                let report = cloth.step(DT);
                assert_eq!((report.outcome, report.fallbacks), (StepOutcome::Accepted, 0), "{newton_steps}");
                cloth
            };
            let converged = step(60);
            let errors = [1, 2, 4, 8, 16].map(|newton_steps| distance(&step(newton_steps), &converged));
            assert!(errors.windows(2).all(|pair| pair[1] < 0.7 * pair[0]), "{errors:?}");
            assert!(errors[4] < 1e-2 * errors[0], "{errors:?}");
        }
    }
}

/// Norm of M (y − x) + Δt² (f(x) + M g) at the free vertices of where a step of backward Euler led.
fn residual(pinned: bool, newton_steps: u32) -> f64 {
    let mut cloth = crumpled_cloth(0.02, pinned, exact(newton_steps, Integrator::BackwardEuler));
    let carried: Vec<_> = cloth.positions().iter().zip(cloth.velocities()).map(|(&x, &v)| x + DT * v).collect();
    let start = cloth.positions().to_vec();
    assert_eq!(cloth.step(DT).fallbacks, 0);
    let ordering = Ordering::new(cloth.shape());
    let inner = |values: &[DVec3]| -> Vec<_> { ordering.outer.iter().map(|&vertex| values[vertex as usize]).collect() };
    let (reached, carried, start) = (inner(cloth.positions()), inner(&carried), inner(&start));
    let masses: Vec<_> = ordering.outer.iter().map(|&vertex| cloth.masses()[vertex as usize]).collect();
    let mut system = System::<f64>::new(cloth.shape(), cloth.fabric(), &ordering);
    let step = ImplicitStep {
        x: &reached,
        inertial: &carried,
        origin: &start,
        gamma: DT,
        gravity: cloth.gravity(),
        damping: 0.0,
        wind: DVec3::ZERO,
        dissipates: true,
        projection: Projection::PositivePart,
        drift: DVec3::ZERO,
        inertia: None,
        stencils: &[],
    };
    system.settle(&reached);
    system.assemble(&step, &masses);
    let free = (0..masses.len()).filter(|&vertex| cloth.pin_target(ordering.outer[vertex]).is_none());
    free.map(|vertex| DVec3::from(system.rhs[vertex].to_f64()).length_squared()).sum::<f64>().sqrt()
}

#[test]
fn what_is_left_of_the_equation_of_motion_falls() {
    for pinned in [true, false] {
        let residuals = [1, 2, 4, 8].map(|newton_steps| residual(pinned, newton_steps));
        assert!(residuals.windows(2).all(|pair| pair[1] < 0.7 * pair[0]), "{residuals:?}");
        assert!(residuals[3] < 1e-2 * residuals[0], "{residuals:?}");
    }
}

#[test]
fn pins_are_reached_and_free_fall_is_exact() {
    let settings = SolverSettings { newton_steps: 3, ..Default::default() };
    let mut cloth = crumpled_cloth(0.02, true, settings);
    cloth.step(DT);
    for (vertex, target) in cloth.pinned() {
        assert_eq!(cloth.positions()[vertex as usize], target);
    }
    // Along g t²/2, from the first step on.
    let shape = TestMesh::sheet(9, 9, 1.0, 1.0).shape();
    let mut cloth = Cloth::new(shape, Fabric { air_drag: 0.0, ..Fabric::cotton() }, settings).unwrap();
    let start = cloth.positions().to_vec();
    for step in 1..=30 {
        cloth.step(DT);
        let fallen = 0.5 * 9.81 * (f64::from(step) * DT).powi(2);
        for (now, start) in cloth.positions().iter().zip(&start) {
            assert!(now.distance(*start - fallen * DVec3::Y) < 1e-5, "step {step}: {now} from {start}");
        }
    }
}

#[test]
fn violent_states_are_as_safe_as_with_one() {
    for dt in [DT, 0.25] {
        let fallbacks = [1, 3].map(|newton_steps| {
            let settings = SolverSettings { newton_steps, ..Default::default() };
            let mut cloth = crumpled_cloth(0.02, true, settings);
            let x = crumpled(cloth.positions(), 0.5, 3);
            cloth.set_state(&x, &crumpled(&vec![DVec3::ZERO; x.len()], 20.0, 4));
            let energy = cloth.energy();
            let limit = energy.total() + 0.1 * (energy.kinetic + energy.membrane + energy.bending);
            let mut fallbacks = 0;
            for step in 0..60 {
                let report = cloth.step(dt);
                assert_eq!(report.outcome, StepOutcome::Accepted);
                fallbacks += report.fallbacks;
                assert!(cloth.energy().total() < limit, "step {step} of {dt} s");
            }
            fallbacks
        });
        assert!(fallbacks[1] <= fallbacks[0] + 3, "{fallbacks:?} at {dt} s");
    }
}

#[test]
fn a_cloth_at_rest_takes_no_more_iterations() {
    let iterations = [1, 5].map(|newton_steps| {
        let settings = SolverSettings { newton_steps, ..Default::default() };
        let mut cloth = crumpled_cloth(0.02, true, settings);
        cloth.set_fabric(Fabric { air_drag: 4.0, ..Fabric::cotton() }).unwrap();
        for _ in 0..900 {
            cloth.step(DT);
        }
        cloth.step(DT).iterations
    });
    assert!(iterations[1] <= iterations[0] + 1, "{iterations:?}");
}

#[test]
fn none_is_refused() {
    let settings = SolverSettings { newton_steps: 0, ..Default::default() };
    assert_eq!(settings.validate(), Err(SettingsError::NoNewtonSteps));
}
