//! What each optional term of the model costs: a frame with it against a frame without.

use std::time::Duration;

use bevy_cloth::physics::{BendingModel, Cloth, Fabric, SolverSettings};
use cpu_time::ProcessTime;
use indicatif::ProgressBar;
use serde::Serialize;

use super::statistics::median;
use crate::report::{Table, figure};
use crate::scenes::{DT, Meshing, Sheet, fabric};

/// A model of a cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Term {
    /// Membrane and inertia alone.
    Membrane,
    /// And hinges.
    Hinges,
    /// And mid-edge normals instead.
    MidEdges,
    /// And material damping.
    Damping,
    /// And drag of the air: as the other rows of the bench are.
    AirDrag,
    /// All that in a fabric of other stiffness along warp, weft and bias.
    Orthotropy,
    /// All that with an edge pinned instead of two corners.
    PinnedEdge,
    /// All that without any pin.
    Free,
}

impl Term {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Membrane,
        Self::Hinges,
        Self::MidEdges,
        Self::Damping,
        Self::AirDrag,
        Self::Orthotropy,
        Self::PinnedEdge,
        Self::Free,
    ];

    /// What it is compared with.
    fn without(self) -> Option<Self> {
        match self {
            Self::Membrane => None,
            Self::Hinges | Self::MidEdges => Some(Self::Membrane),
            Self::Damping => Some(Self::MidEdges),
            Self::AirDrag => Some(Self::Damping),
            Self::Orthotropy | Self::PinnedEdge | Self::Free => Some(Self::AirDrag),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Membrane => "membrane, inertia, two pins",
            Self::Hinges => "+ hinges",
            Self::MidEdges => "+ mid-edge normals",
            Self::Damping => "  + material damping",
            Self::AirDrag => "    + air drag",
            Self::Orthotropy => "      + warp, weft and bias differ",
            Self::PinnedEdge => "      + a pinned edge",
            Self::Free => "      − pins",
        }
    }

    fn cloth(self, sheet: &Sheet, settings: SolverSettings) -> Cloth {
        let bending = match self {
            Self::Membrane => BendingModel::None,
            Self::Hinges => BendingModel::Hinge,
            _ => BendingModel::MidEdge,
        };
        let undamped = fabric().undamped();
        let fabric = match self {
            Self::Membrane | Self::Hinges | Self::MidEdges => undamped,
            Self::Damping => Fabric { damping: fabric().damping, ..undamped },
            Self::Orthotropy => {
                let [warp_bending, weft_bending, bias_bending] = [3e-5, 1e-5, 1.5e-5];
                Fabric {
                    weft_stiffness: 700.0,
                    shear_stiffness: 200.0,
                    warp_bending,
                    weft_bending,
                    bias_bending,
                    ..fabric()
                }
            }
            Self::AirDrag | Self::PinnedEdge | Self::Free => fabric(),
        };
        let mut cloth = Cloth::new(sheet.shape(bending), fabric, settings).expect("the fabric is valid");
        let held: Vec<_> = match self {
            Self::Free => Vec::new(),
            Self::PinnedEdge => sheet.vertices(&cloth, |x| x.z == 0.0),
            _ => sheet.vertices(&cloth, |x| x.z == 0.0 && (x.x == 0.0 || x.x == 1.0)),
        };
        for vertex in held {
            cloth.pin(vertex, cloth.positions()[vertex as usize]);
        }
        cloth
    }
}

/// Cost of a model.
#[derive(Clone, Debug, Serialize)]
pub struct TermRow {
    /// The model.
    pub term: Term,
    /// Vertices along a side of the sheet.
    pub side: u32,
    /// Median processor time of a frame, ms.
    pub cpu_ms: f64,
    /// That over the same of the model it is compared with.
    pub ratio: Option<f64>,
    /// Mean solver iterations of a frame.
    pub iterations: f64,
}

/// Runs all models of a sheet in turns, frame by frame, so that they find the machine in the same state. Of `repeat` runs the
/// least time of each frame counts.
pub fn measure(side: u32, settings: SolverSettings, frames: u32, repeat: u32, progress: &ProgressBar) -> Vec<TermRow> {
    let sheet = Sheet::new(side, Meshing::Grid);
    let mut times = vec![[Duration::MAX; Term::ALL.len()]; frames as usize];
    let mut iterations = [0; Term::ALL.len()];
    for run in 0..repeat {
        let mut cloths = Term::ALL.map(|term| term.cloth(&sheet, settings));
        for times in &mut times {
            for ((cloth, time), iterations) in cloths.iter_mut().zip(times).zip(&mut iterations) {
                let start = ProcessTime::now();
                let report = cloth.step(DT);
                *time = (*time).min(start.elapsed());
                *iterations += if run == 0 { report.iterations } else { 0 };
            }
            progress.inc(1);
        }
    }
    let which = |term: Term| Term::ALL.iter().position(|other| *other == term).expect("all are measured");
    let ms = |term: Term| median(&times.iter().map(|times| times[which(term)]).collect::<Vec<_>>());
    let row = |term: Term| TermRow {
        term,
        side,
        cpu_ms: ms(term),
        ratio: term.without().map(|other| ms(term) / ms(other)),
        iterations: f64::from(iterations[which(term)]) / f64::from(frames),
    };
    Term::ALL.into_iter().map(row).collect()
}

/// The rows for the reader.
pub fn table(rows: &[TermRow]) -> Table {
    let mut table = Table::new("model vertices CPU-ms iterations against-without");
    for row in rows {
        table.row([
            row.term.name().into(),
            (row.side * row.side).to_string(),
            figure(row.cpu_ms),
            figure(row.iterations),
            row.ratio.map_or("–".into(), |ratio| format!("{:+.1} %", 100.0 * (ratio - 1.0))),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_is_another_and_is_compared_with_one_that_is_measured() {
        let rows = measure(8, SolverSettings::default(), 4, 2, &ProgressBar::hidden());
        assert_eq!(rows.len(), Term::ALL.len());
        assert!(rows.iter().all(|row| row.cpu_ms > 0.0 && row.iterations > 0.0), "{rows:?}");
        assert_eq!(rows.iter().filter(|row| row.ratio.is_none()).count(), 1);
        assert_eq!(table(&rows).to_string().lines().count(), 9);
    }
}
