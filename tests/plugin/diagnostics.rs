//! `ClothDiagnosticsPlugin`.

use crate::common::{COUNT, app_with, run, sheet, spawn, state, top_edge};
use bevy::diagnostic::{DiagnosticPath, DiagnosticsPlugin, DiagnosticsStore};
use bevy::prelude::*;
use bevy_cloth::plugin::*;

fn app() -> App {
    app_with((ClothPlugin::default(), DiagnosticsPlugin, ClothDiagnosticsPlugin))
}

fn value(app: &App, path: &DiagnosticPath) -> Option<f64> {
    app.world().resource::<DiagnosticsStore>().get(path).expect("registered").value()
}

#[test]
fn figures_are_sums_over_the_cloths_that_step() {
    let mut app = app();
    run(&mut app, 2);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::CLOTHS), None, "nothing to measure");
    let first = spawn(&mut app, sheet(), top_edge());
    let second = spawn(&mut app, sheet(), ClothPins::indices([0]));
    run(&mut app, 3);

    assert_eq!(value(&app, &ClothDiagnosticsPlugin::CLOTHS), Some(2.0));
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::VERTICES), Some(f64::from(2 * COUNT)));
    let reports = [first, second].map(|cloth| *state(&app, cloth).last_report().unwrap());
    let iterations = reports.iter().map(|report| f64::from(report.iterations)).sum();
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::ITERATIONS), Some(iterations));
    assert!(iterations > 0.0);
    let total = reports.iter().map(|report| report.total.as_secs_f64()).sum::<f64>() * 1e3;
    let [step, assembly, solve] =
        [ClothDiagnosticsPlugin::STEP, ClothDiagnosticsPlugin::ASSEMBLY, ClothDiagnosticsPlugin::SOLVE]
            .map(|path| value(&app, &path).unwrap());
    assert!((step - total).abs() < 1e-9 && assembly > 0.0 && solve > 0.0 && assembly + solve <= step);

    app.world_mut().entity_mut(second).insert(ClothDisabled);
    run(&mut app, 2);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::CLOTHS), Some(1.0));
}

#[test]
fn a_paused_game_measures_nothing() {
    let mut app = app();
    spawn(&mut app, sheet(), ());
    run(&mut app, 3);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    run(&mut app, 2);
    let count = |app: &App| {
        let diagnostics = app.world().resource::<DiagnosticsStore>();
        diagnostics.get(&ClothDiagnosticsPlugin::STEP).unwrap().history_len()
    };
    let before = count(&app);
    run(&mut app, 5);
    assert_eq!((count(&app), before), (3, 3));
}
