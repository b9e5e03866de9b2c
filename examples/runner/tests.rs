use crate::{
    gait::Joint,
    run::{Runner, SPEED},
    scene::RunnerPlugin,
};
use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, prelude::*};
use example_common::off_screen::{start, step};

#[test]
fn the_cape_goes_along_with_a_figure_that_is_moved_in_update_and_animated() {
    let mut app = start(None, |app| {
        app.add_plugins(RunnerPlugin { fabric: Fabric::wool(), columns: 12 });
    })
    .expect("a scene");
    let mut bends = Vec::new();
    // Through the first turn about.
    for tick in 1..=240 {
        step(&mut app).expect("no error");
        let world = app.world_mut();
        let runner = world.query_filtered::<&Transform, With<Runner>>().single(world).expect("one runner").translation;
        let state = world.query::<&ClothState>().single(world).expect("one cape");
        let positions = state.cloth().positions();
        let middle = positions.iter().sum::<bevy::math::DVec3>() / positions.len() as f64;
        // Its middle, half a meter below the collar, streams behind; what is simulated is up to a frame behind what is drawn.
        let behind = runner.xz().distance(middle.as_vec3().xz());
        assert!(behind < 0.9, "the cape is lost in tick {tick}: {behind} m behind");
        let fastest = state.cloth().velocities().iter().map(|v| v.length()).fold(0.0, f64::max);
        assert!(fastest < f64::from(SPEED) + 8.0, "{fastest} m/s in tick {tick}");
        let joint = world.query_filtered::<&Transform, With<Joint>>().iter(world).next().expect("a joint").rotation;
        bends.push(joint);
    }
    assert!(bends.iter().any(|bend| bend.angle_between(bends[0]) > 0.3), "the limbs are animated");
}
