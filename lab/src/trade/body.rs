//! A cloth that any method moves.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, Precision, SolverSettings};

use super::method::Kind;
use super::scene::Stage;
use super::spaced::Spaced;
use super::xpbd::Xpbd;
use crate::scenes::DT;

/// A cloth, stepped by frames of 1/60 s.
pub trait Body {
    /// Holds a vertex: it goes to `target` (m) in a straight line by the end of the next frame.
    fn hold(&mut self, vertex: u32, target: DVec3);
    /// So many frames further held vertices are to be at the end of the next step, if there is one in the next frame.
    fn frames_ahead(&self) -> Option<u32> {
        Some(1)
    }
    /// Advances by a frame.
    fn frame(&mut self);
    /// Puts it elsewhere, at rest.
    fn place(&mut self, positions: &[DVec3]);
    /// m.
    fn positions(&self) -> &[DVec3];
    /// m/s.
    fn velocities(&self) -> &[DVec3];
}

impl Body for Cloth {
    fn hold(&mut self, vertex: u32, target: DVec3) {
        self.pin(vertex, target);
    }

    fn frame(&mut self) {
        self.step(DT);
    }

    fn place(&mut self, positions: &[DVec3]) {
        self.set_state(positions, &vec![DVec3::ZERO; positions.len()]);
    }

    fn positions(&self) -> &[DVec3] {
        self.positions()
    }

    fn velocities(&self) -> &[DVec3] {
        self.velocities()
    }
}

impl Body for Xpbd<f32> {
    fn hold(&mut self, vertex: u32, target: DVec3) {
        Xpbd::hold(self, vertex, target);
    }

    fn frame(&mut self) {
        self.step();
    }

    fn place(&mut self, positions: &[DVec3]) {
        self.set_state(positions, &vec![DVec3::ZERO; positions.len()]);
    }

    fn positions(&self) -> &[DVec3] {
        self.positions()
    }

    fn velocities(&self) -> &[DVec3] {
        self.velocities()
    }
}

/// The cloth of a stage, moved by this method.
pub fn body(stage: &Stage, fabric: Fabric, kind: Kind) -> Box<dyn Body> {
    match kind {
        Kind::Implicit(settings) => Box::new(stage.cloth(fabric, settings)),
        Kind::Spaced(settings, interval) => Box::new(Spaced::new(stage.cloth(fabric, settings), interval)),
        Kind::Xpbd(settings) => Box::new(Xpbd::<f32>::new(&stage.shape, &fabric, &stage.held, DT, settings)),
    }
}

/// Moves the held vertices to where they are at the end of a frame (counted from 0), and advances.
pub fn advance(body: &mut dyn Body, stage: &Stage, frame: u32) {
    if let Some(ahead) = body.frames_ahead() {
        for (vertex, target) in stage.targets(f64::from(frame + ahead) * DT) {
            body.hold(vertex, target);
        }
    }
    body.frame();
}

/// What a cloth is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Root mean square elongation.
    pub stretch: f64,
    /// Total energy, J.
    pub energy: f64,
}

/// Measures any cloth of a stage, in f64.
pub struct Ruler(Cloth);

impl Ruler {
    /// For cloths of this stage.
    pub fn new(stage: &Stage) -> Self {
        let settings = SolverSettings { precision: Precision::Double, ..Default::default() };
        Self(stage.cloth(Stage::fabric(), settings))
    }

    /// Measures.
    pub fn measure(&mut self, body: &dyn Body) -> Figures {
        self.0.set_state(body.positions(), body.velocities());
        Figures { stretch: self.0.stretch().rms, energy: self.0.energy().total() }
    }

    /// Weight times the side of the sheet, J: what energies are compared with.
    pub fn scale(&self) -> f64 {
        self.0.masses().iter().sum::<f64>() * self.0.gravity().length()
    }
}
