//! How a scene tells the harness that it is complete, or why it never will be.

use crate::clock;
use bevy::prelude::*;
use bevy_cloth::prelude::*;

/// Whether the scene can be simulated. The scene's own code may set `Failed`; the rest happens by itself.
#[derive(Resource, Debug, Default, Clone, PartialEq, Eq)]
pub enum SceneState {
    /// Assets are loading or cloths are being built.
    #[default]
    Loading,
    /// Every cloth is built.
    Ready,
    /// Nothing can be shown, for this reason.
    Failed(String),
}

/// The camera that looks at the scene, spawned by the scene at `Startup`.
#[derive(Resource, Clone, Copy)]
pub struct SceneCamera(pub Entity);

/// Watches the cloths and keeps [`SceneState`] and [`SceneClock`](clock::SceneClock).
pub struct ScenePlugin;

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<SceneState>().add_plugins(clock::plugin).add_systems(Last, watch);
    }
}

fn watch(
    mut state: ResMut<SceneState>,
    built: Query<(), (With<ClothMesh>, With<ClothState>)>,
    waiting: Query<(), (With<ClothMesh>, Without<ClothState>)>,
    errors: Query<(NameOrEntity, &ClothError)>,
) {
    if *state != SceneState::Loading {
        return;
    }
    if let Some((cloth, error)) = errors.iter().next() {
        *state = SceneState::Failed(format!("{cloth}: {error}"));
    } else if waiting.is_empty() && !built.is_empty() {
        *state = SceneState::Ready;
    }
}

/// What is wrong with a cloth right now, if anything.
pub fn cloth_error(world: &mut World) -> Option<String> {
    let mut errors = world.query::<(NameOrEntity, &ClothError)>();
    errors.iter(world).next().map(|(cloth, error)| format!("{cloth}: {error}"))
}
