//! Legend and figures in a corner of the window.

use crate::{controls::LEGEND, summary::fabric_name};
use bevy::{
    diagnostic::{DiagnosticPath, DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
};
use bevy_cloth::prelude::*;

/// Shows the keys, the fabric, and what a frame costs. Needs [`ClothDiagnosticsPlugin`].
pub struct OverlayPlugin;

impl Plugin for OverlayPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(FrameTimeDiagnosticsPlugin::default())
            .add_systems(Startup, spawn)
            .add_systems(Update, (show_figures, hide));
    }
}

#[derive(Component)]
struct Panel;

#[derive(Component)]
struct Figures;

fn spawn(mut commands: Commands) {
    let font = TextFont { font_size: FontSize::Px(15.0), ..default() };
    commands.spawn((
        Panel,
        Node {
            position_type: PositionType::Absolute,
            top: px(12),
            left: px(12),
            padding: UiRect::all(px(12)),
            flex_direction: FlexDirection::Column,
            row_gap: px(12),
            border_radius: BorderRadius::all(px(6)),
            ..default()
        },
        BackgroundColor(Color::srgba(0.05, 0.06, 0.08, 0.72)),
        children![(Figures, Text::default(), font.clone()), (Text::new(LEGEND), font)],
    ));
}

fn show_figures(
    mut text: Single<&mut Text, With<Figures>>,
    diagnostics: Res<DiagnosticsStore>,
    game_time: Res<Time<Virtual>>,
    cloths: Query<(&ClothMaterial, Option<&ClothError>), With<ClothMesh>>,
) {
    let figure = |path: &DiagnosticPath| diagnostics.get(path).and_then(|it| it.smoothed()).unwrap_or(0.0);
    let fabric = cloths.iter().next().map_or("", |(material, _)| fabric_name(material));
    let paused = if game_time.is_paused() { "   (paused)" } else { "" };
    text.0 = format!(
        "{fabric}{paused}\n{:.0} fps   step {:.2} ms   {:.0} iterations   {:.0} vertices",
        figure(&FrameTimeDiagnosticsPlugin::FPS),
        figure(&ClothDiagnosticsPlugin::STEP),
        figure(&ClothDiagnosticsPlugin::ITERATIONS),
        figure(&ClothDiagnosticsPlugin::VERTICES),
    );
    for (_, error) in &cloths {
        if let Some(error) = error {
            text.0 += &format!("\n{error}");
        }
    }
}

fn hide(keys: Res<ButtonInput<KeyCode>>, mut panel: Single<&mut Visibility, With<Panel>>) {
    if keys.just_pressed(KeyCode::KeyH) {
        panel.toggle_visible_hidden();
    }
}
