//! What a row measures.

use bevy_cloth::physics::Quality;
use serde::Serialize;

use super::options::{Options, Part};
use crate::scenes::Meshing;

/// Cloths of one sheet, hung side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Case {
    /// Number of cloths.
    pub cloths: usize,
    /// Vertices along a side of each.
    pub side: u32,
    /// How they are meshed.
    pub meshing: Meshing,
    /// Threads of the pool that they are stepped in.
    pub threads: usize,
    /// How well they are solved.
    #[serde(serialize_with = "crate::quality::serialize")]
    pub quality: Quality,
}

impl Case {
    /// One cloth on one thread.
    pub const fn sheet(side: u32) -> Self {
        Self { cloths: 1, side, meshing: Meshing::Grid, threads: 1, quality: Quality::Medium }
    }

    /// A hundred cloths of 20², on one thread.
    pub const CROWD: Self = Self { cloths: 100, ..Self::sheet(20) };

    /// The sheet whose error is compared with that of others.
    pub const CONVERGED: Self = Self::sheet(50);

    /// The cases of the solver alone.
    pub fn of_solver(options: &Options) -> Vec<Self> {
        let threads = options.thread_count();
        let mut cases = Vec::new();
        for part in &options.parts {
            match part {
                Part::Sheets => cases.extend(options.sizes.iter().copied().map(Self::sheet)),
                Part::Threads => cases.extend([1, threads].map(|threads| Self { threads, ..Self::sheet(100) })),
                Part::Crowd => cases.extend([1, threads].map(|threads| Self { threads, ..Self::CROWD })),
                Part::Irregular => cases.extend(
                    [Meshing::Irregular, Meshing::Shuffled].map(|meshing| Self { meshing, ..Self::sheet(100) }),
                ),
                Part::Plugin | Part::Accuracy | Part::Terms | Part::Contact => {}
            }
        }
        without_repeats(cases, options)
    }

    /// The cases of the whole plugin.
    pub fn of_plugin(options: &Options) -> Vec<Self> {
        if !options.parts.contains(&Part::Plugin) {
            return Vec::new();
        }
        let threads = options.thread_count();
        without_repeats([Self::sheet(100), Self::CROWD, Self { threads, ..Self::CROWD }], options)
    }

    /// The cases whose accuracy is measured.
    pub fn of_accuracy(options: &Options) -> Vec<Self> {
        if !options.parts.contains(&Part::Accuracy) {
            return Vec::new();
        }
        let sheets = options.sizes.iter().copied().map(Self::sheet);
        without_repeats([Self::CONVERGED].into_iter().chain(sheets), options)
    }

    /// What the table calls it.
    pub fn name(&self) -> String {
        let sheet = match self.meshing {
            Meshing::Grid => format!("{}²", self.side),
            Meshing::Irregular => format!("{}² irregular", self.side),
            Meshing::Shuffled => format!("{}² shuffled", self.side),
        };
        if self.cloths == 1 { sheet } else { format!("{} × {sheet}", self.cloths) }
    }

    /// Vertices of all cloths together.
    pub fn vertices(&self) -> usize {
        self.cloths * (self.side * self.side) as usize
    }
}

/// Each case once, where it first stands, in the quality asked for.
fn without_repeats(cases: impl IntoIterator<Item = Case>, options: &Options) -> Vec<Case> {
    let mut unique = Vec::new();
    for case in cases.into_iter().map(|case| Case { quality: options.quality, ..case }) {
        if !unique.contains(&case) {
            unique.push(case);
        }
    }
    unique
}
