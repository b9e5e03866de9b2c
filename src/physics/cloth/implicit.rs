//! The implicit step: predict, linearise, solve, check.

use bevy::math::{DAffine3, DMat3, DVec3};
use bevy::platform::time::Instant;

use super::engine::{Engine, Step};
use super::pins::Pins;
use super::scheme::{Linear, Scheme};
use super::snapshot::{Earlier, Remembered, Turns};
use super::touching::{Impact, contact_layer, longest_side};
use super::{ClothFault, SolverSettings, State, StepReport, rigid};
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::assembly::{Constraints, ElasticEnergy, ImplicitStep, Ordering, System};
use crate::physics::contact::{Contact, ContactLayer};
use crate::physics::material::Fabric;
use crate::physics::math::{Padded, Scalar};
use crate::physics::mesh::RestShape;
use crate::physics::solve::{LinearSolver, solver};

/// Share of the relative tolerance that a cloth without pins is solved to.
const FREE_TOLERANCE: f64 = 0.1;
/// A cloth that touches something and is slower than this, m/s, settles: it is linearised further back.
const SETTLING_SPEED: f64 = 0.1;

/// Change of lengths by a map, relative and twice, up to which it is rigid: the energy stays what it was.
const RIGID: f64 = 1e-9;

/// A cloth's linear system, its solver, and what a step remembers.
pub(super) struct Implicit<T: Scalar> {
    pub system: System<T>,
    constraints: Constraints,
    solver: Box<dyn LinearSolver<T>>,
    pub settings: SolverSettings,
    /// dp, s, and α, 1/s.
    pub damping: f64,
    pub air_drag: f64,
    pub history: History,
    /// Elastic energy of the present state, if known, J.
    pub energy_now: Option<f64>,
    /// Energy gained that nothing gave, and not lost again since, J.
    pub surplus: f64,

    pub contact: ContactLayer,
    pub impact: Impact,
    /// See [`ImplicitStep::inertia`]; empty while nothing touches.
    pub inertia: Vec<f64>,

    solution: Vec<Padded<T>>,
    /// Of a cloth without pins; else empty.
    residual: Vec<Padded<T>>,
    /// y, q, x and d of [`ImplicitStep`], m.
    pub inertial: Vec<DVec3>,
    pub origin: Vec<DVec3>,
    pub point: Vec<DVec3>,
    pub moves: Vec<DVec3>,
    /// The state a step leads to, if it is accepted.
    pub candidate: State,
}

/// The state before the present one.
pub(super) struct History {
    pub state: State,
    /// Length of the step between them, s; `None` if there was none.
    pub dt: Option<f64>,
    /// Whether it was far from the length of the step before it.
    pub changed: bool,
}

/// Where a solve starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Guess {
    /// Where inertia leads.
    Inertia,
    /// At the point of linearisation, where an earlier solve of this step has led.
    Point,
    /// There too, and nothing is added to what conjugate gradients find: wherever they stop, the moves lower what they minimise.
    Downhill,
}

impl<T: Scalar> Implicit<T> {
    pub fn new(shape: &RestShape, fabric: &Fabric, settings: &SolverSettings, ordering: &Ordering) -> Self {
        let system = System::new(shape, fabric, ordering);
        let count = shape.vertex_count();
        let (zeros, small_zeros) = (vec![DVec3::ZERO; count], vec![Padded::zero(); count]);
        let state = State { positions: zeros.clone(), velocities: zeros.clone() };
        Self {
            solver: solver(settings.kind, system.matrix.pattern()),
            settings: *settings,
            damping: fabric.damping.into(),
            air_drag: fabric.air_drag.into(),
            history: History { state: state.clone(), dt: None, changed: false },
            energy_now: None,
            surplus: 0.0,
            constraints: Constraints::default(),
            contact: contact_layer(shape, fabric, ordering),
            impact: Impact::NONE,
            inertia: Vec::new(),
            system,
            solution: small_zeros,
            residual: Vec::new(),
            inertial: zeros.clone(),
            origin: zeros.clone(),
            point: zeros.clone(),
            moves: zeros,
            candidate: state,
        }
    }

    /// Newton's method: solves for `moves`, from the last point of linearisation to where the scheme leads, after moving that
    /// point to where all solves before the last have led. Inexact (Dembo, Eisenstat & Steihaug 1982): each solve stops at
    /// a share of its own first residual, or when what is left of it would pass for rest.
    fn iterate(
        &mut self,
        linear: Linear,
        newton_steps: u32,
        step: Step,
        state: &State,
        report: &mut StepReport,
    ) -> Result<(), ClothFault> {
        self.solve(linear, Guess::Inertia, step, state, report)?;
        if !self.contact.is_empty() {
            return self.follow_contact(linear, newton_steps, step, state, report);
        }
        for _ in 1..newton_steps {
            self.move_point();
            let before = report.iterations;
            self.solve(linear, Guess::Point, step, state, report)?;
            if self.settings.kind.is_iterative() && report.iterations == before {
                break;
            }
        }
        Ok(())
    }

    /// Moves the point of linearisation to where the last solve led.
    pub fn move_point(&mut self) {
        let Self { system, point, moves, .. } = self;
        let moves = &moves[..];
        for_parts(system.matrix.pattern().parts(), &mut point[..], &|part: &Part, point| {
            for (point, &moved) in point.iter_mut().zip(&moves[part.rows.clone()]) {
                *point += moved;
            }
        });
    }

    /// Solves for `moves`, from the point of linearisation to where the scheme leads.
    pub fn solve(
        &mut self,
        linear: Linear,
        guess: Guess,
        step: Step,
        state: &State,
        report: &mut StepReport,
    ) -> Result<(), ClothFault> {
        let start = Instant::now();
        let Self { system, constraints, solver, contact, inertia, solution, residual, .. } = self;
        let Self { inertial, origin, point, moves, .. } = self;
        let (held, touching) = (step.pins.held(), contact.any_active());
        // What touches is held by that: nothing else is known of its moves before the solve.
        let any_held = step.pins.any() || touching;
        let mut implicit = ImplicitStep {
            x: point,
            inertial,
            origin,
            gamma: linear.gamma,
            gravity: step.gravity,
            damping: linear.damping,
            air_drag: linear.air_drag,
            projection: linear.projection,
            drift: DVec3::ZERO,
            inertia: (!inertia.is_empty()).then_some(&inertia[..]),
            contacts: contact.terms(point),
        };
        implicit.drift = if guess == Guess::Downhill || touching || (any_held && guess == Guess::Point) {
            DVec3::ZERO
        } else if any_held {
            let parts = system.matrix.pattern().parts();
            let moves = for_parts(parts, (), &|part: &Part, ()| {
                part.rows.clone().map(|vertex| step.masses[vertex] * implicit.inertial_move(vertex)).sum::<DVec3>()
            });
            moves / step.mass
        } else {
            implicit.free_drift(step.masses)
        };
        system.hold(held);
        system.assemble(&implicit, step.masses);
        let prescribed = |vertex: usize| {
            let x = state.positions[vertex];
            let target = step.pins.waypoint(vertex).map_or(x, |waypoint| x.lerp(waypoint, linear.pin_share));
            Padded::from_f64((target - point[vertex] - implicit.drift).to_array())
        };
        constraints.set(system.matrix.pattern(), held);
        constraints.apply(&mut system.matrix, &mut system.rhs, prescribed);
        let assembled = Instant::now();
        report.assembly += assembled - start;

        // Gravity is in the starting guess only if nothing holds the cloth: rest must not depend on how well the solver
        // takes it out again.
        let fall = if any_held { DVec3::ZERO } else { implicit.free_fall() };
        let guessed = |vertex: usize| {
            let free = match guess {
                Guess::Inertia if inertia.get(vertex).is_some_and(|&factor| factor != 1.0) => DVec3::ZERO,
                Guess::Inertia => implicit.inertial_move(vertex) + fall - implicit.drift,
                Guess::Point | Guess::Downhill => -implicit.drift,
            };
            if held[vertex] { prescribed(vertex) } else { Padded::from_f64(free.to_array()) }
        };
        for_parts(system.matrix.pattern().parts(), &mut solution[..], &|part: &Part, solution| {
            for (d, vertex) in solution.iter_mut().zip(part.rows.clone()) {
                *d = guessed(vertex);
            }
        });
        let mut target = self.settings.target(step.mass, linear.gamma);
        if !any_held {
            // What a truncated solve does to the spin of a cloth, nothing else takes back.
            target.relative *= FREE_TOLERANCE;
        }
        let solved = solver.solve(&mut system.matrix, &system.rhs, solution, target)?;
        report.iterations += solved.iterations;
        report.preconditioner += solved.preparation;
        let (d, drift) = (&solution[..], implicit.drift);
        let finite = for_parts(system.matrix.pattern().parts(), &mut moves[..], &|part: &Part, moves| {
            let mut sum = DVec3::ZERO;
            for (moved, d) in moves.iter_mut().zip(&d[part.rows.clone()]) {
                *moved = DVec3::from(d.to_f64()) + drift;
                sum += moved.abs();
            }
            sum.is_finite()
        });
        if !finite {
            return Err(ClothFault::NotFinite);
        }
        if !any_held && guess != Guess::Downhill {
            residual.resize(solution.len(), Padded::zero());
            system.matrix.interleave();
            system.matrix.multiply(solution, residual);
            let rest = |vertex: usize| DVec3::from((system.rhs[vertex] - residual[vertex]).to_f64());
            rigid::correct(moves, rest, point, step.masses);
        }
        report.solve += assembled.elapsed().saturating_sub(solved.preparation);
        Ok(())
    }
}

impl<T: Scalar> Engine for Implicit<T> {
    fn pieces(&mut self, step: Step, state: &State) -> u32 {
        self.impact_pieces(step, state)
    }

    fn step(&mut self, step: Step, state: &mut State, report: &mut StepReport) -> Result<(), ClothFault> {
        // First, as a solve changes the turns of mid-edge normals, and with them the energy.
        let mut checked = self.checked(step, state);
        let (mut scheme, newton_steps) = self.scheme(step.dt);
        let touching = self.find_contact(step, state, report);
        if touching && matches!(scheme, Scheme::Midpoint) {
            scheme = Scheme::BackwardEuler;
        }
        let slow = 0.5 * SETTLING_SPEED * SETTLING_SPEED * step.mass;
        let settling = self.contact.any_active() && self.kinetic(step, &state.velocities) < slow;
        let linear = self.predict(scheme, step.dt, settling, state);
        if touching {
            self.slow_down_touching(linear.gamma, step, state);
            self.start_at_planes(step.pins.held());
        }
        let solved = self.iterate(linear, newton_steps, step, state, report).map(|()| {
            self.finish(scheme, step, state);
            report.rescues += self.guard(step, state);
        });
        let energy = match solved.ok().and_then(|()| self.acceptable(&mut checked, step, state, report)) {
            Some(energy) => {
                self.history.dt = Some(step.dt);
                energy
            }
            None => {
                report.fallbacks += 1;
                self.history.dt = None;
                // Where the step would have led must not be in the energy it started with.
                self.settle(&state.positions);
                let checked = self.checked(step, state);
                self.fall_back(checked, step, state, report)?
            }
        };
        self.contact.remember(&step.around);
        self.energy_now = Some(energy);
        core::mem::swap(state, &mut self.candidate);
        // `candidate` holds the state before this step now: next time it is history.
        core::mem::swap(&mut self.candidate, &mut self.history.state);
        Ok(())
    }

    fn energy(&self, positions: &[DVec3]) -> ElasticEnergy {
        self.system.energy_at(positions)
    }

    fn set_fabric(&mut self, shape: &RestShape, fabric: &Fabric) {
        self.system.set_fabric(shape, fabric);
        self.contact.set_fabric(fabric);
        self.damping = fabric.damping.into();
        self.air_drag = fabric.air_drag.into();
        self.energy_now = None;
    }

    fn measure(&mut self, shape: &RestShape, fabric: &Fabric, ordering: &Ordering) {
        self.system.measure(shape, fabric, ordering);
        self.contact.set_longest_side(longest_side(shape));
        self.energy_now = None;
    }

    fn map(&mut self, map: DAffine3, state: &State, pins: &Pins) {
        let before = &mut self.history.state;
        let drifted = pins.mean(&state.positions) - pins.mean(&before.positions);
        let drift = pins.mean(&before.velocities);
        before.map_earlier(map, drifted, drift);
        if map.matrix3.determinant() < 0.0 {
            self.system.mirror();
        }
        self.energy_now = None;
    }

    fn set_settings(&mut self, settings: &SolverSettings) {
        self.settings = *settings;
    }

    fn contacts(&self, positions: &[DVec3]) -> Vec<Contact> {
        self.contact.show(positions)
    }

    fn carry(&mut self, map: DAffine3, x: &[DVec3]) {
        self.history.state.map(map, DVec3::ZERO);
        let gram = map.matrix3.transpose() * map.matrix3;
        if !(gram.abs_diff_eq(DMat3::IDENTITY, RIGID) && map.matrix3.determinant() > 0.0) {
            self.settle(x);
        }
    }

    fn boost(&mut self, velocity: DVec3) {
        let History { state, dt, .. } = &mut self.history;
        state.velocities.iter_mut().for_each(|v| *v += velocity);
        let way = velocity * dt.unwrap_or(0.0);
        state.positions.iter_mut().for_each(|x| *x -= way);
    }

    fn restart(&mut self) {
        self.contact.forget();
        self.impact = Impact::NONE;
        self.history.dt = None;
        self.surplus = 0.0;
        self.energy_now = None;
    }

    fn settle(&mut self, x: &[DVec3]) {
        self.system.settle(x);
        self.energy_now = None;
    }

    fn remembered(&self, ordering: &Ordering) -> Remembered {
        let History { state, dt, changed } = &self.history;
        let earlier = dt.map(|dt| Earlier {
            dt,
            positions: ordering.inner.iter().map(|&v| state.positions[v as usize]).collect(),
            velocities: ordering.inner.iter().map(|&v| state.velocities[v as usize]).collect(),
        });
        Remembered {
            earlier,
            changed: *changed,
            energy_now: self.energy_now,
            surplus: self.surplus,
            impact: self.impact,
            touches: self.contact.memories().into(),
            held: (0..).zip(self.system.held()).filter(|(_, held)| **held).map(|(vertex, _)| vertex).collect(),
            turns: Turns::new(&self.system.turns()),
        }
    }

    fn turn_count(&self) -> usize {
        self.system.turns().len()
    }

    fn remember(&mut self, remembered: &Remembered, ordering: &Ordering) {
        let mut held = vec![false; ordering.outer.len()];
        remembered.held.iter().for_each(|&vertex| held[vertex as usize] = true);
        self.system.hold(&held);
        self.system.set_turns(&remembered.turns.to::<T>());
        self.contact.forget();
        self.contact.recall_all(&remembered.touches);
        let state = &mut self.history.state;
        if let Some(Earlier { positions, velocities, .. }) = &remembered.earlier {
            for (inner, &outer) in ordering.outer.iter().enumerate() {
                state.positions[inner] = positions[outer as usize];
                state.velocities[inner] = velocities[outer as usize];
            }
        }
        self.history.dt = remembered.earlier.as_ref().map(|earlier| earlier.dt);
        self.history.changed = remembered.changed;
        self.energy_now = remembered.energy_now;
        self.surplus = remembered.surplus;
        self.impact = remembered.impact;
    }
}
