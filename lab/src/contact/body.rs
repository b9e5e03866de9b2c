//! A solid on its way.

use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::physics::{Collider, Pose};

use super::solid::Solid;

/// A solid, and where it is at every time.
pub struct Body {
    /// Its shape.
    pub solid: Solid,
    shape: SharedShape,
    friction: f64,
    pose: Box<dyn Fn(f64) -> Pose>,
}

impl Body {
    /// Moves as `pose` says for a time in s.
    pub fn moving(solid: Solid, friction: f64, pose: impl Fn(f64) -> Pose + 'static) -> Self {
        Self { shape: solid.shape(), solid, friction, pose: Box::new(pose) }
    }

    /// Stands still.
    pub fn fixed(solid: Solid, friction: f64, pose: Pose) -> Self {
        Self::moving(solid, friction, move |_| pose)
    }

    /// Where it is at a time in s.
    pub fn pose(&self, time: f64) -> Pose {
        (self.pose)(time)
    }

    /// As the physics takes it, on its way between two times.
    pub fn collider(&self, id: u64, [start, end]: [f64; 2]) -> Collider {
        Collider {
            id,
            shape: self.shape.clone(),
            start: self.pose(start),
            end: self.pose(end),
            friction: self.friction,
        }
    }
}
