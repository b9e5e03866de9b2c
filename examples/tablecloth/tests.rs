use crate::{
    scene::{HELD, TableclothPlugin},
    table,
};
use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, prelude::*};
use example_common::{
    clock::SceneReset,
    off_screen::{start, step},
    penetration::deepest,
};

fn scene() -> App {
    start(None, |app| {
        app.add_plugins(TableclothPlugin { fabric: Fabric::cotton(), resolution: 17 });
    })
    .expect("a scene")
}

fn positions(app: &mut App) -> Vec<Vec3> {
    let mut cloths = app.world_mut().query::<&ClothState>();
    let state = cloths.single(app.world()).expect("one cloth");
    state.cloth().positions().iter().map(|position| position.as_vec3()).collect()
}

/// Runs for so many seconds.
fn run(app: &mut App, seconds: f32) {
    for _ in 0..(60.0 * seconds) as u32 {
        step(app).expect("no error");
    }
}

#[test]
fn the_cloth_falls_over_the_table_and_what_is_on_it_and_a_reset_lifts_it() {
    let mut app = scene();
    let before = positions(&mut app);
    run(&mut app, HELD - 0.1);
    let held = positions(&mut app);
    assert_eq!((held[0], held[16]), (before[0], before[16]), "the corners are held");
    assert!(held.iter().all(|position| position.y > table::HEIGHT + 0.1));

    run(&mut app, 1.5);
    let draped = positions(&mut app);
    let reach = |position: &Vec3| position.xz().length();
    for position in &draped {
        // What hangs down may swing in.
        let beside = reach(position) > 0.5 * table::RADIUS;
        assert!(beside || position.y > table::HEIGHT, "{position} is under the table top");
    }
    let hanging = draped.iter().filter(|position| position.y < table::HEIGHT - 0.1).count();
    assert!(hanging > 30, "{hanging} of {} hang down", draped.len());
    let highest = draped.iter().map(|position| position.y).fold(0.0, f32::max);
    assert!((0.15..0.25).contains(&(highest - table::HEIGHT)), "the teapot holds it up: {highest}");
    let depth = deepest(app.world_mut());
    assert!(depth < 1e-3, "{depth} m inside a dish");

    let entity = app.world_mut().query_filtered::<Entity, With<ClothMesh>>().single(app.world()).expect("one cloth");
    app.world_mut().trigger(SceneReset);
    app.world_mut().trigger(ClothReset { entity });
    run(&mut app, 0.2);
    let corner = positions(&mut app)[0];
    assert!((corner.y - 1.3).abs() < 1e-4, "{corner}");
}
