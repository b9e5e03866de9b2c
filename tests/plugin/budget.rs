//! `ClothBudget`: nothing is left to chance here, so the time is either plenty or none at all.

use std::time::Duration;

use crate::common::*;
use bevy::diagnostic::{DiagnosticPath, DiagnosticsPlugin, DiagnosticsStore};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::physics::{Fabric, SolverKind, SolverSettings};
use bevy_cloth::plugin::*;

const PLENTY: ClothBudget = ClothBudget { ms: 1e6 };
const NONE: ClothBudget = ClothBudget { ms: 0.0 };

/// A frame takes this many fixed steps of 1/64 s.
fn set_frame(app: &mut App, steps: f64) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(steps / 64.0)));
}

fn simulated(app: &App, cloth: Entity) -> Vec<DVec3> {
    state(app, cloth).cloth().positions().to_vec()
}

fn largest_move(before: &[Vec3], now: &[Vec3]) -> f32 {
    before.iter().zip(now).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn a_budget_that_suffices_changes_nothing() {
    let run_with = |budget: Option<ClothBudget>| {
        let mut app = app();
        let cloths = [ClothQuality::Film, ClothQuality::Medium]
            .map(|quality| spawn(&mut app, sheet(), (ClothPins::indices([0]), quality)));
        if let Some(budget) = budget {
            app.insert_resource(budget);
        }
        run(&mut app, 60);
        let report = *app.world().resource::<ClothBudgetReport>();
        (cloths.map(|cloth| (simulated(&app, cloth), state(&app, cloth).quality())), report)
    };
    let (plain, none) = run_with(None);
    let (with, report) = run_with(Some(PLENTY));
    assert_eq!(plain, with);
    assert_eq!(plain[0].1, Some(ClothQuality::Film));
    assert_eq!(none, ClothBudgetReport::default());
    assert!(report.lowered == 0 && !report.exhausted && report.measured_ms > 0.0, "{report:?}");
    assert!(report.predicted_ms > 0.0 && report.predicted_ms == report.requested_ms, "{report:?}");
}

#[test]
fn without_time_everything_goes_to_the_end_of_its_ladder_and_comes_back() {
    let mut app = app();
    let own = SolverSettings { kind: SolverKind::conjugate_gradient(1e-3), substeps: 2, ..default() };
    let cloth = spawn(&mut app, sheet(), (ClothPins::indices([0]), ClothQuality::High));
    let explicit = spawn(&mut app, sheet(), (ClothPins::indices([0]), ClothSolver(own)));
    run(&mut app, 5);
    assert_eq!(state(&app, cloth).update_interval(), 1);

    app.insert_resource(NONE);
    run(&mut app, 20);
    assert_eq!(state(&app, cloth).quality(), Some(ClothQuality::Crowd));
    assert_eq!(*state(&app, cloth).cloth().settings(), ClothQuality::Crowd.settings());
    assert_eq!((state(&app, explicit).quality(), *state(&app, explicit).cloth().settings()), (None, own));
    let report = *app.world().resource::<ClothBudgetReport>();
    assert!(report.exhausted && report.lowered == 2 && report.predicted_ms < report.requested_ms, "{report:?}");
    for cloth in [cloth, explicit] {
        assert_eq!(state(&app, cloth).update_interval(), 8);
        let mut changes = 0;
        for _ in 0..32 {
            let before = simulated(&app, cloth);
            app.update();
            changes += usize::from(simulated(&app, cloth) != before);
        }
        assert_eq!(changes, 4, "a step in eight ticks");
    }

    app.world_mut().remove_resource::<ClothBudget>();
    // Eight, four and two ticks: what moved in a long step is not shown at once.
    run(&mut app, 16);
    for cloth in [cloth, explicit] {
        assert_eq!(state(&app, cloth).update_interval(), 1);
        for _ in 0..8 {
            let before = simulated(&app, cloth);
            app.update();
            assert_ne!(simulated(&app, cloth), before);
        }
    }
    assert_eq!(state(&app, cloth).quality(), Some(ClothQuality::High));
    assert_eq!(*app.world().resource::<ClothBudgetReport>(), ClothBudgetReport::default());
}

#[test]
fn with_time_again_it_is_given_back_by_and_by() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), (ClothPins::indices([0]), ClothQuality::High));
    app.insert_resource(NONE);
    run(&mut app, 20);
    app.insert_resource(PLENTY);
    let (mut rungs, mut last) = (0, (state(&app, cloth).quality(), 8));
    for _ in 0..200 {
        app.update();
        let now = (state(&app, cloth).quality(), state(&app, cloth).update_interval());
        if now != last {
            assert!(now.0 >= last.0 && now.1 <= last.1, "from {last:?} to {now:?}");
            (rungs, last) = (rungs + 1, now);
        }
    }
    assert_eq!((rungs, last), (4, (Some(ClothQuality::High), 1)));
}

#[test]
fn no_time_is_lost_in_long_steps() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothMaterial(Fabric { air_drag: 0.0, ..Fabric::cotton() }));
    let start = simulated(&app, cloth)[0].y;
    let mut steps = 0;
    for tick in 1..=96 {
        match tick {
            10 => app.insert_resource(NONE),
            60 => app.insert_resource(PLENTY),
            _ => &mut app,
        };
        let before = simulated(&app, cloth);
        app.update();
        let now = simulated(&app, cloth);
        if now != before {
            steps += 1;
            let t = f64::from(tick) / 64.0;
            assert!((now[0].y - start + 0.5 * 9.81 * t * t).abs() < 1e-4, "tick {tick}: {}", now[0].y);
        }
    }
    assert!((20..60).contains(&steps), "{steps}");
}

#[test]
fn pins_stay_with_their_entity_between_long_steps() {
    let mut app = app_with(ClothPlugin::default());
    let cloth = spawn(&mut app, sheet(), top_edge());
    app.insert_resource(NONE);
    set_frame(&mut app, 0.7);
    let mut interval = 0;
    for frame in 0..120 {
        let t = 0.011 * frame as f32;
        let turned = Transform::from_xyz(t * 3.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(3.0 * t));
        *app.world_mut().get_mut::<Transform>(cloth).unwrap() = turned;
        app.update();
        interval = interval.max(state(&app, cloth).update_interval());
        for (vertex, rest) in vectors(&sheet(), Mesh::ATTRIBUTE_POSITION).iter().enumerate().take(5) {
            assert_near(local(&app, cloth)[vertex], *rest, 1e-6);
        }
    }
    assert_eq!(interval, 8);
}

#[test]
fn a_jump_between_long_steps_carries_the_cloth_along() {
    let mut app = app_with(ClothPlugin::default());
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    app.insert_resource(NONE);
    run(&mut app, 40);
    for _ in 0..12 {
        let speed = state(&app, cloth).cloth().velocities().iter().map(|v| v.length()).fold(0.0, f64::max) as f32;
        let before = local(&app, cloth);
        app.world_mut().get_mut::<Transform>(cloth).unwrap().translation.x += 50.0;
        app.update();
        // Shown is where the last step led, up to eight ticks ahead of what was shown before.
        assert!(largest_move(&before, &local(&app, cloth)) < 10.0 * speed / 64.0 + 1e-3);
        assert_near(local(&app, cloth)[0], Vec3::ZERO, 1e-4);
        run(&mut app, 4);
    }
    assert!(state(&app, cloth).cloth().positions()[0].x > 500.0);
}

#[test]
fn nothing_pops_when_time_runs_out_and_comes_back() {
    let motion = |budgets: &[(usize, ClothBudget)]| {
        let mut app = app_with(ClothPlugin::default());
        let cloth = spawn(&mut app, sheet(), (ClothPins::indices([0]), ClothMaterial::denim()));
        let mut before = world(&app, cloth);
        let moves: Vec<f32> = (0..240)
            .map(|frame| {
                if let Some((_, budget)) = budgets.iter().find(|(at, _)| *at == frame) {
                    app.insert_resource(*budget);
                }
                app.update();
                let now = world(&app, cloth);
                largest_move(&core::mem::replace(&mut before, now.clone()), &now)
            })
            .collect();
        moves.into_iter().fold(0.0, f32::max)
    };
    let free = motion(&[]);
    let budgeted = motion(&[(30, NONE), (90, PLENTY), (150, NONE), (170, PLENTY)]);
    // Catching up, two ticks are shown in one, at most.
    assert!(budgeted < 2.2 * free, "{budgeted} m in a frame, {free} m without a budget");
}

#[test]
fn diagnostics_tell_what_the_budget_did() {
    let mut app = app_with((ClothPlugin::default(), DiagnosticsPlugin, ClothDiagnosticsPlugin));
    spawn(&mut app, sheet(), top_edge());
    let value = |app: &App, path: &DiagnosticPath| {
        app.world().resource::<DiagnosticsStore>().get(path).expect("registered").value()
    };
    run(&mut app, 3);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::BUDGET_MEASURED), None);
    app.insert_resource(NONE);
    run(&mut app, 10);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::BUDGET_LOWERED), Some(1.0));
    let report = *app.world().resource::<ClothBudgetReport>();
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::BUDGET_MEASURED), Some(report.measured_ms.into()));
}
