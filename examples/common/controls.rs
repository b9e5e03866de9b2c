//! Keys of every windowed example: fabric, pause, single step, reset, and what is drawn over the cloth.

use crate::clock::SceneReset;
use bevy::prelude::*;
use bevy_cloth::{physics::Fabric, prelude::*};

/// What the keys do, for the legend.
pub const LEGEND: &str = "\
drag            orbit
right drag      move
wheel           zoom
left, right     fabric
space           pause
.               one step
R               reset
W               wireframe
T               stretch as colour
H               hide this";

/// Handles the keys of [`LEGEND`] except `H`, which belongs to the overlay.
pub struct ControlsPlugin;

impl Plugin for ControlsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            PreUpdate,
            (switch_fabric, pause_and_step, reset, switch_view).after(bevy::input::InputSystems),
        );
    }
}

fn switch_fabric(keys: Res<ButtonInput<KeyCode>>, mut cloths: Query<&mut ClothMaterial, With<ClothMesh>>) {
    let step = match (keys.just_pressed(KeyCode::ArrowRight), keys.just_pressed(KeyCode::ArrowLeft)) {
        (true, false) => 1,
        (false, true) => -1,
        _ => return,
    };
    let presets: Vec<Fabric> = Fabric::presets().map(|(_, fabric)| fabric).collect();
    for mut material in &mut cloths {
        let now = presets.iter().position(|fabric| *fabric == material.0).unwrap_or(0);
        let next = (now as isize + step).rem_euclid(presets.len() as isize);
        material.0 = presets[next as usize];
    }
}

fn pause_and_step(
    keys: Res<ButtonInput<KeyCode>>,
    mut game_time: ResMut<Time<Virtual>>,
    mut fixed_time: ResMut<Time<Fixed>>,
) {
    if keys.just_pressed(KeyCode::Space) {
        if game_time.is_paused() { game_time.unpause() } else { game_time.pause() }
    }
    if keys.just_pressed(KeyCode::Period) {
        game_time.pause();
        // The fixed loop runs as long as there is time left over, paused or not.
        let one_step = fixed_time.timestep();
        fixed_time.accumulate_overstep(one_step);
    }
}

fn reset(keys: Res<ButtonInput<KeyCode>>, cloths: Query<Entity, With<ClothMesh>>, mut commands: Commands) {
    if keys.just_pressed(KeyCode::KeyR) {
        commands.trigger(SceneReset);
        for entity in &cloths {
            commands.trigger(ClothReset { entity });
        }
    }
}

fn switch_view(keys: Res<ButtonInput<KeyCode>>, mut gizmos: ResMut<GizmoConfigStore>) {
    let (_, shown) = gizmos.config_mut::<ClothGizmos>();
    if keys.just_pressed(KeyCode::KeyW) {
        shown.edges = !shown.edges;
        shown.pins = shown.edges;
    }
    if keys.just_pressed(KeyCode::KeyT) {
        shown.stretch = !shown.stretch;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::time::TimeUpdateStrategy;

    #[derive(Resource, Default)]
    struct Steps(u32);

    /// An app in which every update is one fixed step.
    fn app() -> App {
        let mut app = App::new();
        app.add_plugins(MinimalPlugins)
            .insert_resource(TimeUpdateStrategy::FixedTimesteps(1))
            .init_resource::<ButtonInput<KeyCode>>()
            .init_resource::<Steps>()
            .add_systems(PreUpdate, (switch_fabric, pause_and_step))
            .add_systems(FixedUpdate, |mut steps: ResMut<Steps>| steps.0 += 1);
        app.update();
        app.world_mut().resource_mut::<Steps>().0 = 0;
        app
    }

    fn press(app: &mut App, key: KeyCode) {
        app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(key);
        app.update();
        app.world_mut().resource_mut::<ButtonInput<KeyCode>>().reset_all();
    }

    #[test]
    fn space_pauses_and_a_dot_makes_one_step() {
        let mut app = app();
        app.update();
        assert_eq!(app.world().resource::<Steps>().0, 1);
        press(&mut app, KeyCode::Space);
        // The pause takes effect in the next frame.
        let paused_at = app.world().resource::<Steps>().0;
        app.update();
        app.update();
        assert_eq!(app.world().resource::<Steps>().0, paused_at);
        press(&mut app, KeyCode::Period);
        app.update();
        assert_eq!(app.world().resource::<Steps>().0, paused_at + 1);
        press(&mut app, KeyCode::Space);
        app.update();
        assert!(app.world().resource::<Steps>().0 > paused_at + 1);
    }

    #[test]
    fn the_arrows_go_round_the_fabrics() {
        let mut app = app();
        let presets: Vec<Fabric> = Fabric::presets().map(|(_, fabric)| fabric).collect();
        let cloth = app.world_mut().spawn((ClothMesh::default(), ClothMaterial(presets[0]))).id();
        let fabric = |app: &App| app.world().get::<ClothMaterial>(cloth).map(|material| material.0);
        press(&mut app, KeyCode::ArrowLeft);
        assert_eq!(fabric(&app), presets.last().copied());
        press(&mut app, KeyCode::ArrowRight);
        press(&mut app, KeyCode::ArrowRight);
        assert_eq!(fabric(&app), Some(presets[1]));
    }

    #[test]
    fn r_restarts_the_scene_before_its_cloths() {
        #[derive(Resource, Default)]
        struct Order(Vec<&'static str>);

        let mut app = app();
        app.init_resource::<Order>()
            .add_systems(PreUpdate, reset)
            .add_observer(|_: On<SceneReset>, mut order: ResMut<Order>| order.0.push("scene"))
            .add_observer(|_: On<ClothReset>, mut order: ResMut<Order>| order.0.push("cloth"));
        app.world_mut().spawn(ClothMesh::default());
        press(&mut app, KeyCode::KeyR);
        assert_eq!(app.world().resource::<Order>().0, ["scene", "cloth"]);
    }
}
