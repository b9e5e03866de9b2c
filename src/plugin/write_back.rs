//! Showing the cloth: from world positions to the vertices of its mesh.

use bevy::camera::primitives::Aabb;
use bevy::math::{DAffine3, DVec3};
use bevy::platform::time::Instant;
use bevy::prelude::*;

use super::budget::Keeper;
use super::components::ClothDisabled;
use super::mesh_io;
use super::state::{ClothState, ShownFrom, usable};

/// Whether [`write_back`] interpolates between steps.
#[derive(Resource)]
pub(super) struct Interpolate(pub bool);

/// See [`ClothSystems::WriteBack`](super::ClothSystems::WriteBack).
pub(super) fn write_back(
    interpolate: Res<Interpolate>,
    mut keeper: ResMut<Keeper>,
    fixed: Res<Time<Fixed>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut cloths: Query<(&mut ClothState, &GlobalTransform, Option<&mut Aabb>, Has<ClothDisabled>)>,
) {
    let start = Instant::now();
    let fraction = if interpolate.0 { fixed.overstep_fraction().clamp(0.0, 1.0) } else { 1.0 };
    for (mut state, transform, aabb, disabled) in &mut cloths {
        let Some(from) = state.to_show(transform, fraction, disabled) else { continue };
        let Some(mut mesh) = meshes.get_mut(&state.binding.own) else { continue };
        let tangents = state.show(from);
        let shown = &state.shown;
        let positions: Vec<[f32; 3]> = shown.positions.iter().map(|p| p.to_array()).collect();
        mesh_io::write(&mut mesh, &positions, &shown.normals, &tangents);
        if let (Some(mut aabb), Some(bounds)) = (aabb, Aabb::enclosing(&shown.positions)) {
            *aabb = bounds;
        }
    }
    keeper.spent.write_back += start.elapsed();
}

impl ClothState {
    /// What the mesh should show; `None` if it does already, or nothing can be shown.
    fn to_show(&self, transform: &GlobalTransform, fraction: f32, disabled: bool) -> Option<ShownFrom> {
        // A cloth that is not stepped moves rigidly with its entity; what it shows changes only if it is placed anew.
        let still = disabled || self.suspended;
        if still && self.shown.from.as_ref().is_some_and(|from| from.revision == self.revision) {
            return None;
        }
        let alpha = if self.stepped { self.pace.shown(fraction) } else { 1.0 };
        let (alpha, frame) = if self.is_anchored() || still {
            // In the frame of its entity, so that held vertices keep their place to the last bit, however fast it moves.
            interpolated_frame(self.previous_anchor, self.anchor, alpha)
        } else {
            (alpha, usable(transform).ok()?.inverse())
        };
        let from = ShownFrom { revision: self.revision, alpha, frame };
        (self.shown.from.as_ref() != Some(&from)).then_some(from)
    }

    /// Computes what is shown, and returns the tangents.
    fn show(&mut self, from: ShownFrom) -> Vec<[f32; 4]> {
        let Self { cloth, binding, shown, previous_positions, .. } = self;
        let alpha = f64::from(from.alpha);
        let (previous, current) = (&previous_positions[..], cloth.positions());
        // Vertices without triangle are not simulated: they keep their place in the mesh.
        for (place, simulated) in shown.positions.iter_mut().zip(&cloth.shape().simulated) {
            if let Some(simulated) = simulated {
                let [before, now] = [previous, current].map(|p: &[DVec3]| p[*simulated as usize]);
                *place = from.frame.transform_point3(before.lerp(now, alpha)).as_vec3();
            }
        }
        shown.normals = binding.shading.normals(&binding.mesh.triangles, &shown.positions);
        shown.from = Some(from);
        binding.shading.tangents(&binding.mesh.triangles, &shown.positions, &shown.normals)
    }
}

/// World to mesh between two transforms. The matrices are interpolated as the positions are, entry by entry; where that has
/// no inverse (half a turn in one step), the later transform and positions are shown.
fn interpolated_frame(before: DAffine3, now: DAffine3, alpha: f32) -> (f32, DAffine3) {
    let t = f64::from(alpha);
    let mixed = DAffine3 {
        matrix3: before.matrix3 * (1.0 - t) + now.matrix3 * t,
        translation: before.translation.lerp(now.translation, t),
    };
    // Relative to the later one, so that mirrored transforms are no exception.
    if mixed.matrix3.determinant() / now.matrix3.determinant() > 1e-3 {
        (alpha, mixed.inverse())
    } else {
        (1.0, now.inverse())
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::DQuat;

    use super::*;

    #[test]
    fn held_points_keep_their_place_between_two_transforms() {
        let before =
            DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), DQuat::from_rotation_x(0.3), DVec3::X);
        let turn = DQuat::from_rotation_z(2.0);
        let now = DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), turn, DVec3::new(5.0, 1.0, 0.0));
        let local = DVec3::new(0.3, 0.4, 0.5);
        let (alpha, frame) = interpolated_frame(before, now, 0.25);
        let world = before.transform_point3(local).lerp(now.transform_point3(local), 0.25);
        assert_eq!(alpha, 0.25);
        assert!(frame.transform_point3(world).abs_diff_eq(local, 1e-12));
    }

    #[test]
    fn mirrored_transforms_are_interpolated_too() {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let now = DAffine3::from_translation(DVec3::X) * mirror;
        let (alpha, frame) = interpolated_frame(mirror, now, 0.5);
        assert_eq!(alpha, 0.5);
        assert!(frame.transform_point3(DVec3::new(0.5, 0.0, 0.0)).length() < 1e-12);
    }

    #[test]
    fn half_a_turn_shows_the_later_transform() {
        let now = DAffine3::from_rotation_y(core::f64::consts::PI);
        let (alpha, frame) = interpolated_frame(DAffine3::IDENTITY, now, 0.5);
        assert_eq!(alpha, 1.0);
        assert!((frame * now).abs_diff_eq(DAffine3::IDENTITY, 1e-12));
    }
}
