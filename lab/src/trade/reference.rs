//! The converged motion of a scene, and where its cloth comes to rest.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, Precision, SolverKind, SolverSettings};

use super::body::{Body, Figures, Ruler, advance};
use super::cache::Cache;
use super::errors::Trace;
use super::scene::Stage;
use crate::scenes::DT;

/// To be raised whenever the same key comes to mean another motion: when an energy, the mesh of a scene or its motion changes.
const VERSION: u32 = 1;

/// Frames that errors are measured over: half a second.
pub const FRAMES: u32 = 30;

/// Substeps of a converged frame: steps of 1/1920 s.
const SUBSTEPS: u32 = 32;

/// Accelerations that converged steps and the rest are solved to, m/s².
const TOLERANCE: f32 = 1e-4;

/// The cloth rests when its vertices are slower than this, root mean square, m/s.
const REST_SPEED: f64 = 1e-5;

/// Or after so many frames: half a minute.
const MOST_SETTLING_FRAMES: u32 = 1800;

/// Converged answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The motion.
    pub motion: Trace,
    /// Positions at rest, with the held vertices where they are at first, m.
    pub settled: Vec<DVec3>,
}

impl Reference {
    /// From the cache or, if it is not there, computed and kept there.
    ///
    /// # Errors
    /// If the cache cannot be written.
    pub fn new(stage: &Stage, cache: &Cache) -> Result<Self, String> {
        let (motion, rest) = (key("motion", stage, &Stage::fabric()), key("rest", stage, &Stage::settling_fabric()));
        let get = |key: &str, compute: &dyn Fn(&Stage) -> Vec<f64>| match cache.load(key) {
            Some(numbers) => Ok(numbers),
            None => {
                let numbers = compute(stage);
                cache.store(key, &numbers).map(|()| numbers)
            }
        };
        let (motion, rest) = (get(&motion, &moved)?, get(&rest, &settled)?);
        let length = 2 + 3 * stage.shape.vertex_count();
        let frames = motion.chunks_exact(length);
        Ok(Self {
            motion: Trace {
                figures: frames.clone().map(|frame| Figures { stretch: frame[0], energy: frame[1] }).collect(),
                frames: frames.map(|frame| points(&frame[2..])).collect(),
            },
            settled: points(&rest),
        })
    }
}

/// All that numbers of this kind depend on.
fn key(kind: &str, stage: &Stage, fabric: &Fabric) -> String {
    format!("{kind} v{VERSION}: {} {fabric:?} {FRAMES} frames of {DT} {:?} {REST_SPEED}", stage.key(), converged())
}

/// The settings of converged steps.
fn converged() -> SolverSettings {
    SolverSettings {
        kind: SolverKind::conjugate_gradient(TOLERANCE),
        precision: Precision::Double,
        substeps: SUBSTEPS,
        ..Default::default()
    }
}

/// Stretch, energy and positions of each frame.
fn moved(stage: &Stage) -> Vec<f64> {
    let mut cloth = stage.cloth(Stage::fabric(), converged());
    let mut ruler = Ruler::new(stage);
    let mut motion = Trace::default();
    for frame in 0..FRAMES {
        advance(&mut cloth, stage, frame);
        motion.push(&cloth, &mut ruler);
    }
    let frames = motion.frames.iter().zip(&motion.figures);
    let numbers = |(positions, figures): (&Vec<DVec3>, &Figures)| {
        let mut numbers = vec![figures.stretch, figures.energy];
        numbers.extend(positions.iter().flat_map(|x| x.to_array()));
        numbers
    };
    frames.flat_map(numbers).collect()
}

/// Positions at rest. The forces at rest depend on no step, so long ones will do.
fn settled(stage: &Stage) -> Vec<f64> {
    let settings = SolverSettings { substeps: 1, ..converged() };
    let mut cloth = stage.cloth(Stage::settling_fabric(), settings);
    for frame in 0..MOST_SETTLING_FRAMES {
        cloth.frame();
        // Not at the turning point of a swing.
        if frame % 60 == 59 && speed(&cloth) < REST_SPEED {
            break;
        }
    }
    cloth.positions().iter().flat_map(|x| x.to_array()).collect()
}

/// Root mean square speed, m/s.
fn speed(cloth: &Cloth) -> f64 {
    let squares = cloth.velocities().iter().map(|v| v.length_squared()).sum::<f64>();
    (squares / cloth.velocities().len() as f64).sqrt()
}

fn points(numbers: &[f64]) -> Vec<DVec3> {
    numbers.as_chunks::<3>().0.iter().map(|&x| x.into()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trade::scene::Scene;

    #[test]
    fn a_reference_is_computed_once_and_is_converged() {
        let folder = std::env::temp_dir().join(format!("lab-reference-{}", std::process::id()));
        let cache = Cache::new(&folder).unwrap();
        let stage = Stage::new(Scene::Sheet, 8);
        let computed = Reference::new(&stage, &cache).unwrap();
        assert_eq!((computed.motion.frames.len(), computed.settled.len()), (FRAMES as usize, 64));
        assert_eq!(Reference::new(&stage, &cache).unwrap(), computed);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
        std::fs::remove_dir_all(folder).unwrap();

        // Half as many steps again, of second order, are not far off.
        let mut cloth = stage.cloth(Stage::fabric(), SolverSettings { substeps: 48, ..converged() });
        let (mut motion, mut ruler) = (Trace::default(), Ruler::new(&stage));
        for frame in 0..FRAMES {
            advance(&mut cloth, &stage, frame);
            motion.push(&cloth, &mut ruler);
        }
        let distance = motion.errors(&computed.motion, &ruler).motion_m;
        assert!(distance > 0.0 && distance < 2e-4, "{distance}");
    }
}
