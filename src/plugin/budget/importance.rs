//! How much a cloth matters: what the user says, how large it is on the screen, whether it is seen at all.

use bevy::camera::primitives::Aabb;
use bevy::camera::{Camera, Projection};
use bevy::prelude::*;

/// How much this cloth matters beside others, if a [`ClothBudget`](super::ClothBudget) does not suffice for all: a factor, 1
/// where the component is missing. It is multiplied by the size of the cloth on the screen.
#[derive(Component, Clone, Copy, Debug, PartialEq, Deref, DerefMut, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ClothImportance(pub f32);

impl Default for ClothImportance {
    fn default() -> Self {
        Self(1.0)
    }
}

/// A cloth that no camera sees may be seen in a moment, and its shadow now.
const UNSEEN: f64 = 0.1;
/// One that is hidden must be shown first.
const HIDDEN: f64 = 0.01;

/// What is seen of a cloth.
pub(super) struct Seen<'a> {
    pub weight: Option<&'a ClothImportance>,
    pub transform: &'a GlobalTransform,
    pub aabb: Option<&'a Aabb>,
    pub in_view: Option<&'a ViewVisibility>,
    pub inherited: Option<&'a InheritedVisibility>,
}

impl Seen<'_> {
    /// User's weight × size on the screen × visibility; finite, not negative.
    pub fn importance<'a>(
        &self,
        cameras: impl Iterator<Item = (&'a Camera, &'a Projection, &'a GlobalTransform)>,
    ) -> f64 {
        let weight = self.weight.copied().unwrap_or_default().0;
        let visibility = if self.inherited.is_some_and(|inherited| !inherited.get()) {
            HIDDEN
        } else if self.in_view.is_some_and(|view| !view.get()) {
            UNSEEN
        } else {
            1.0
        };
        let active = cameras.filter(|(camera, ..)| camera.is_active);
        let size = active.map(|(_, projection, camera)| self.size(projection, camera)).reduce(f32::max).unwrap_or(1.0);
        let importance = f64::from(weight) * f64::from(size) * visibility;
        if importance.is_finite() { importance.max(0.0) } else { 0.0 }
    }

    /// Height on the screen, as a share of it; 1 at most.
    fn size(&self, projection: &Projection, camera: &GlobalTransform) -> f32 {
        let aabb = self.aabb.copied().unwrap_or_default();
        let centre = self.transform.transform_point(aabb.center.into());
        let radius = self.transform.radius_vec3a(aabb.half_extents);
        let half_height = match projection {
            Projection::Perspective(perspective) => {
                camera.translation().distance(centre).max(radius) * (0.5 * perspective.fov).tan()
            }
            Projection::Orthographic(orthographic) => 0.5 * orthographic.area.height(),
            Projection::Custom(_) => camera.translation().distance(centre).max(radius),
        };
        (radius / half_height.max(f32::MIN_POSITIVE)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn importance(distance: f32, weight: Option<&ClothImportance>, view: Option<&ViewVisibility>) -> f64 {
        let aabb = Aabb { center: Vec3::ZERO.into(), half_extents: Vec3::new(0.5, 0.5, 0.0).into() };
        let transform = GlobalTransform::from_xyz(0.0, 0.0, -distance);
        let (camera, projection) = (Camera::default(), Projection::Perspective(default()));
        let seen = Seen { weight, transform: &transform, aabb: Some(&aabb), in_view: view, inherited: None };
        seen.importance([(&camera, &projection, &GlobalTransform::IDENTITY)].into_iter())
    }

    #[test]
    fn it_falls_with_distance_and_rises_with_weight() {
        let near = importance(2.0, None, None);
        assert!((importance(4.0, None, None) / near - 0.5).abs() < 1e-6);
        assert!((importance(4.0, Some(&ClothImportance(2.0)), None) / near - 1.0).abs() < 1e-6);
        assert!((importance(2.0, None, Some(&ViewVisibility::HIDDEN)) / near - UNSEEN).abs() < 1e-6);
        assert_eq!(importance(0.0, None, None), importance(0.1, None, None), "no more than the whole screen");
        assert_eq!(importance(2.0, Some(&ClothImportance(f32::NAN)), None), 0.0);
    }
}
