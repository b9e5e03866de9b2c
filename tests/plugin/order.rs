//! The order of systems is decided: none is left to chance.

use crate::common::{app_with, run, sheet, spawn, world};
use bevy::app::FixedPostUpdate;
use bevy::diagnostic::DiagnosticsPlugin;
use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel};
use bevy::prelude::*;
use bevy_cloth::plugin::*;

/// Makes every schedule that cloth is in refuse to run if two of its systems conflict. (Added before the first frame: a
/// schedule that was built is not built again.)
fn forbid_ambiguities(app: &mut App) {
    let settings = ScheduleBuildSettings { ambiguity_detection: LogLevel::Error, ..default() };
    for label in [FixedUpdate.intern(), FixedPostUpdate.intern(), PostUpdate.intern(), Last.intern()] {
        app.edit_schedule(label, |schedule| {
            schedule.set_build_settings(settings.clone());
        });
    }
}

#[test]
fn there_are_no_ambiguities() {
    for plugin in [ClothPlugin::default(), ClothPlugin::new(FixedPostUpdate)] {
        let plugins = (plugin, DiagnosticsPlugin, ClothDiagnosticsPlugin);
        #[cfg(feature = "debug")]
        let plugins = (plugins, bevy::gizmos::GizmoPlugin, ClothDebugPlugin);
        let mut app = app_with((plugins, forbid_ambiguities));
        let cloth = spawn(&mut app, sheet(), ());
        run(&mut app, 3);
        assert!(world(&app, cloth)[0].y < 0.0);
    }
}

fn intruder(app: &mut App) {
    app.add_systems(PostUpdate, |mut cloths: Query<&mut ClothState>| cloths.iter_mut().for_each(|_| ()));
}

#[test]
#[should_panic = "indeterminate execution order"]
fn an_ambiguity_would_be_found() {
    let _ = app_with((ClothPlugin::default(), intruder, forbid_ambiguities));
}
