//! What came out, for the reader.

use core::fmt;

use super::plugin::PluginRun;
use super::sample::{Bending, Held, Meshing, PinMotion, Sample, Start};
use super::survey::Run;
use super::trial::{Moment, Outcome};
use crate::report::{Table, figure, percent};

/// Share of the runs that may be frozen.
const MAX_FROZEN: f64 = 0.01;
/// Failed runs that are named.
const NAMED: usize = 12;

/// A kind of run: a name, and which runs are of it.
type Kind = (&'static str, fn(&Sample) -> bool);

const KINDS: [Kind; 26] = [
    ("all", |_| true),
    ("start: rest", |s| s.start == Start::Rest),
    ("start: crumpled", |s| matches!(s.start, Start::Crumpled { .. })),
    ("start: point", |s| matches!(s.start, Start::Point { .. })),
    ("start: line", |s| matches!(s.start, Start::Line { .. })),
    ("start: inverted", |s| s.start == Start::Inverted),
    ("start: stretched", |s| matches!(s.start, Start::Stretched { .. })),
    ("free", |s| s.held == Held::Free),
    ("pins still", |s| s.held != Held::Free && s.pins == PinMotion::Still),
    ("pins moving", |s| matches!(s.pins, PinMotion::Moving(_))),
    ("pins teleporting", |s| matches!(s.pins, PinMotion::Teleporting(_))),
    ("slivers", |s| matches!(s.meshing, Meshing::Slivers { .. })),
    ("graded mesh", |s| matches!(s.meshing, Meshing::Graded { .. })),
    ("anisotropy > 1000", |s| s.anisotropy > 1e3),
    ("stiffness > 1e6 N/m", |s| s.stiffness > 1e6),
    ("stiffness < 1 N/m", |s| s.stiffness < 1.0),
    ("density < 0.01 kg/m²", |s| s.density < 0.01),
    ("step > 0.1 s", |s| s.dt > 0.1),
    ("hitch of 2 s", |s| s.hitching),
    ("far from origin", |s| s.distance > 0.0),
    ("f64", |s| s.double),
    ("backward Euler", |s| s.backward_euler),
    ("BDF2", |s| !s.backward_euler),
    ("2-3 Newton steps", |s| s.newton_steps > 1),
    ("mid-edge bending", |s| s.bending_model == Bending::MidEdge),
    ("hinges", |s| s.bending_model == Bending::Hinge),
];

/// Outcomes by kind of run.
pub fn table(runs: &[Run]) -> Table {
    let mut table = Table::new("runs number ok frozen gained non-finite panic fallbacks clamps rejected worst-gain");
    for (name, is_of) in KINDS {
        let of: Vec<_> = runs.iter().filter(|run| is_of(&run.plan.sample)).map(|run| &run.verdict).collect();
        if of.is_empty() {
            continue;
        }
        let substeps: f64 = of.iter().map(|verdict| f64::from(verdict.substeps)).sum();
        let share = |count: u32| f64::from(count) / substeps;
        let outcomes = Outcome::ALL.map(|outcome| of.iter().filter(|v| v.outcome == outcome).count().to_string());
        let rest = [
            percent(share(of.iter().map(|v| v.fallbacks).sum())),
            percent(share(of.iter().map(|v| v.velocity_clamps).sum())),
            of.iter().map(|v| v.rejected).sum::<u32>().to_string(),
            percent(of.iter().map(|v| v.gain).fold(0.0, f64::max)),
        ];
        table.row([name.to_string(), of.len().to_string()].into_iter().chain(outcomes).chain(rest));
    }
    table
}

/// An empty table of steps.
pub fn steps() -> Table {
    Table::new("step dt/s kinetic/J elastic/J told/J fallen/J work/J gain iterations fallbacks clamps outcome")
}

/// Adds a step to it.
pub fn add_step(table: &mut Table, moment: &Moment) {
    let Moment { account, report, .. } = moment;
    let energies =
        [account.kinetic, account.elastic, account.told, account.fallen, account.work].map(|e| format!("{e:.4e}"));
    let before = [moment.step.to_string(), figure(moment.dt)];
    let counts = [report.iterations, report.fallbacks, report.velocity_clamps].map(|count| count.to_string());
    let outcome = format!("{:?}{}", report.outcome, if moment.frozen { ", frozen" } else { "" });
    table.row(before.into_iter().chain(energies).chain([percent(moment.gain)]).chain(counts).chain([outcome]));
}

/// What is wanted of the runs, and what came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    place: &'static str,
    runs: usize,
    pub(super) frozen: usize,
    /// Runs that ended worse than frozen, by index.
    pub(super) failed: Vec<(u64, String)>,
}

impl Wanted {
    /// Of the core: nothing worse than frozen, and little of that.
    pub fn of_core(runs: &[Run]) -> Self {
        let failed = runs.iter().filter(|run| run.verdict.outcome > Outcome::Frozen).map(|run| {
            let verdict = &run.verdict;
            let why = match verdict.outcome {
                Outcome::GainedEnergy => format!("gained {}", percent(verdict.gain)),
                outcome => format!("{} {}", outcome.name(), verdict.message.as_deref().unwrap_or_default()),
            };
            (run.plan.index, why)
        });
        let frozen = runs.iter().filter(|run| run.verdict.outcome == Outcome::Frozen).count();
        Self { place: "core", runs: runs.len(), frozen, failed: failed.collect() }
    }

    /// Of the plugin: nothing wrong, and few rejected steps.
    pub fn of_plugin(runs: &[PluginRun]) -> Self {
        let failed = runs.iter().filter_map(|run| Some((run.plan.index, run.wrong.clone()?)));
        let frozen = runs.iter().filter(|run| run.wrong.is_none() && run.verdict.rejected > 0).count();
        Self { place: "plugin", runs: runs.len(), frozen, failed: failed.collect() }
    }

    /// Whether it came out as wanted.
    pub fn is_met(&self) -> bool {
        self.failed.is_empty() && self.frozen as f64 <= MAX_FROZEN * self.runs as f64
    }
}

impl fmt::Display for Wanted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, runs, frozen, failed } = self;
        let verdict = if self.is_met() { "as wanted" } else { "MISSED" };
        let limit = percent(MAX_FROZEN);
        writeln!(
            f,
            "{place}: {runs} runs, {} failed (wanted: 0), {frozen} frozen (wanted: under {limit}): {verdict}",
            failed.len()
        )?;
        for (index, why) in failed.iter().take(NAMED) {
            writeln!(f, "  run {index}: {why}; see it with --only {index}")?;
        }
        if failed.len() > NAMED {
            writeln!(f, "  and {} more", failed.len() - NAMED)?;
        }
        Ok(())
    }
}
