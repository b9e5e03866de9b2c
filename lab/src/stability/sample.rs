//! What sets one run apart from another, and how it is drawn.

use bevy_cloth::physics::{BendingModel, Fabric, Integrator, Precision, SolverSettings};
use rand::rngs::StdRng;
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use serde::Serialize;

/// Steps of a run.
pub const STEPS: u32 = 48;
/// The hitch among frames of 1/60 s, s.
const HITCH: f64 = 2.0;
/// The step that takes as long as the hitch.
const HITCH_AT: u32 = 16;
/// Side of the sheet, m.
pub const SIZE: f64 = 1.0;

/// Parameters of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// Vertices a side.
    pub side: u32,
    /// How the sheet is meshed.
    pub meshing: Meshing,
    /// kg/m².
    pub density: f32,
    /// Tensile stiffness of the stiffer yarns, N/m.
    pub stiffness: f32,
    /// How often that of the others goes into it.
    pub anisotropy: f32,
    /// Whether the weft is stiffer than the warp.
    pub stiff_weft: bool,
    /// k1/√(k0 k2).
    pub coupling: f32,
    /// Shear term k3, N/m.
    pub shear: f32,
    /// Flexural rigidity, N·m.
    pub bending: f32,
    /// Poisson's ratio of bending.
    pub bending_poisson: f32,
    /// How it bends.
    pub bending_model: Bending,
    /// Material damping, s.
    pub damping: f32,
    /// Air drag, 1/s.
    pub air_drag: f32,
    /// Length of a step, s.
    pub dt: f64,
    /// Whether one step takes 2 s.
    pub hitching: bool,
    /// How the cloth lies at the start.
    pub start: Start,
    /// How it moves there.
    pub throw: Throw,
    /// What holds it.
    pub held: Held,
    /// What the pins do.
    pub pins: PinMotion,
    /// From the origin, m.
    pub distance: f64,
    /// Whether it is solved in f64.
    pub double: bool,
    /// Whether it is integrated by backward Euler.
    pub backward_euler: bool,
    /// Implicit steps per step. Where pins move the core takes one, so that the work of the pins can be told.
    pub substeps: u32,
    /// Newton steps per substep, at most.
    pub newton_steps: u32,
    /// Seed of what is random within the run: directions.
    pub detail: u64,
}

/// How the sheet is meshed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Meshing {
    /// Squares, halved along the same diagonal.
    Even,
    /// The same with its inner vertices moved and random diagonals.
    Irregular,
    /// One row of cells is so many times lower than wide.
    Slivers {
        /// Aspect.
        aspect: f64,
    },
    /// Cells grow along both sides.
    Graded {
        /// Longest edge over shortest, along a side.
        ratio: f64,
    },
}

/// How the sheet bends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bending {
    /// [`BendingModel::MidEdge`].
    MidEdge,
    /// [`BendingModel::Hinge`].
    Hinge,
    /// [`BendingModel::None`].
    None,
}

impl From<Bending> for BendingModel {
    fn from(bending: Bending) -> Self {
        match bending {
            Bending::MidEdge => Self::MidEdge,
            Bending::Hinge => Self::Hinge,
            Bending::None => Self::None,
        }
    }
}

/// How the cloth lies at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Start {
    /// Flat, undeformed.
    Rest,
    /// Every vertex is off its place, in any direction.
    Crumpled {
        /// By so much at most, m.
        by: f64,
    },
    /// In a single point, or so nearly.
    Point {
        /// Off it, at most, m.
        noise: f64,
    },
    /// On a line, or so nearly.
    Line {
        /// Off it, at most, m.
        noise: f64,
    },
    /// Every other row of vertices runs backwards: elements lie on their backs, folded by half a turn.
    Inverted,
    /// Larger by a factor, both ways.
    Stretched {
        /// The factor.
        times: f64,
    },
}

/// Velocities at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Throw {
    /// None.
    Still,
    /// All alike, m/s.
    Thrown(f64),
    /// About the centre, so fast at the middle of an edge, m/s.
    Spun(f64),
    /// Each vertex in a direction of its own, m/s.
    Scattered(f64),
}

/// What holds the cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Held {
    /// Nothing.
    Free,
    /// Two corners.
    Corners,
    /// The edge between them.
    Edge,
}

/// What the pins do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PinMotion {
    /// Nothing: they stay where their vertices start.
    Still,
    /// They move on, all together, m/s.
    Moving(f64),
    /// Every so often each of them is elsewhere, at most so far from its start, m.
    Teleporting(f64),
}

impl Start {
    /// Names of all starts, in the order of the map.
    pub const NAMES: [&str; 6] = ["rest", "crumpled", "point", "line", "inverted", "stretched"];

    /// One of [`Self::NAMES`].
    pub fn name(&self) -> &'static str {
        Self::NAMES[match self {
            Self::Rest => 0,
            Self::Crumpled { .. } => 1,
            Self::Point { .. } => 2,
            Self::Line { .. } => 3,
            Self::Inverted => 4,
            Self::Stretched { .. } => 5,
        }]
    }

    /// The hardest of each kind, in the order of the names.
    pub const HARDEST: [Self; 6] = [
        Self::Rest,
        Self::Crumpled { by: SIZE },
        Self::Point { noise: 1e-6 },
        Self::Line { noise: 1e-6 },
        Self::Inverted,
        Self::Stretched { times: 100.0 },
    ];
}

/// A generator for one run: the same whatever other runs there are.
pub fn generator(seed: u64, index: u64) -> StdRng {
    // SplitMix64's increment keeps neighbouring runs apart.
    StdRng::seed_from_u64(seed ^ index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Even over the logarithm.
fn logarithmic(random: &mut StdRng, from: f64, to: f64) -> f64 {
    random.random_range(from.ln()..=to.ln()).exp()
}

/// Zero now and then, else even over the logarithm.
fn zero_or(random: &mut StdRng, zero: f64, from: f64, to: f64) -> f64 {
    if random.random_bool(zero) { 0.0 } else { logarithmic(random, from, to) }
}

impl Sample {
    /// Drawn at random over all extremes.
    pub fn random(random: &mut StdRng) -> Self {
        let side = if random.random_bool(0.005) { 30 } else { random.random_range(5..=12) };
        let stiffness = logarithmic(random, 1e-3, 1e9);
        let hitching = random.random_bool(0.1);
        let held = *[Held::Free, Held::Corners, Held::Edge].choose(random).expect("not empty");
        let noise = zero_or(random, 0.5, 1e-9, 1e-3);
        let speed = logarithmic(random, 0.1, 1000.0);
        Self {
            side,
            meshing: match random.random_range(0..4) {
                0 => Meshing::Even,
                1 => Meshing::Irregular,
                2 => Meshing::Slivers { aspect: logarithmic(random, 10.0, 1e4) },
                _ => Meshing::Graded { ratio: logarithmic(random, 10.0, 1e3) },
            },
            density: logarithmic(random, 1e-4, 1e2) as f32,
            stiffness: stiffness as f32,
            anisotropy: if random.random() { 1.0 } else { logarithmic(random, 1.0, 1e6) as f32 },
            stiff_weft: random.random(),
            coupling: *[0.0, 0.3, -0.5, 0.99].choose(random).expect("not empty"),
            shear: (stiffness * logarithmic(random, 1e-4, 1.0)) as f32,
            bending: zero_or(random, 0.2, 1e-9, 1.0) as f32,
            bending_poisson: *[0.0, 0.3, -0.5, 0.99].choose(random).expect("not empty"),
            bending_model: match random.random_range(0..8) {
                0..=4 => Bending::MidEdge,
                5 | 6 => Bending::Hinge,
                _ => Bending::None,
            },
            damping: zero_or(random, 0.3, 1e-4, 10.0) as f32,
            air_drag: *[0.0, 1.0, 10.0].choose(random).expect("not empty"),
            dt: if hitching { 1.0 / 60.0 } else { logarithmic(random, 1e-3, 1.0) },
            hitching,
            start: match random.random_range(0..6) {
                0 => Start::Rest,
                1 => Start::Crumpled { by: logarithmic(random, 1e-3, 3.0) },
                2 => Start::Point { noise },
                3 => Start::Line { noise },
                4 => Start::Inverted,
                _ => Start::Stretched { times: logarithmic(random, 1.1, 100.0) },
            },
            throw: match random.random_range(0..6) {
                0..=2 => Throw::Still,
                3 => Throw::Thrown(speed),
                4 => Throw::Spun(speed),
                _ => Throw::Scattered(speed),
            },
            held,
            pins: match random.random_range(0..4) {
                0 if held != Held::Free => PinMotion::Moving(logarithmic(random, 1.0, 100.0)),
                1 if held != Held::Free => PinMotion::Teleporting(logarithmic(random, 0.1, 100.0)),
                _ => PinMotion::Still,
            },
            distance: if random.random_bool(0.25) { 1e5 } else { 0.0 },
            double: random.random_bool(0.1),
            backward_euler: random.random(),
            substeps: if random.random() { 1 } else { random.random_range(2..=4) },
            newton_steps: if random.random_bool(0.75) { 1 } else { random.random_range(2..=3) },
            detail: random.random(),
        }
    }

    /// An ordinary fabric but for its stiffness, hung by two corners, undamped, from the hardest start of a kind.
    pub fn plain(start: Start, dt: f64, stiffness: f64, backward_euler: bool, detail: u64) -> Self {
        Self {
            side: 8,
            meshing: Meshing::Irregular,
            density: 0.15,
            stiffness: stiffness as f32,
            anisotropy: 1.0,
            stiff_weft: false,
            coupling: 0.3,
            shear: (0.1 * stiffness) as f32,
            bending: 1e-5,
            bending_poisson: 0.3,
            bending_model: Bending::MidEdge,
            damping: 0.0,
            air_drag: 0.0,
            dt,
            hitching: false,
            start,
            throw: Throw::Still,
            held: Held::Corners,
            pins: PinMotion::Still,
            distance: 0.0,
            double: false,
            backward_euler,
            substeps: 1,
            newton_steps: 1,
            detail,
        }
    }

    /// The fabric.
    pub fn fabric(&self) -> Fabric {
        let (stiff, soft) = (self.stiffness, self.stiffness / self.anisotropy);
        let [warp_stiffness, weft_stiffness] = if self.stiff_weft { [soft, stiff] } else { [stiff, soft] };
        Fabric {
            density: self.density,
            warp_stiffness,
            weft_stiffness,
            coupling: self.coupling * (f64::from(stiff) * f64::from(soft)).sqrt() as f32,
            shear_stiffness: self.shear,
            warp_bending: self.bending,
            weft_bending: self.bending,
            bias_bending: self.bending,
            bending_poisson: self.bending_poisson,
            damping: self.damping,
            air_drag: self.air_drag,
        }
    }

    /// The settings, with all the substeps.
    pub fn settings(&self) -> SolverSettings {
        SolverSettings {
            integrator: if self.backward_euler { Integrator::BackwardEuler } else { Integrator::Bdf2 },
            precision: if self.double { Precision::Double } else { Precision::Single },
            substeps: self.substeps,
            newton_steps: self.newton_steps,
            ..Default::default()
        }
    }

    /// Length of a step, s.
    pub fn dt_of(&self, step: u32) -> f64 {
        if self.hitching && step == HITCH_AT { HITCH } else { self.dt }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_drawn_the_same_whatever_others_there_are() {
        let draw = |seed, index| Sample::random(&mut generator(seed, index));
        assert_eq!(draw(1, 7), draw(1, 7));
        assert_ne!(draw(1, 7), draw(1, 8));
        assert_ne!(draw(1, 7), draw(2, 7));
    }

    #[test]
    fn every_extreme_is_drawn_and_every_fabric_is_valid() {
        let samples: Vec<_> = (0..4000).map(|index| Sample::random(&mut generator(0, index))).collect();
        let range = |value: fn(&Sample) -> f64| {
            let values = samples.iter().map(value);
            (values.clone().fold(f64::MAX, f64::min), values.fold(f64::MIN, f64::max))
        };
        assert!(matches!(range(|s| s.dt), (1e-3..1.1e-3, 0.9..1.0001)));
        assert!(matches!(range(|s| s.stiffness.into()), (0.9e-3..1.2e-3, 0.8e9..1.001e9)));
        assert!(matches!(range(|s| s.anisotropy.into()), (1.0, 0.9e6..1.001e6)));
        assert!(matches!(range(|s| s.density.into()), (0.9e-4..1.1e-4, 90.0..100.1)));
        assert!(matches!(range(|s| s.damping.into()), (0.0, 9.0..10.1)));
        assert!(matches!(range(|s| s.bending.into()), (0.0, 0.9..1.01)));
        for name in Start::NAMES {
            assert!(samples.iter().filter(|s| s.start.name() == name).count() > 500, "{name}");
        }
        for sample in &samples {
            sample.fabric().validate().unwrap_or_else(|error| panic!("{error}: {sample:?}"));
        }
        assert_eq!(Start::HARDEST.map(|start| start.name()), Start::NAMES);
    }

    #[test]
    fn one_frame_hitches() {
        let mut sample = Sample::plain(Start::Rest, 0.01, 1.0, false, 0);
        let time = |sample: &Sample| (0..STEPS).map(|step| sample.dt_of(step)).sum::<f64>();
        assert!((time(&sample) - 0.48).abs() < 1e-9);
        sample.hitching = true;
        assert!((time(&sample) - 2.47).abs() < 1e-9);
    }
}
