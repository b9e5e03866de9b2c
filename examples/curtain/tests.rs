use crate::{
    ball::{Ball, RADIUS, THROWN_AT},
    scene::CurtainPlugin,
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
        app.add_plugins(CurtainPlugin { fabric: Fabric::cotton(), cells_per_pleat: 4 });
    })
    .expect("a scene")
}

/// Place and velocity.
fn ball(app: &mut App) -> (Vec3, Vec3) {
    let mut balls = app.world_mut().query::<(&Transform, &Ball)>();
    let (transform, ball) = balls.single(app.world()).expect("one ball");
    (transform.translation, ball.velocity)
}

fn positions(app: &mut App) -> Vec<Vec3> {
    let mut cloths = app.world_mut().query::<&ClothState>();
    let state = cloths.single(app.world()).expect("one cloth");
    state.cloth().positions().iter().map(|position| position.as_vec3()).collect()
}

#[test]
fn the_curtain_catches_the_ball_and_a_reset_puts_it_back() {
    let mut app = scene();
    let (hand, _) = ball(&mut app);
    for _ in 0..(60.0 * THROWN_AT) as u32 - 1 {
        step(&mut app).expect("no error");
    }
    assert_eq!(ball(&mut app).0, hand);
    let (mut fastest, mut caught) = (0.0_f32, 0);
    for _ in 0..60 {
        step(&mut app).expect("no error");
        let (place, velocity) = ball(&mut app);
        fastest = fastest.max(velocity.length());
        let depth = deepest(app.world_mut());
        assert!(depth < 2e-3, "{depth} m inside the ball at {place}");
        if !(-0.7..-0.1).contains(&place.z) {
            continue;
        }
        caught += 1;
        let cloth = positions(&mut app);
        // What it has passed may hang behind it.
        let ahead = |position: &&Vec3| position.xy().distance(place.xy()) < 0.5 * RADIUS && position.z < place.z;
        assert!(cloth.iter().any(|position| ahead(&position)), "the ball at {place} came through");
    }
    assert!((5.0..9.0).contains(&fastest), "{fastest} m/s");
    assert!(caught > 4, "the ball is in the cloth for {caught} ticks");
    let (place, velocity) = ball(&mut app);
    assert!(velocity.z > -4.5, "the cloth slows the ball: {velocity}");
    assert!(place.distance(hand) > 1.0, "{place} is far from the hand");
    app.world_mut().trigger(SceneReset);
    step(&mut app).expect("no error");
    assert_eq!(ball(&mut app).0, hand);
}
