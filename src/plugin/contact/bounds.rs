//! Boxes along the axes of the world: what is far from a cloth is told apart by them.

use bevy::math::{DMat3, DVec3};
use parry3d::bounding_volume::Aabb;

use crate::physics::Pose;

/// A box along the axes, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

/// What is larger than this is as good as infinite, m.
const ENDLESS: f32 = 1e15;

impl Bounds {
    /// Around nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
    /// Around everything.
    pub const ALL: Self = Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

    /// Around a shape; `None` if it has no extent or is not finite.
    pub fn of_shape(aabb: &Aabb) -> Option<Self> {
        if aabb.mins.is_nan() || aabb.maxs.is_nan() || aabb.mins.cmpgt(aabb.maxs).any() || aabb.mins == aabb.maxs {
            None
        } else if aabb.mins.min_element() < -ENDLESS || aabb.maxs.max_element() > ENDLESS {
            Some(Self::ALL)
        } else {
            Some(Self { min: aabb.mins.as_dvec3(), max: aabb.maxs.as_dvec3() })
        }
    }

    /// With a point in it.
    pub fn with(self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Around both.
    pub fn and(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Larger on all sides.
    pub fn grown(self, by: f64) -> Self {
        Self { min: self.min - by, max: self.max + by }
    }

    /// Whether they have a point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Around what is in it, at a pose.
    pub fn at(self, pose: &Pose) -> Self {
        if self == Self::ALL {
            return self;
        }
        let turn = DMat3::from_quat(pose.rotation);
        let reach = DMat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
        let centre = pose.place(0.5 * (self.min + self.max));
        let half = reach * (0.5 * (self.max - self.min));
        Self { min: centre - half, max: centre + half }
    }

    /// Around what is in it, on its way from a pose to another.
    pub fn swept(self, start: &Pose, end: &Pose) -> Self {
        if self == Self::ALL || start == end {
            return self.at(end);
        }
        // Turned by an angle, a point leaves the line between start and end by so much of its distance from the origin.
        let angle = start.rotation.angle_between(end.rotation);
        let farthest = self.min.abs().max(self.max.abs()).length();
        self.at(start).and(self.at(end)).grown(farthest * (1.0 - (0.5 * angle).cos()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::DQuat;

    #[test]
    fn the_way_of_a_turning_rod_is_within_its_bounds() {
        let rod = Bounds { min: DVec3::new(-3.0, -0.1, -0.1), max: DVec3::new(1.0, 0.1, 0.1) };
        let start = Pose { translation: DVec3::new(1.0, 2.0, 3.0), rotation: DQuat::from_rotation_z(-0.7) };
        let end = Pose { translation: DVec3::new(1.5, 2.0, 2.0), rotation: DQuat::from_rotation_z(0.7) };
        let swept = rod.swept(&start, &end);
        for share in (0..=20).map(|i| f64::from(i) / 20.0) {
            let between = start.towards(&end, share);
            for corner in [rod.min, rod.max, rod.min.with_x(rod.max.x), rod.max.with_x(rod.min.x)] {
                let point = between.place(corner);
                assert!(swept.overlaps(&Bounds { min: point, max: point }), "{point} at {share}");
            }
        }
    }

    #[test]
    fn everything_stays_everything() {
        let pose = Pose { translation: DVec3::ONE, rotation: DQuat::from_rotation_x(1.0) };
        assert_eq!(Bounds::ALL.swept(&Pose::IDENTITY, &pose), Bounds::ALL);
        assert!(Bounds::ALL.overlaps(&Bounds::EMPTY.with(DVec3::splat(1e9))));
    }
}
