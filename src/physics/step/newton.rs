//! Linearize and solve: A d = b from terms, with pins taken out, again where contact was wrong or more Newton steps are asked for.

use bevy::math::DVec3;
use bevy::platform::time::Instant;

use super::plan::Plan;
use super::prediction::{Linear, Prediction};
use super::rigid;
use super::substep::Step;
use super::terms::Terms;
use crate::physics::assembly::parts::{Part, for_parts};
use crate::physics::assembly::{Constraints, ImplicitStep, Stencil};
use crate::physics::cloth::{ClothFault, SolverSettings, StepReport};
use crate::physics::math::{Padded, Scalar};
use crate::physics::solve::LinearSolver;
use crate::physics::terms::Row;

/// Share of the relative tolerance that a cloth without pins is solved to.
const FREE_TOLERANCE: f64 = 0.1;

/// Share of the forces of contact that may be wrong after a solve: the few touches that were will be right in the next step.
const WRONG: f64 = 0.1;
/// Solves beyond the first, at most, in which touches are let go, found or begin to slip.
const CONTACT_STEPS: u32 = 2;
/// Above this share there may be more: an impact that is left half solved drags the cloth along as if it were glued.
const MOSTLY_WRONG: f64 = 0.5;
const MOST_CONTACT_STEPS: u32 = 8;

/// A point of linearization and the moves from there that were solved for.
#[derive(Default)]
pub(super) struct Iterate {
    /// m.
    pub point: Vec<DVec3>,
    /// m.
    pub moves: Vec<DVec3>,
}

impl Iterate {
    /// No moves from a point yet, in the memory of another.
    pub fn new(mut memory: Self, point: &[DVec3]) -> Self {
        memory.point.clear();
        memory.point.extend_from_slice(point);
        memory.moves.resize(point.len(), DVec3::ZERO);
        memory
    }

    /// Where the moves lead.
    pub fn at(&self, vertex: usize) -> DVec3 {
        self.point[vertex] + self.moves[vertex]
    }

    /// Makes where the moves lead the next point of linearization.
    fn advance(&mut self, parts: &[Part]) {
        let moves = &self.moves[..];
        for_parts(parts, &mut self.point[..], &|part: &Part, point| {
            for (point, &moved) in point.iter_mut().zip(&moves[part.rows.clone()]) {
                *point += moved;
            }
        });
    }
}

/// Where a solve starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Guess {
    /// Where inertia leads.
    Inertia,
    /// At the point of linearization, where an earlier solve of this step has led.
    Point,
    /// There too, and nothing is added to what conjugate gradients find: wherever they stop, the moves lower what they minimize.
    Downhill,
}

/// Solves for moves.
pub(super) struct Newton<T: Scalar> {
    pub solver: Box<dyn LinearSolver<T>>,
    pub settings: SolverSettings,
    /// Material damping dp, s.
    pub damping: f64,
    constraints: Constraints,
    stencils: Vec<Stencil>,
    solution: Vec<Padded<T>>,
    /// Of a cloth without pins; else empty.
    residual: Vec<Padded<T>>,
}

impl<T: Scalar> Newton<T> {
    pub fn new(solver: Box<dyn LinearSolver<T>>, settings: SolverSettings, damping: f64, vertices: usize) -> Self {
        Self {
            solver,
            settings,
            damping,
            constraints: Constraints::default(),
            stencils: Vec::new(),
            solution: vec![Padded::zero(); vertices],
            residual: Vec::new(),
        }
    }

    /// Newton's method: from the point of the prediction to where the scheme leads, linearized anew where all solves before the
    /// last have led. Inexact (Dembo, Eisenstat & Steihaug 1982): each solve stops at a share of its own first residual, or when
    /// what is left of it would pass for rest.
    ///
    /// After each solve contact is judged: where it was wrong, its active set changes, and the system is solved again.
    pub fn run(
        &mut self,
        terms: &mut Terms<T>,
        plan: Plan,
        (prediction, iterate): (&mut Prediction, &mut Iterate),
        step: &Step,
        report: &mut StepReport,
    ) -> Result<(), ClothFault> {
        let linear = plan.scheme.linear(step.start.dt);
        self.solve(terms, linear, Guess::Inertia, (prediction, iterate), step, report)?;
        let mut linearized = 1;
        for solves in 0.. {
            let wrong_contact = !terms.contact.is_empty() && self.contact_is_wrong(terms, solves, iterate, step);
            if !wrong_contact && linearized >= plan.newton_steps {
                break;
            }
            report.contact_solves += u32::from(wrong_contact);
            if !terms.contact.is_empty() {
                prediction.slow_down(terms.contact.touched(), linear.gamma, step);
            }
            iterate.advance(terms.parts());
            let before = report.iterations;
            self.solve(terms, linear, Guess::Point, (prediction, iterate), step, report)?;
            let solved = self.settings.kind.is_iterative() && report.iterations == before;
            linearized = if solved { plan.newton_steps } else { linearized + 1 };
        }
        Ok(())
    }

    /// Judges contact by where the last solve led; says whether so much of it was wrong that the system must be solved again.
    fn contact_is_wrong(&self, terms: &mut Terms<T>, solves: u32, iterate: &Iterate, step: &Step) -> bool {
        let end = |vertex: usize| iterate.at(vertex);
        let wrong = terms.contact.judge(end);
        let most = if wrong > MOSTLY_WRONG { MOST_CONTACT_STEPS } else { CONTACT_STEPS };
        let late = terms.contact.find_late(&step.around, &step.start, end);
        (wrong > WRONG || late) && solves < most
    }

    /// Solves for the moves of `iterate`, from its point to where the scheme leads.
    pub fn solve(
        &mut self,
        terms: &mut Terms<T>,
        linear: Linear,
        guess: Guess,
        (prediction, iterate): (&Prediction, &mut Iterate),
        step: &Step,
        report: &mut StepReport,
    ) -> Result<(), ClothFault> {
        let start = Instant::now();
        let Self { solver, settings, damping, constraints, stencils, solution, residual } = self;
        let Iterate { point, moves } = iterate;
        let (held, masses) = (step.start.held, step.start.masses);
        // What is held by terms is: nothing else is known of its moves before the solve.
        let by_terms = terms.hold();
        let any_held = step.pins.any() || by_terms;
        terms.stencils(point, stencils);
        let Terms { system, .. } = terms;
        let mut implicit = ImplicitStep {
            x: point,
            inertial: &prediction.inertial,
            origin: &prediction.origin,
            gamma: linear.gamma,
            gravity: step.start.gravity,
            wind: step.start.wind,
            damping: if linear.dissipates { *damping } else { 0.0 },
            dissipates: linear.dissipates,
            projection: linear.projection,
            drift: DVec3::ZERO,
            inertia: (!prediction.inertia.is_empty()).then_some(&prediction.inertia[..]),
            stencils,
        };
        implicit.drift = match guess {
            Guess::Downhill => DVec3::ZERO,
            _ if by_terms => DVec3::ZERO,
            Guess::Point if any_held => DVec3::ZERO,
            Guess::Inertia if any_held => system.inertial_drift(&implicit, masses) / step.start.mass,
            Guess::Inertia | Guess::Point => system.free_drift(&implicit, masses),
        };
        system.hold(held);
        system.assemble(&implicit, masses);
        let prescribed = |vertex: usize| {
            let x = step.start.x[vertex];
            let target = step.pins.waypoint(vertex).map_or(x, |waypoint| x.lerp(waypoint, linear.pin_share));
            Padded::from_f64((target - implicit.x[vertex] - implicit.drift).to_array())
        };
        constraints.set(system.matrix.pattern(), held);
        constraints.apply(&mut system.matrix, &mut system.rhs, prescribed);
        let assembled = Instant::now();
        report.assembly += assembled - start;

        // Gravity is in the starting guess only if nothing holds the cloth: rest must not depend on how well the solver
        // takes it out again.
        let fall = if any_held { DVec3::ZERO } else { linear.gamma * linear.gamma * step.start.gravity };
        system.for_rows(&implicit, masses, &mut solution[..], &|part: &Part, solution, vertex, row: &Row| {
            let free = match guess {
                Guess::Inertia if prediction.is_slowed(vertex) => DVec3::ZERO,
                Guess::Inertia => {
                    let ahead = prediction.inertial[vertex] - implicit.x[vertex];
                    masses[vertex] / row.diagonal * (ahead + fall) - implicit.drift
                }
                Guess::Point | Guess::Downhill => -implicit.drift,
            };
            solution[vertex - part.rows.start] =
                if held[vertex] { prescribed(vertex) } else { Padded::from_f64(free.to_array()) };
        });
        let mut target = settings.target(step.start.mass, linear.gamma);
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
            rigid::correct(moves, drift, rest, point, masses);
        }
        report.solve += assembled.elapsed().saturating_sub(solved.preparation);
        Ok(())
    }
}
