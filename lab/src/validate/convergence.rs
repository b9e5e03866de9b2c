//! How fast errors fall when mesh and step are refined.

use bevy_cloth::physics::{Cloth, Integrator, SolverSettings};

use super::Row;
use super::bending::drop;
use super::hanging::sag;
use super::strip::{Pattern, exact, run};
use crate::scenes::{DT, Meshing, Sheet};

/// Orders of convergence: 2 in the size of the cells, and what the integrators have in the length of the step.
pub fn convergence() -> Vec<Row> {
    // From three sizes, each half the one before: the answer itself need not be known.
    let order = |[coarse, middle, fine]: [f64; 3]| ((coarse - middle) / (middle - fine)).abs().log2();
    let bending = order([10, 20, 40].map(|cells| drop(Pattern::OneDiagonal, 10.0, cells)));
    let hanging = order([10, 20, 40].map(|cells| sag(1.5, cells, exact())));
    let mut rows = vec![
        Row::absolute("order in space", "cantilever, Γ 10", 2.0, bending, 0.5),
        Row::absolute("order in space", "catenary, length/span 1.5", 2.0, hanging, 0.5),
    ];
    for (integrator, name, expected) in [(Integrator::BackwardEuler, "BE", 1.0), (Integrator::Bdf2, "BDF2", 2.0)] {
        let reference = swung(SolverSettings { substeps: 128, ..exact() });
        let [coarse, fine] = [8, 16].map(|substeps| {
            let settings = SolverSettings { integrator, substeps, ..exact() };
            distance(&swung(settings), &reference)
        });
        let parameters = format!("{name}, hung sheet, 1/480 to 1/960 s");
        rows.push(Row::absolute("order in time", parameters, expected, (coarse / fine).log2(), 0.4));
    }
    rows
}

/// A coarse sheet after a quarter of a second.
fn swung(settings: SolverSettings) -> Cloth {
    let mut cloth = Sheet::new(9, Meshing::Grid).hang(settings);
    run(&mut cloth, DT, 0.25);
    cloth
}

/// Root mean square, m.
fn distance(a: &Cloth, b: &Cloth) -> f64 {
    let squares = a.positions().iter().zip(b.positions()).map(|(a, b)| a.distance_squared(*b));
    (squares.sum::<f64>() / a.positions().len() as f64).sqrt()
}
