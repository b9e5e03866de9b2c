//! Levels of quality, settings given one by one, and which of them counts.

use crate::common::*;
use bevy::prelude::*;
use bevy_cloth::physics::{SolverKind, SolverSettings};
use bevy_cloth::plugin::*;

fn settings(app: &App, cloth: Entity) -> SolverSettings {
    *state(app, cloth).cloth().settings()
}

#[test]
fn the_nearest_word_counts() {
    let mut app = app();
    app.insert_resource(ClothDefaultQuality(ClothQuality::Low));
    let own = SolverSettings { kind: SolverKind::conjugate_gradient(1e-3), newton_steps: 2, ..default() };
    let plain = spawn(&mut app, sheet(), top_edge());
    let high = spawn(&mut app, sheet(), (top_edge(), ClothQuality::High));
    let explicit = spawn(&mut app, sheet(), (top_edge(), ClothQuality::High, ClothSolver(own)));
    let all = |app: &App| [plain, high, explicit].map(|cloth| settings(app, cloth));
    let (low, high_settings) = (ClothQuality::Low.settings(), ClothQuality::High.settings());
    assert_eq!(all(&app), [low, high_settings, own], "from the start");

    app.insert_resource(ClothDefaultQuality(ClothQuality::Film));
    run(&mut app, 1);
    assert_eq!(all(&app), [ClothQuality::Film.settings(), high_settings, own]);
    app.world_mut().entity_mut(high).remove::<ClothQuality>();
    app.world_mut().entity_mut(explicit).remove::<ClothSolver>();
    app.world_mut().entity_mut(plain).insert(ClothQuality::Crowd);
    run(&mut app, 1);
    assert_eq!(all(&app), [ClothQuality::Crowd.settings(), ClothQuality::Film.settings(), high_settings]);
}

#[test]
fn a_cloth_without_any_word_has_the_default() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ());
    assert_eq!(settings(&app, cloth), SolverSettings::default());
    assert!(app.world().get::<ClothSolver>(cloth).is_none() && app.world().get::<ClothQuality>(cloth).is_none());
}

#[test]
fn impossible_settings_taken_away_are_forgiven() {
    let wrong = ClothSolver(SolverSettings { newton_steps: 0, ..default() });
    let mut app = app();
    let running = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 2);
    app.world_mut().entity_mut(running).insert(wrong);
    let refused = spawn(&mut app, sheet(), (top_edge(), wrong));
    run(&mut app, 2);
    for cloth in [running, refused] {
        assert!(error(&app, cloth).expect("an error").to_string().contains("newton_steps"));
        app.world_mut().entity_mut(cloth).remove::<ClothSolver>();
    }
    run(&mut app, 2);
    for cloth in [running, refused] {
        assert!(error(&app, cloth).is_none(), "{:?}", error(&app, cloth));
        assert_eq!(settings(&app, cloth), SolverSettings::default());
    }
}

#[test]
fn the_lowest_levels_take_their_steps_in_turns() {
    let mut app = app();
    let spawn_at = |app: &mut App, quality| spawn(app, sheet(), (top_edge(), quality));
    let crowd: Vec<_> = (0..8).map(|_| spawn_at(&mut app, ClothQuality::Crowd)).collect();
    let low = spawn_at(&mut app, ClothQuality::Low);
    run(&mut app, 8);
    assert_eq!([crowd[0], low].map(|cloth| state(&app, cloth).update_interval()), [4, 2]);
    let positions = |app: &App, cloth: Entity| state(app, cloth).cloth().positions().to_vec();
    for _ in 0..8 {
        let all = |app: &App| crowd.iter().map(|&cloth| positions(app, cloth)).collect::<Vec<_>>();
        let before = all(&app);
        app.update();
        let stepped = all(&app).iter().zip(&before).filter(|(now, before)| now != before).count();
        assert_eq!(stepped, 2, "of eight that take a step in four ticks");
    }
    app.world_mut().entity_mut(low).insert(ClothQuality::Medium);
    run(&mut app, 2);
    for _ in 0..4 {
        let before = positions(&app, low);
        app.update();
        assert_ne!(positions(&app, low), before);
    }
}

#[test]
fn changing_the_level_in_every_frame_moves_nothing_out_of_its_way() {
    let mut app = app();
    let steady = spawn(&mut app, sheet(), ClothPins::indices([0]));
    let restless = spawn(&mut app, sheet(), ClothPins::indices([0]));
    let levels = [ClothQuality::Crowd, ClothQuality::Film, ClothQuality::Low, ClothQuality::High];
    let mut before = world(&app, restless);
    for frame in 0..200 {
        app.world_mut().entity_mut(restless).insert(levels[frame % 4]);
        app.update();
        let now = world(&app, restless);
        // A metre of cloth that falls from the horizontal by a corner moves at some metres a second.
        let moved = now.iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(moved < 8.0 / 64.0, "frame {frame}: {moved} m");
        before = now;
    }
    run(&mut app, 900);
    // By a corner, a sheet hangs folded to one side or to the other.
    let mirrored = |p: Vec3| p.with_z(p.z.abs());
    for (a, b) in world(&app, steady).into_iter().zip(world(&app, restless)) {
        assert_near(mirrored(a), mirrored(b), 0.02);
    }
}
