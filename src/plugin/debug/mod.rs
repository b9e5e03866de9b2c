//! Seeing what the physics sees.

mod contact;
mod outline;

use bevy::color::palettes::css;
use bevy::gizmos::AppGizmoBuilder;
use bevy::gizmos::config::GizmoConfigGroup;
use bevy::gizmos::gizmos::Gizmos;
use bevy::prelude::*;

use super::ClothSystems;
use super::state::ClothState;

/// Draws cloths with gizmos, as [`ClothGizmos`] says. Needs Bevy's `GizmoPlugin`.
#[derive(Default)]
pub struct ClothDebugPlugin;

/// What [`ClothDebugPlugin`] draws: change it through `GizmoConfigStore`.
#[derive(Clone, Copy, Debug, PartialEq, Reflect, GizmoConfigGroup)]
#[reflect(Default, Clone, PartialEq)]
pub struct ClothGizmos {
    /// The edges of the simulated mesh.
    pub edges: bool,
    /// Held vertices.
    pub pins: bool,
    /// Normals, as shown.
    pub normals: bool,
    /// Colours the edges by their elongation: blue is compressed, white at rest, red stretched.
    pub stretch: bool,
    /// Relative elongation at which the colour is full.
    pub full_stretch: f32,
    /// Outlines of colliders.
    pub colliders: bool,
    /// Where cloth touches: a cross at each point, its normal, and an arrow of the force on the cloth.
    pub contacts: bool,
    /// Length of the arrow of a force of 1 N, m.
    pub newton: f32,
}

impl Default for ClothGizmos {
    fn default() -> Self {
        Self {
            edges: true,
            pins: true,
            normals: false,
            stretch: true,
            full_stretch: 0.05,
            colliders: true,
            contacts: false,
            newton: 5.0,
        }
    }
}

impl Plugin for ClothDebugPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<ClothGizmos>().init_gizmo_group::<ClothGizmos>().add_systems(
            PostUpdate,
            (draw, contact::draw_colliders, contact::draw_contacts).chain().after(ClothSystems::WriteBack),
        );
    }
}

/// Lengths of normals and of the crosses at pins, m.
const MARK: f32 = 0.03;

fn draw(mut gizmos: Gizmos<ClothGizmos>, cloths: Query<(&ClothState, &GlobalTransform)>) {
    let config = gizmos.config_ext;
    if !gizmos.config.enabled {
        return;
    }
    for (state, transform) in &cloths {
        let (cloth, binding, shown) = (&state.cloth, &state.binding, &state.shown);
        let place = |simulated: u32| {
            let vertex = binding.representatives[simulated as usize] as usize;
            transform.transform_point(shown.positions[vertex])
        };
        if config.edges || config.stretch {
            for &[a, b] in &cloth.shape().edges {
                let color = if config.stretch { stretch_color(state, [a, b], config.full_stretch) } else { css::WHITE };
                gizmos.line(place(a), place(b), color);
            }
        }
        if config.pins {
            for (vertex, _) in cloth.pinned() {
                gizmos.cross(Isometry3d::from_translation(place(vertex)), MARK, css::YELLOW);
            }
        }
        if config.normals {
            let to_world = transform.affine().matrix3.inverse().transpose();
            for (&position, &normal) in shown.positions.iter().zip(&shown.normals) {
                let start = transform.transform_point(position);
                let normal = Vec3::from(to_world * Vec3A::from(Vec3::from(normal))).normalize_or_zero();
                gizmos.line(start, start + normal * MARK, css::DEEP_SKY_BLUE);
            }
        }
    }
}

fn stretch_color(state: &ClothState, edge: [u32; 2], full: f32) -> Srgba {
    let length = |positions: &[bevy::math::DVec3]| positions[edge[0] as usize].distance(positions[edge[1] as usize]);
    let elongation = length(state.cloth.positions()) / length(&state.cloth.shape().positions) - 1.0;
    let strength = (elongation as f32 / full).clamp(-1.0, 1.0);
    css::WHITE.mix(if strength > 0.0 { &css::RED } else { &css::BLUE }, strength.abs())
}
