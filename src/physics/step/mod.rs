//! A substep of the implicit step, in order:
//!
//! 1. **Plan**: how many substeps the step is taken in, and how each is integrated ([`plan`]).
//! 2. **Budget**: what energy the cloth has, and may gain ([`acceptance`]).
//! 3. **Begin the terms**: targets move, contacts are found ([`terms`], [`contact`](super::contact)).
//! 4. **Predict**: where inertia leads, and where to linearize ([`prediction`]).
//! 5. **Linearize and solve** A d = b, again where contact was wrong ([`newton`]).
//! 6. **Finish**: the state that the moves lead to ([`prediction`]).
//! 7. **Recover**: what ended inside a collider is moved out ([`contact`](super::contact)).
//! 8. **Accept** it if it gained no energy ([`acceptance`]), or **descend** from where it began ([`descent`]).
//! 9. **End**: terms remember, and the states trade places.
//!
//! [`Stepper::step`] is that list. Each stage returns a value; what they keep from substep to substep is the [`History`], the
//! [`Account`], and what terms remember.

mod acceptance;
mod descent;
mod engine;
mod integrator;
mod lifecycle;
mod newton;
mod pins;
mod plan;
mod prediction;
mod rigid;
mod state;
mod substep;
mod terms;

use bevy::platform::time::Instant;

use self::acceptance::{Account, kinetic};
use self::descent::Descent;
pub(super) use self::engine::{Engine, new};
pub use self::integrator::Integrator;
use self::newton::{Iterate, Newton};
pub(super) use self::pins::Pins;
pub(super) use self::plan::Impact;
use self::plan::{LEAP, Plan};
use self::prediction::Prediction;
pub(super) use self::state::{History, State};
pub(super) use self::substep::{Step, World};
use self::terms::Terms;
use super::assembly::{Ordering, System};
use super::cloth::{ClothFault, SolverSettings, StepReport};
use super::material::Fabric;
use super::math::Scalar;
use super::mesh::RestShape;
use super::solve::solver;

/// A cloth that touches something and is slower than this against it, m/s, settles: it is linearized further back.
const SETTLING_SPEED: f64 = 0.1;

/// What takes the substeps of a cloth, in one precision.
struct Stepper<T: Scalar> {
    terms: Terms<T>,
    newton: Newton<T>,
    history: History,
    account: Account,
    impact: Impact,
    /// The state that the last substep led to.
    next: State,
    memory: Memory,
}

/// Memory of values that each substep makes anew: so that it allocates nothing.
#[derive(Default)]
struct Memory {
    prediction: Prediction,
    iterate: Iterate,
}

impl<T: Scalar> Stepper<T> {
    fn new(shape: &RestShape, fabric: &Fabric, settings: &SolverSettings, ordering: &Ordering) -> Self {
        let system = System::new(shape, fabric, ordering);
        let count = shape.vertex_count();
        let solver = solver(settings.kind, system.matrix.pattern());
        Self {
            newton: Newton::new(solver, *settings, fabric.damping.into(), count),
            terms: Terms { system, contact: terms::contact(shape, fabric, ordering) },
            history: History { state: State::zero(count), dt: None, changed: false },
            account: Account::default(),
            impact: Impact::NONE,
            next: State::zero(count),
            memory: Memory::default(),
        }
    }

    /// Substeps that a step should be taken in, as fast as things come in.
    fn pieces(&mut self, step: &Step) -> u32 {
        let leap = LEAP * self.terms.contact.longest_side();
        let shear = self.terms.contact.shear(&step.around, &step.start, leap);
        self.impact = self.impact.next(shear / leap);
        self.impact.pieces()
    }

    /// Takes a substep; [`next`](Self::next) is where it leads.
    fn step(&mut self, step: &Step, report: &mut StepReport) -> Result<(), ClothFault> {
        let Self { terms, newton, history, account, impact, next, memory } = self;
        let Memory { prediction, iterate } = core::mem::take(memory);

        // 2. Budget: first, as a solve changes the turns of mid-edge normals, and with them the energy.
        let mut dragged = iterate;
        let budget = account.open(terms, step, &mut dragged.point);
        let start = &step.start;

        // 3. Begin the terms.
        let finding = Instant::now();
        terms.begin(step);
        report.contact += finding.elapsed();
        let touching = !terms.contact.is_empty();

        // 1. and 4. Plan and predict.
        let plan = Plan::new(&newton.settings, history, start.dt, touching);
        let slow = 0.5 * SETTLING_SPEED * SETTLING_SPEED * start.mass;
        let surface = terms.contact.surface_velocity(start);
        let settling_on = surface.filter(|&surface| kinetic(terms.parts(), step, surface, start.v) < slow);
        let mut prediction = Prediction::new(prediction, plan.scheme, settling_on, step, history, terms.parts());
        if touching {
            prediction.start_touching(&terms.contact, plan.scheme.linear(start.dt).gamma, step);
        }

        // 5. Linearize and solve.
        let mut iterate = Iterate::new(dragged, &prediction.point);
        let solved = newton.run(terms, plan, (&mut prediction, &mut iterate), step, report);

        // 6. to 8. Finish, recover, accept.
        let accepted = solved.ok().and_then(|()| {
            let free = !step.pins.any() && !touching && !terms.hold();
            prediction.finish(next, plan.scheme, &iterate, free, step, terms.parts());
            let rescues = terms.contact.guard(&step.around, start, &mut next.positions, &mut next.velocities);
            account.accept(budget, terms, next, step, report).map(|stored| (stored, rescues))
        });
        history.changed = plan.changed;
        history.dt = accepted.map(|_| start.dt);
        let taken = match accepted {
            Some(accepted) => Ok(accepted),
            None => {
                report.fallbacks += 1;
                // Where the step would have led must not be in the energy it started with.
                terms.system.settle(start.x);
                account.stored = None;
                let budget = account.open(terms, step, &mut iterate.point);
                let (prediction, iterate) = (&mut prediction, &mut iterate);
                Descent { terms, newton, step, prediction, iterate, candidate: next }.run(budget, account, report)
            }
        };
        *memory = Memory { prediction, iterate };

        // 9. End.
        let (stored, rescues) = taken?;
        account.stored = Some(stored);
        impact.rescues += rescues;
        report.rescues += rescues;
        terms.end(step, &next.positions);
        Ok(())
    }
}
