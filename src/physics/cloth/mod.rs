//! A cloth in motion: rest shape, fabric, state, and the step that advances it.

mod colliding;
mod engine;
mod implicit;
mod integrator;
mod measure;
mod pins;
mod quality;
mod remeasure;
mod report;
mod rigid;
mod safeguard;
mod scheme;
mod settings;
mod shared;
mod snapshot;
mod touching;

use bevy::math::{DAffine3, DVec3};
use bevy::platform::time::Instant;

use self::engine::Engine;
use self::pins::Pins;
pub use integrator::Integrator;
pub use measure::{Energy, Stretch};
pub use quality::Quality;
pub use report::{ClothFault, StepOutcome, StepReport};
pub use settings::{NewClothError, Precision, SettingsError, SolverSettings};
pub(crate) use shared::Shared;
pub use snapshot::{Snapshot, SnapshotError};

use crate::physics::assembly::Ordering;
use crate::physics::assembly::parts::in_pool;
use crate::physics::contact::{Collider, Contact, ContactSettings, Surroundings};
use crate::physics::material::{Fabric, MaterialError};
use crate::physics::mesh::RestShape;

/// Positions and velocities of the simulated vertices, in world space.
#[derive(Clone, Debug)]
struct State {
    /// m.
    positions: Vec<DVec3>,
    /// m/s.
    velocities: Vec<DVec3>,
}

/// A simulated cloth, free of any ECS.
///
/// ```
/// use bevy::math::DVec3;
/// use bevy_cloth::physics::{Cloth, Fabric, RestShape, RestShapeOptions, SolverSettings, SurfaceMesh};
///
/// let mesh = SurfaceMesh {
///     positions: &[DVec3::ZERO, DVec3::X, DVec3::new(0.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0)],
///     triangles: &[[0, 2, 1], [1, 2, 3]],
///     uvs: None,
/// };
/// let shape = RestShape::new(&mesh, &RestShapeOptions::default())?;
/// let mut cloth = Cloth::new(shape, Fabric::cotton(), SolverSettings::default())?;
/// for vertex in [0, 1] {
///     cloth.pin(vertex, cloth.positions()[vertex as usize]);
/// }
/// cloth.step(1.0 / 60.0);
/// assert!(cloth.positions()[2].y < -1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Cloth {
    shape: RestShape,
    fabric: Fabric,
    settings: SolverSettings,
    gravity: DVec3,
    wind: DVec3,
    /// The order that the engine has its vertices in, and with it `inner_masses`, `state` and `pins`.
    ordering: Ordering,
    inner_masses: Vec<f64>,
    /// All masses together, kg.
    mass: f64,
    state: State,
    /// Where a step of several substeps began: it stays there if one of them fails.
    before: State,
    pins: Pins,
    colliders: Vec<Collider>,
    contact_settings: ContactSettings,
    /// Touches of the last step, in the order of the engine, of all of its substeps but the last.
    earlier_contacts: Vec<Contact>,
    /// Share of the last step that its last substep had.
    last_share: f64,
    /// The state in the order of the shape.
    shown: State,
    masses: Vec<f64>,
    engine: Box<dyn Engine>,
}

/// What is told of a substep, see [`Cloth::step_watched`].
pub type Watch<'a> = dyn FnMut(f64, &[DVec3]) + Send + 'a;

impl Cloth {
    /// A cloth at its rest positions, at rest, without pins, under standard gravity along −Y.
    ///
    /// # Errors
    /// If a constant of the fabric is invalid, or a setting cannot be used.
    pub fn new(shape: RestShape, fabric: Fabric, settings: SolverSettings) -> Result<Self, NewClothError> {
        fabric.validate()?;
        settings.validate()?;
        let count = shape.vertex_count();
        let ordering = Ordering::new(&shape);
        let shown = State { positions: shape.positions.clone(), velocities: vec![DVec3::ZERO; count] };
        let masses = masses(&shape, &fabric);
        let state = State { positions: in_order(&ordering, &shown.positions), velocities: shown.velocities.clone() };
        let mut engine = engine::new(&shape, &fabric, &settings, &ordering);
        engine.settle(&state.positions);
        Ok(Self {
            engine,
            inner_masses: in_order(&ordering, &masses),
            mass: masses.iter().sum(),
            before: State { positions: vec![DVec3::ZERO; count], velocities: Vec::new() },
            state,
            pins: Pins::new(count),
            colliders: Vec::new(),
            contact_settings: ContactSettings::default(),
            earlier_contacts: Vec::new(),
            last_share: 1.0,
            ordering,
            shown,
            masses,
            gravity: DVec3::new(0.0, -9.81, 0.0),
            wind: DVec3::ZERO,
            shape,
            fabric,
            settings,
        })
    }

    /// The undeformed cloth.
    pub fn shape(&self) -> &RestShape {
        &self.shape
    }

    /// The fabric.
    pub fn fabric(&self) -> &Fabric {
        &self.fabric
    }

    /// Changes the fabric; the cloth keeps its motion.
    ///
    /// # Errors
    /// If a constant is invalid: the old fabric then stays.
    pub fn set_fabric(&mut self, fabric: Fabric) -> Result<(), MaterialError> {
        fabric.validate()?;
        self.engine.set_fabric(&self.shape, &fabric);
        self.engine.settle(&self.state.positions);
        self.masses = masses(&self.shape, &fabric);
        self.inner_masses = in_order(&self.ordering, &self.masses);
        self.mass = self.masses.iter().sum();
        self.fabric = fabric;
        Ok(())
    }

    /// The settings of the solver.
    pub fn settings(&self) -> &SolverSettings {
        &self.settings
    }

    /// Changes how steps are solved; the cloth keeps its motion. Costs nothing unless precision, solver, preconditioner or
    /// the limit of iterations are others: these are built anew. Settings that do not pass [`SolverSettings::validate`] waste
    /// time, and do no harm.
    pub fn set_settings(&mut self, settings: SolverSettings) {
        if settings.same_engine(&self.settings) {
            self.engine.set_settings(&settings);
        } else {
            self.engine = engine::new(&self.shape, &self.fabric, &settings, &self.ordering);
            self.engine.settle(&self.state.positions);
        }
        self.settings = settings;
    }

    /// Gravity, m/s².
    pub fn gravity(&self) -> DVec3 {
        self.gravity
    }

    /// Changes gravity, m/s².
    pub fn set_gravity(&mut self, gravity: DVec3) {
        self.gravity = gravity;
    }

    /// World positions of the simulated vertices, m.
    pub fn positions(&self) -> &[DVec3] {
        &self.shown.positions
    }

    /// Velocities of the simulated vertices, m/s.
    pub fn velocities(&self) -> &[DVec3] {
        &self.shown.velocities
    }

    /// Lumped masses of the simulated vertices, kg.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Puts the cloth into a state. Pins stay.
    ///
    /// # Panics
    /// If either slice has not one entry per simulated vertex.
    pub fn set_state(&mut self, positions: &[DVec3], velocities: &[DVec3]) {
        self.shown.positions.copy_from_slice(positions);
        self.shown.velocities.copy_from_slice(velocities);
        for (inner, &outer) in self.ordering.outer.iter().enumerate() {
            self.state.positions[inner] = positions[outer as usize];
            self.state.velocities[inner] = velocities[outer as usize];
        }
        self.engine.restart();
        self.engine.settle(&self.state.positions);
    }

    /// Carries the cloth elsewhere without it noticing: positions, velocities, history and pin targets are mapped, and it goes on from
    /// there. After a rigid motion it moves as it would have moved, but for gravity and colliders, which stay where they are.
    pub fn carry(&mut self, map: DAffine3) {
        self.state.map(map, DVec3::ZERO);
        self.pins.transform(map);
        self.engine.carry(map, &self.state.positions);
        self.show();
    }

    /// Gives all vertices another velocity on top of theirs (m/s), as if the cloth had been seen from a train until now: history is
    /// changed with it.
    pub fn boost(&mut self, velocity: DVec3) {
        self.state.velocities.iter_mut().for_each(|v| *v += velocity);
        self.engine.boost(velocity);
        self.show();
    }

    /// Velocity of the air that [`Fabric::air_drag`] acts against, m/s. Zero at first.
    pub fn set_wind(&mut self, wind: DVec3) {
        self.wind = wind;
    }

    /// Brings the state into the order of the shape.
    fn show(&mut self) {
        for (inner, &outer) in self.ordering.outer.iter().enumerate() {
            self.shown.positions[outer as usize] = self.state.positions[inner];
            self.shown.velocities[outer as usize] = self.state.velocities[inner];
        }
    }

    /// Holds a simulated vertex: it will be at `target` (m) at the end of the next step, and stay there.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn pin(&mut self, vertex: u32, target: DVec3) {
        self.pins.set(self.ordering.inner[vertex as usize], target);
    }

    /// Lets a simulated vertex go.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn unpin(&mut self, vertex: u32) {
        self.pins.unset(self.ordering.inner[vertex as usize]);
    }

    /// Lets every vertex go.
    pub fn clear_pins(&mut self) {
        self.pins.clear();
    }

    /// Where a vertex is held, if it is, m.
    pub fn pin_target(&self, vertex: u32) -> Option<DVec3> {
        self.ordering.inner.get(vertex as usize).and_then(|&inner| self.pins.target(inner))
    }

    /// All held vertices and where, m.
    pub fn pinned(&self) -> impl Iterator<Item = (u32, DVec3)> {
        let vertices = 0..self.masses.len() as u32;
        vertices.filter_map(|vertex| self.pin_target(vertex).map(|target| (vertex, target)))
    }

    /// Advances by `dt` seconds; 0 does nothing.
    ///
    /// Never panics: a step that cannot be taken leaves the cloth where it is, at rest, and says so in the report.
    pub fn step(&mut self, dt: f64) -> StepReport {
        self.step_watched(dt, None)
    }

    /// The same, for those who ask what happens within a step: after every substep but the last, `watch` is told what share of the step
    /// is done, and where the vertices are, m.
    pub fn step_watched(&mut self, dt: f64, watch: Option<&mut Watch>) -> StepReport {
        let start = Instant::now();
        let mut report = StepReport::NONE;
        if dt != 0.0
            && let Err(fault) = self.try_step(dt, watch, &mut report)
        {
            self.state.velocities.fill(DVec3::ZERO);
            self.earlier_contacts.clear();
            self.engine.restart();
            self.engine.settle(&self.state.positions);
            report.outcome = StepOutcome::Rejected(fault);
        }
        self.show();
        report.total = start.elapsed();
        report
    }

    fn try_step(&mut self, dt: f64, mut watch: Option<&mut Watch>, report: &mut StepReport) -> Result<(), ClothFault> {
        if !(dt.is_finite() && dt > 0.0) {
            return Err(ClothFault::TimeStep);
        }
        let Self { ordering, gravity, inner_masses, mass, state, before, pins, colliders, .. } = self;
        let Self { engine, earlier_contacts, .. } = self;
        earlier_contacts.clear();
        let settings = self.contact_settings;
        // Drag is proportional to mass, as gravity is: −α m (v − w).
        let gravity = *gravity + f64::from(self.fabric.air_drag) * self.wind;
        let around = |from, to| Surroundings { colliders, settings, from, to };
        let least = self.settings.substeps.max(1);
        let taken = in_pool(ordering.part_starts.len(), || {
            let whole = engine::Step { dt, gravity, masses: inner_masses, mass: *mass, pins, around: around(0.0, 1.0) };
            let substeps = least.max(engine.pieces(whole, state));
            let share = |done| f64::from(done) / f64::from(substeps);
            self.last_share = share(1);
            if substeps > 1 {
                before.positions.clone_from(&state.positions);
            }
            let taken = (1..=substeps).rev().try_for_each(|remaining| {
                pins.advance(&state.positions, remaining);
                let done = substeps - remaining;
                let around = around(share(done), share(done + 1));
                let dt = dt / f64::from(substeps);
                let step = engine::Step { dt, gravity, masses: inner_masses, mass: *mass, pins, around };
                report.substeps += 1;
                engine.step(step, state, report)?;
                if let Some(watch) = watch.as_mut().filter(|_| remaining > 1) {
                    let inner = ordering.inner.iter();
                    watch(share(done + 1), &inner.map(|&vertex| state.positions[vertex as usize]).collect::<Vec<_>>());
                }
                if remaining > 1 && !colliders.is_empty() {
                    let contacts = engine.contacts(&state.positions).into_iter();
                    earlier_contacts.extend(contacts.map(|contact| contact.scaled(share(1))));
                }
                Ok::<_, ClothFault>(())
            });
            if taken.is_err() && substeps > 1 {
                state.positions.clone_from(&before.positions);
            }
            taken
        });
        for collider in &mut self.colliders {
            collider.start = collider.end;
        }
        taken
    }

    /// Energy by term.
    pub fn energy(&self) -> Energy {
        measure::energy(self, self.engine.energy(&self.state.positions))
    }

    /// How far the yarns are stretched.
    pub fn stretch(&self) -> Stretch {
        measure::stretch(&self.shape, &self.shown.positions)
    }
}

impl core::fmt::Debug for Cloth {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Cloth")
            .field("vertices", &self.shape.vertex_count())
            .field("triangles", &self.shape.triangles.len())
            .field("fabric", &self.fabric)
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

/// Values of vertices in the order of the engine.
fn in_order<T: Copy>(ordering: &Ordering, values: &[T]) -> Vec<T> {
    ordering.outer.iter().map(|&vertex| values[vertex as usize]).collect()
}

/// Lumped masses: each vertex has a third of the mass of the triangles around it, kg.
fn masses(shape: &RestShape, fabric: &Fabric) -> Vec<f64> {
    shape.vertex_areas.iter().map(|area| area * f64::from(fabric.density)).collect()
}
