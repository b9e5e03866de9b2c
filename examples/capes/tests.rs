use crate::{BODIES, figure::Figure, gait::SPEED, scene::CapesPlugin};
use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, prelude::*};
use example_common::{
    clock::SceneReset,
    off_screen::{start, step},
    penetration::deepest,
};

fn scene() -> App {
    start(None, |app| {
        app.add_plugins(CapesPlugin { fabric: Fabric::wool(), bodies: BODIES, columns: 12 });
    })
    .expect("a scene")
}

fn places(app: &mut App) -> Vec<Vec3> {
    let mut figures = app.world_mut().query_filtered::<&Transform, With<Figure>>();
    figures.iter(app.world()).map(|transform| transform.translation).collect()
}

#[test]
fn the_capes_follow_the_figures_stay_outside_of_them_and_are_reset_with_them() {
    let mut app = scene();
    assert_eq!(deepest(app.world_mut()), 0.0, "the capes are cut to fit");
    let beginning = places(&mut app);
    let mut before = beginning.clone();
    for tick in 1..=120 {
        step(&mut app).expect("no error");
        let now = places(&mut app);
        let speed = 60.0 * now[0].distance(before[0]);
        assert!(speed < 1.2 * SPEED && (tick < 70 || speed > 0.9 * SPEED), "{speed} m/s in tick {tick}");
        before = now;
        let depth = deepest(app.world_mut());
        assert!(depth < 3e-3, "{depth} m inside a body in tick {tick}");
    }
    let figures = before;
    let mut capes = app.world_mut().query::<&ClothState>();
    for state in capes.iter(app.world()) {
        let positions = state.cloth().positions();
        let middle = positions.iter().sum::<bevy::math::DVec3>() / positions.len() as f64;
        let away = figures.iter().map(|figure| figure.xz().distance(middle.as_vec3().xz())).fold(f32::MAX, f32::min);
        assert!(away < 0.5, "a cape is {away} m from the nearest figure");
    }

    assert!(places(&mut app)[0].distance(beginning[0]) > 0.5);
    app.world_mut().trigger(SceneReset);
    let capes: Vec<Entity> = {
        let mut capes = app.world_mut().query_filtered::<Entity, With<ClothMesh>>();
        capes.iter(app.world()).collect()
    };
    for entity in capes {
        app.world_mut().trigger(ClothReset { entity });
    }
    for _ in 0..3 {
        step(&mut app).expect("no error");
        let mut capes = app.world_mut().query::<&ClothState>();
        let fastest = |state: &ClothState| state.cloth().velocities().iter().map(|v| v.length()).fold(0.0, f64::max);
        let fastest = capes.iter(app.world()).map(fastest).fold(0.0, f64::max);
        assert!(fastest < 2.0, "nothing was torn along: {fastest} m/s");
    }
    assert!(places(&mut app)[0].distance(beginning[0]) < 0.1);
}
