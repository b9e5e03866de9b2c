//! The time of a scene, which begins again when the scene is reset.

use crate::scene::SceneState;
use bevy::prelude::*;

/// Seconds of game time at the end of this step, since the scene was complete or last reset. Moves on in
/// `FixedPreUpdate`: bodies that move with it in `FixedUpdate`, before cloth is collected, lead the cloth by nothing.
#[derive(Resource, Debug, Default, Clone, Copy, PartialEq)]
pub struct SceneClock(pub f32);

/// The scene begins again. The clock is at zero; what moves goes back to where it started, at once: the cloths are put
/// back next, to where their entities are.
#[derive(Event, Debug, Clone, Copy)]
pub struct SceneReset;

/// Keeps [`SceneClock`].
pub fn plugin(app: &mut App) {
    app.init_resource::<SceneClock>().add_systems(FixedPreUpdate, advance).add_observer(restart);
}

fn advance(state: Res<SceneState>, time: Res<Time>, mut clock: ResMut<SceneClock>) {
    if *state == SceneState::Ready {
        clock.0 += time.delta_secs();
    }
}

fn restart(_: On<SceneReset>, mut clock: ResMut<SceneClock>) {
    clock.0 = 0.0;
}
