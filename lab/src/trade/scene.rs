//! What is simulated.

use bevy::math::{DQuat, DVec3};
use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::physics::{BendingModel, Cloth, Collider, Fabric, Pose, RestShape, SolverSettings};
use clap::ValueEnum;
use serde::Serialize;

use super::method::Method;
use crate::scenes::{Meshing, Sheet, fabric};

/// A cloth of 1 m × 1 m, 0.15 kg/m² and 1000 N/m, under standard gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scene {
    /// Held by two corners, it swings down from flat and horizontal.
    Sheet,
    /// Held by one edge, which is moved to and fro, it falls from flat and horizontal and is whirled about.
    Flag,
    /// From flat and horizontal it falls on a ball and drapes it. Not for the baseline, which has no contact.
    Ball,
}

/// Of the ball, m, and how far below the middle of the sheet it is at first, m.
const RADIUS: f32 = 0.3;
const GAP: f64 = 0.01;
/// Of ball and cloth together.
const FRICTION: f64 = 0.5;

/// How far the edge of the flag goes, m, how far it turns about the vertical, rad, and how often a second.
const SHAKE: f64 = 0.2;
const TURN: f64 = 0.3;
const SHAKES_PER_SECOND: f64 = 2.0;

/// Air that brings the cloth to rest soon, 1/s: near the critical damping of its slowest swing.
const THICK_AIR: f32 = 8.0;

impl Scene {
    /// In words.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Sheet => "Sheet hung by two corners",
            Self::Flag => "Flag on a shaken pole",
            Self::Ball => "Sheet dropped on a ball",
        }
    }

    /// Of the file names.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sheet => "sheet",
            Self::Flag => "flag",
            Self::Ball => "ball",
        }
    }

    /// What the cloth touches.
    fn collider(self) -> Option<Collider> {
        let centre = DVec3::new(0.5, -GAP - f64::from(RADIUS), 0.5);
        let ball = || Collider::fixed(0, SharedShape::ball(RADIUS), Pose::at(centre), FRICTION);
        (self == Self::Ball).then(ball)
    }

    /// Whether a method can simulate it.
    pub fn is_for(self, method: &Method) -> bool {
        self != Self::Ball || !method.family.is_baseline()
    }

    /// Where the vertex held at `rest` is after so many seconds, m.
    fn target(self, rest: DVec3, time: f64) -> DVec3 {
        match self {
            Self::Sheet | Self::Ball => rest,
            Self::Flag => {
                // From rest, away from the cloth first.
                let phase = core::f64::consts::TAU * SHAKES_PER_SECOND * time;
                let there = 0.5 * (1.0 - phase.cos());
                let middle = DVec3::new(0.5, 0.0, 0.0);
                middle + DQuat::from_rotation_y(TURN * there) * (rest - middle) - SHAKE * there * DVec3::Z
            }
        }
    }
}

/// A scene with its cloth.
pub struct Stage {
    /// What is simulated.
    pub scene: Scene,
    /// Vertices along a side.
    pub side: u32,
    /// The cloth.
    pub shape: RestShape,
    /// The vertices that are held.
    pub held: Vec<u32>,
}

impl Stage {
    /// A scene in this size.
    pub fn new(scene: Scene, side: u32) -> Self {
        let sheet = Sheet::new(side, Meshing::Grid);
        let shape = sheet.shape(BendingModel::Hinge);
        let held = match scene {
            Scene::Sheet => sheet.corners.iter().filter_map(|&v| shape.simulated[v as usize]).collect(),
            Scene::Ball => Vec::new(),
            Scene::Flag => (0..shape.vertex_count() as u32).filter(|&v| shape.positions[v as usize].z == 0.0).collect(),
        };
        Self { scene, side, shape, held }
    }

    /// What it is called in tables.
    pub fn name(&self) -> String {
        format!("{} {}²", self.scene.name(), self.side)
    }

    /// The fabric in motion.
    pub fn fabric() -> Fabric {
        fabric()
    }

    /// The same in thick air, in which it comes to rest.
    pub fn settling_fabric() -> Fabric {
        Fabric { air_drag: THICK_AIR, ..fabric() }
    }

    /// The cloth, flat and horizontal, at rest, as the implicit solver has it.
    pub fn cloth(&self, fabric: Fabric, settings: SolverSettings) -> Cloth {
        let mut cloth = Cloth::new(self.shape.clone(), fabric, settings).expect("the fabric is valid");
        for &vertex in &self.held {
            cloth.pin(vertex, self.shape.positions[vertex as usize]);
        }
        cloth.set_colliders(self.scene.collider()).expect("colliders");
        cloth
    }

    /// Where the held vertices are after so many seconds, m.
    pub fn targets(&self, time: f64) -> impl Iterator<Item = (u32, DVec3)> {
        self.held.iter().map(move |&v| (v, self.scene.target(self.shape.positions[v as usize], time)))
    }

    /// What the motion depends on, in words.
    pub fn key(&self) -> String {
        let Self { scene, side, .. } = self;
        match scene {
            Scene::Sheet | Scene::Flag => format!("{scene:?} {side} shake {SHAKE} {TURN} {SHAKES_PER_SECOND}"),
            Scene::Ball => format!("{scene:?} {side} {RADIUS} {GAP} {FRICTION}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::method::Family;
    use super::*;

    #[test]
    fn the_ball_is_near_the_cloth_and_not_for_the_baseline() {
        let mut cloth = Stage::new(Scene::Ball, 9).cloth(Stage::fabric(), SolverSettings::default());
        assert_eq!(cloth.pinned().count(), 0);
        for _ in 0..6 {
            cloth.step(crate::scenes::DT);
        }
        assert!(cloth.contacts().count() > 0);
        let methods = [Family::Level, Family::Xpbd].map(|family| family.methods().swap_remove(0));
        assert_eq!(methods.each_ref().map(|method| Scene::Ball.is_for(method)), [true, false]);
        assert!(methods.iter().all(|method| Scene::Flag.is_for(method)));
    }

    #[test]
    fn corners_or_an_edge_are_held_and_the_edge_is_moved_as_it_is() {
        assert_eq!(Stage::new(Scene::Sheet, 5).held.len(), 2);
        let flag = Stage::new(Scene::Flag, 5);
        assert_eq!(flag.held.len(), 5);
        for time in [0.0, 0.1, 0.25, 0.4] {
            let targets: Vec<_> = flag.targets(time).map(|(_, x)| x).collect();
            assert!((targets[0].distance(targets[4]) - 1.0).abs() < 1e-12);
            let back = targets[2].z;
            assert!((back + SHAKE * 0.5 * (1.0 - (4.0 * core::f64::consts::PI * time).cos())).abs() < 1e-12, "{back}");
        }
    }
}
