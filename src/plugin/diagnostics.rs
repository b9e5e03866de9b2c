//! Figures about the cloths of an app.

use core::time::Duration;

use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::prelude::*;

use super::ClothSystems;
use super::budget::{ClothBudget, ClothBudgetReport};
use super::state::ClothState;
use crate::physics::StepReport;

/// Adds the diagnostics named by its constants: sums over all cloths that were stepped last, once per frame in which
/// there was a step; and those of a [`ClothBudget`](super::ClothBudget), if there is one. Costs nothing unless added.
#[derive(Default)]
pub struct ClothDiagnosticsPlugin;

impl ClothDiagnosticsPlugin {
    /// Time of the step, all of it, ms. (Of all cloths together: they run side by side, so the wall-clock time is less.)
    pub const STEP: DiagnosticPath = DiagnosticPath::const_new("cloth/step_ms");
    /// Time to assemble the linear systems, ms.
    pub const ASSEMBLY: DiagnosticPath = DiagnosticPath::const_new("cloth/assembly_ms");
    /// Time to solve them, ms.
    pub const SOLVE: DiagnosticPath = DiagnosticPath::const_new("cloth/solve_ms");
    /// Iterations of the solvers.
    pub const ITERATIONS: DiagnosticPath = DiagnosticPath::const_new("cloth/iterations");
    /// Steps that failed the energy check and were taken again by the fallback.
    pub const FALLBACKS: DiagnosticPath = DiagnosticPath::const_new("cloth/fallbacks");
    /// Number of cloths stepped.
    pub const CLOTHS: DiagnosticPath = DiagnosticPath::const_new("cloth/cloths");
    /// Number of their simulated vertices.
    pub const VERTICES: DiagnosticPath = DiagnosticPath::const_new("cloth/vertices");
    /// [`ClothBudgetReport::requested_ms`].
    pub const BUDGET_REQUESTED: DiagnosticPath = DiagnosticPath::const_new("cloth/budget_requested_ms");
    /// [`ClothBudgetReport::predicted_ms`].
    pub const BUDGET_PREDICTED: DiagnosticPath = DiagnosticPath::const_new("cloth/budget_predicted_ms");
    /// [`ClothBudgetReport::measured_ms`].
    pub const BUDGET_MEASURED: DiagnosticPath = DiagnosticPath::const_new("cloth/budget_measured_ms");
    /// [`ClothBudgetReport::lowered`].
    pub const BUDGET_LOWERED: DiagnosticPath = DiagnosticPath::const_new("cloth/budget_lowered");
}

impl Plugin for ClothDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        let budget = [Self::BUDGET_REQUESTED, Self::BUDGET_PREDICTED, Self::BUDGET_MEASURED];
        for path in [Self::STEP, Self::ASSEMBLY, Self::SOLVE].into_iter().chain(budget) {
            app.register_diagnostic(Diagnostic::new(path).with_suffix(" ms"));
        }
        for path in [Self::ITERATIONS, Self::FALLBACKS, Self::CLOTHS, Self::VERTICES, Self::BUDGET_LOWERED] {
            app.register_diagnostic(Diagnostic::new(path));
        }
        app.add_systems(
            PostUpdate,
            (measure, measure_budget.run_if(resource_exists::<ClothBudget>)).chain().after(ClothSystems::WriteBack),
        );
    }
}

fn measure(mut diagnostics: Diagnostics, cloths: Query<&ClothState>, mut steps_before: Local<u64>) {
    // Revisions count steps (and resets, which do no harm here): without a new one there is nothing to measure.
    let steps = cloths.iter().map(|state| state.revision).sum();
    if core::mem::replace(&mut *steps_before, steps) == steps {
        return;
    }
    let stepped = || cloths.iter().filter_map(|state| Some((state.report_of_this_tick()?, state)));
    let sum = |value: fn(&StepReport) -> Duration| {
        stepped().map(|(report, _)| value(&report)).sum::<Duration>().as_secs_f64() * 1e3
    };
    diagnostics.add_measurement(&ClothDiagnosticsPlugin::STEP, || sum(|report| report.total));
    diagnostics.add_measurement(&ClothDiagnosticsPlugin::ASSEMBLY, || sum(|report| report.assembly));
    diagnostics.add_measurement(&ClothDiagnosticsPlugin::SOLVE, || sum(|report| report.preconditioner + report.solve));
    diagnostics.add_measurement(&ClothDiagnosticsPlugin::ITERATIONS, || {
        stepped().map(|(report, _)| f64::from(report.iterations)).sum()
    });
    diagnostics.add_measurement(&ClothDiagnosticsPlugin::FALLBACKS, || {
        stepped().map(|(report, _)| f64::from(report.fallbacks)).sum()
    });
    diagnostics.add_measurement(&ClothDiagnosticsPlugin::CLOTHS, || stepped().count() as f64);
    diagnostics.add_measurement(&ClothDiagnosticsPlugin::VERTICES, || {
        stepped().map(|(_, state)| state.cloth.shape().vertex_count() as f64).sum()
    });
}

fn measure_budget(mut diagnostics: Diagnostics, report: Res<ClothBudgetReport>) {
    type Plugin = ClothDiagnosticsPlugin;
    diagnostics.add_measurement(&Plugin::BUDGET_REQUESTED, || report.requested_ms.into());
    diagnostics.add_measurement(&Plugin::BUDGET_PREDICTED, || report.predicted_ms.into());
    diagnostics.add_measurement(&Plugin::BUDGET_MEASURED, || report.measured_ms.into());
    diagnostics.add_measurement(&Plugin::BUDGET_LOWERED, || report.lowered as f64);
}
