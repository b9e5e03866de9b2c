//! All that the next step depends on, as a value.

use bevy::math::DVec3;
use thiserror::Error;

use super::shared::Shared;
use super::{Cloth, Precision, SolverSettings};
use crate::physics::assembly::Ordering;
use crate::physics::contact::{ContactSettings, Memory};
use crate::physics::material::Fabric;
use crate::physics::math::Scalar;
use crate::physics::mesh::RestShape;
use crate::physics::step::Impact;

/// Raised when what a snapshot holds, or the order that it holds it in, changes.
const VERSION: u32 = 1;

/// A [`Cloth`] as it was, with all that its next step depends on but the colliders: made by [`Cloth::snapshot`], put back by
/// [`Cloth::restore`].
///
/// A clone shares the memory of the original. A snapshot takes about 120 bytes for each vertex, and 100 more for each touch.
/// With the feature `serialize` it can be written and read. The format must keep every digit of an f64, as RON and binary
/// formats do, and `serde_json` with its feature `float_roundtrip`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct Snapshot {
    version: u32,
    /// See [`identify`].
    shape: u64,
    fabric: Fabric,
    settings: SolverSettings,
    contact: ContactSettings,
    gravity: DVec3,
    positions: Shared<DVec3>,
    velocities: Shared<DVec3>,
    pins: Shared<(u32, DVec3)>,
    remembered: Remembered,
}

/// The part of it that depends on the engine.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::physics) struct Remembered {
    /// `None` if the next step starts anew.
    pub earlier: Option<Earlier>,
    pub changed: bool,
    /// J.
    pub energy_now: Option<f64>,
    /// J.
    pub surplus: f64,
    pub impact: Impact,
    pub touches: Shared<Memory>,
    /// The vertices held in the last solve, as the engine numbers them.
    pub held: Shared<u32>,
    pub turns: Turns,
}

/// The state before the present one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::physics) struct Earlier {
    /// Length of the step from there to here, s.
    pub dt: f64,
    pub positions: Shared<DVec3>,
    pub velocities: Shared<DVec3>,
}

/// Turns of mid-edge normals, rad, in the precision that they are computed in.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::physics) enum Turns {
    Single(Shared<f32>),
    Double(Shared<f64>),
}

impl Turns {
    pub fn new<T: Scalar>(turns: &[T]) -> Self {
        let wide = turns.iter().map(|turn| turn.to_f64());
        if size_of::<T>() == size_of::<f32>() {
            Self::Single(wide.map(|turn| turn as f32).collect())
        } else {
            Self::Double(wide.collect())
        }
    }

    pub fn to<T: Scalar>(&self) -> Vec<T> {
        match self {
            Self::Single(turns) => turns.iter().map(|&turn| T::from_f64(turn.into())).collect(),
            Self::Double(turns) => turns.iter().map(|&turn| T::from_f64(turn)).collect(),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Single(turns) => turns.len(),
            Self::Double(turns) => turns.len(),
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Single(turns) => turns.iter().all(|turn| turn.is_finite()),
            Self::Double(turns) => turns.iter().all(|turn| turn.is_finite()),
        }
    }
}

/// Why a cloth cannot be put into a state. It stays as it was.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum SnapshotError {
    /// The snapshot was made by another version of this library.
    #[error(
        "the snapshot has format {found}, but this version of the library reads format {expected}: it cannot be used any more"
    )]
    Version {
        /// Format of the snapshot.
        found: u32,
        /// The format that can be read.
        expected: u32,
    },
    /// The snapshot is of another mesh, of other options of the rest shape, or of another scale.
    #[error(
        "the snapshot is of another cloth: mesh, scale, welding, warp and bending model must be those that it was made with"
    )]
    Shape,
    /// A number is missing, NaN, or out of range, as in a file that was cut short or edited.
    #[error("the snapshot is damaged: {0}")]
    Damaged(&'static str),
    /// There are fewer or more entries than simulated vertices.
    #[error("there are {found} {what}, but the cloth has {expected} simulated vertices")]
    Count {
        /// Positions or velocities.
        what: &'static str,
        /// Number given.
        found: usize,
        /// Number of simulated vertices.
        expected: usize,
    },
    /// A position or velocity is NaN or infinite.
    #[error("the position or velocity of simulated vertex {vertex} is not finite")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
}

impl Snapshot {
    /// World positions of the simulated vertices, m.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Velocities of the simulated vertices, m/s.
    pub fn velocities(&self) -> &[DVec3] {
        &self.velocities
    }

    /// Bytes of memory that it takes, shared with its clones.
    pub fn size(&self) -> usize {
        let Self { positions, velocities, pins, remembered, .. } = self;
        let Remembered { earlier, touches, held, turns, .. } = remembered;
        let earlier = earlier.as_ref().map_or(0, |earlier| size_of_val(&*earlier.positions) * 2);
        let turns = match turns {
            Turns::Single(turns) => size_of_val(&**turns),
            Turns::Double(turns) => size_of_val(&**turns),
        };
        let state = size_of_val(&**positions) + size_of_val(&**velocities) + size_of_val(&**pins);
        size_of::<Self>() + state + earlier + size_of_val(&**touches) + size_of_val(&**held) + turns
    }

    /// Where the vertices were before the last step, if the next one goes on from there.
    pub(crate) fn earlier_positions(&self) -> Option<&[DVec3]> {
        self.remembered.earlier.as_ref().map(|earlier| &*earlier.positions)
    }

    /// Whether a cloth of this shape can be put into it.
    fn check(&self, shape: u64, count: usize) -> Result<(), SnapshotError> {
        if self.version != VERSION {
            return Err(SnapshotError::Version { found: self.version, expected: VERSION });
        }
        if self.shape != shape {
            return Err(SnapshotError::Shape);
        }
        let Self { fabric, settings, contact, gravity, positions, velocities, pins, remembered, .. } = self;
        let Remembered { earlier, energy_now, surplus, touches, held, turns, .. } = remembered;
        check_state(positions, velocities, count)?;
        if let Some(Earlier { dt, positions, velocities }) = earlier {
            check_state(positions, velocities, count)?;
            if !(dt.is_finite() && *dt > 0.0) {
                return Err(SnapshotError::Damaged("the length of the last step is not positive"));
            }
        }
        let known = |&vertex: &u32| (vertex as usize) < count;
        let numbers = gravity.is_finite() && surplus.is_finite() && energy_now.is_none_or(f64::is_finite);
        let checks = [
            (fabric.validate().is_ok(), "its fabric cannot exist"),
            (settings.validate().is_ok(), "its settings of the solver cannot be used"),
            (contact.validate().is_ok(), "its settings of contact cannot be used"),
            (numbers, "gravity or an energy is not finite"),
            (pins.iter().all(|(vertex, target)| known(vertex) && target.is_finite()), "a pin cannot be"),
            (held.iter().all(known), "it holds vertices that do not exist"),
            (touches.iter().all(|touch| touch.is_finite()), "a touch is not finite"),
            (turns.is_finite(), "a turn of a mid-edge normal is not finite"),
            (matches!(turns, Turns::Single(_)) == (settings.precision == Precision::Single), "its precisions differ"),
        ];
        match checks.into_iter().find(|(passed, _)| !passed) {
            Some((_, what)) => Err(SnapshotError::Damaged(what)),
            None => Ok(()),
        }
    }
}

fn check_state(positions: &[DVec3], velocities: &[DVec3], expected: usize) -> Result<(), SnapshotError> {
    for (what, found) in [("positions", positions.len()), ("velocities", velocities.len())] {
        if found != expected {
            return Err(SnapshotError::Count { what, found, expected });
        }
    }
    let finite = |(x, v): (&DVec3, &DVec3)| x.is_finite() && v.is_finite();
    match positions.iter().zip(velocities).position(|pair| !finite(pair)) {
        Some(vertex) => Err(SnapshotError::NotFinite { vertex }),
        None => Ok(()),
    }
}

impl Cloth {
    /// The cloth as it is, with all that its next step depends on: positions, velocities, pins, fabric, settings, gravity, the
    /// step before, and what is remembered of touches. It takes as long as copying that.
    ///
    /// Colliders are not in it: they are set again for the next step, as for any other.
    ///
    /// ```
    /// # use bevy::math::DVec3;
    /// # use bevy_cloth::physics::{Cloth, Fabric, RestShape, RestShapeOptions, SolverSettings, SurfaceMesh};
    /// # let positions = [DVec3::ZERO, DVec3::X, DVec3::Z];
    /// # let mesh = SurfaceMesh { positions: &positions, triangles: &[[0, 1, 2]], uvs: None };
    /// # let shape = RestShape::new(&mesh, &RestShapeOptions::default())?;
    /// # let mut cloth = Cloth::new(shape, Fabric::cotton(), SolverSettings::default())?;
    /// cloth.step(1.0 / 60.0);
    /// let snapshot = cloth.snapshot();
    /// cloth.step(1.0 / 60.0);
    /// let ahead = cloth.positions().to_vec();
    /// cloth.restore(&snapshot)?;
    /// cloth.step(1.0 / 60.0);
    /// assert_eq!(cloth.positions(), ahead);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            version: VERSION,
            shape: identify(&self.shape, &self.ordering),
            fabric: self.fabric,
            settings: self.settings,
            contact: self.contact_settings,
            gravity: self.gravity,
            positions: self.shown.positions.as_slice().into(),
            velocities: self.shown.velocities.as_slice().into(),
            pins: self.pinned().collect(),
            remembered: self.engine.remembered(&self.ordering),
        }
    }

    /// Puts the cloth back into the state of a snapshot, of itself or of another cloth made of the same mesh in the same way.
    /// Steps then lead where they led from there, to the last bit, if the colliders of each are the same.
    ///
    /// There are no [`contacts`](Self::contacts) until the next step.
    ///
    /// # Errors
    /// If the snapshot is of another cloth, of another version of this library, or damaged: the cloth then stays as it is.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        snapshot.check(identify(&self.shape, &self.ordering), self.masses.len())?;
        if snapshot.remembered.turns.len() != self.engine.turn_count() {
            return Err(SnapshotError::Damaged("turns of mid-edge normals are missing"));
        }
        self.set_settings(snapshot.settings);
        if self.fabric != snapshot.fabric {
            self.set_fabric(snapshot.fabric).map_err(|_| SnapshotError::Damaged("its fabric cannot exist"))?;
        }
        self.contact_settings = snapshot.contact;
        self.gravity = snapshot.gravity;
        self.shown.positions.copy_from_slice(&snapshot.positions);
        self.shown.velocities.copy_from_slice(&snapshot.velocities);
        self.take_shown();
        self.engine.remember(&snapshot.remembered, &self.ordering);
        self.pins.clear();
        for &(vertex, target) in &*snapshot.pins {
            self.pin(vertex, target);
        }
        self.earlier_contacts.clear();
        Ok(())
    }

    /// As [`set_state`](Self::set_state), for numbers that nobody has checked.
    ///
    /// # Errors
    /// If there is not one position and one velocity for each simulated vertex, or one is not finite: the cloth then stays as it
    /// is.
    pub fn try_set_state(&mut self, positions: &[DVec3], velocities: &[DVec3]) -> Result<(), SnapshotError> {
        check_state(positions, velocities, self.masses.len())?;
        self.set_state(positions, velocities);
        Ok(())
    }

    /// Takes what is shown for the state.
    fn take_shown(&mut self) {
        for (inner, &outer) in self.ordering.outer.iter().enumerate() {
            self.state.positions[inner] = self.shown.positions[outer as usize];
            self.state.velocities[inner] = self.shown.velocities[outer as usize];
        }
    }
}

/// Tells rest shapes apart: a hash of all that decides what the numbers of a snapshot belong to (Fowler, Noll & Vo, by words).
fn identify(shape: &RestShape, ordering: &Ordering) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |word: u64| hash = (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29);
    add(shape.bending as u64);
    for position in &shape.positions {
        position.to_array().into_iter().for_each(|coordinate| add(coordinate.to_bits()));
    }
    for triangle in &shape.triangles {
        triangle.vertices.into_iter().for_each(|vertex| add(vertex.into()));
        triangle.dm_inverse.into_iter().flatten().for_each(|entry| add(entry.to_bits()));
    }
    for simulated in &shape.simulated {
        add(simulated.map_or(u64::MAX, u64::from));
    }
    ordering.outer.iter().for_each(|&vertex| add(vertex.into()));
    shape.bending_hinges().iter().for_each(|hinge| add(hinge.rest_angle.to_bits()));
    hash
}
