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
        app.add_plugins(CurtainPlugin { fabric: Fabric::wool(), cells_per_pleat: 4 });
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
fn the_curtain_catches_the_ball() {
    let mut app = scene();
    let (hand, _) = ball(&mut app);
    for _ in 0..(60.0 * THROWN_AT) as u32 - 1 {
        step(&mut app).expect("no error");
    }
    assert_eq!(ball(&mut app).0, hand);
    let (mut fastest, mut furthest, mut bulge) = (0.0_f32, 0.0_f32, 0.0_f32);
    for _ in 0..90 {
        step(&mut app).expect("no error");
        let (place, velocity) = ball(&mut app);
        fastest = fastest.max(velocity.length());
        furthest = furthest.min(place.z);
        bulge = positions(&mut app).iter().map(|position| position.z).fold(bulge, f32::min);
        let depth = deepest(app.world_mut());
        assert!(depth < 2e-3, "{depth} m inside the ball at {place}");
    }
    assert!((5.0..9.0).contains(&fastest), "{fastest} m/s");
    assert!(furthest < -RADIUS && bulge < furthest, "the cloth is pushed away: ball {furthest}, cloth {bulge}");
    let (_, velocity) = ball(&mut app);
    assert!(velocity.z > -3.5, "the cloth slows the ball: {velocity}");
}

#[test]
fn a_reset_puts_the_ball_back_into_the_hand() {
    let mut app = scene();
    let (hand, _) = ball(&mut app);
    for _ in 0..80 {
        step(&mut app).expect("no error");
    }
    assert!(ball(&mut app).0.distance(hand) > 1.0, "it was thrown");
    app.world_mut().trigger(SceneReset);
    step(&mut app).expect("no error");
    assert_eq!(ball(&mut app).0, hand);
}
