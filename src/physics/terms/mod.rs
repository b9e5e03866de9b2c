//! All that enters a step: a list of terms behind one interface.
//!
//! | term | A | b | potential | work |
//! |---|---|---|---|---|
//! | [`Inertia`] | M | M (y − x) | in Φ, see [`step`](super::step) | |
//! | [`Gravity`] | | γ² M g | −g·M (x − xₙ) | |
//! | [`AirDrag`] | γ α M | −γ α M (x − q − γ w) | | what the wind does |
//! | membrane (`assembly::triangles`) | γ² H + γ dp D | γ² f − γ dp D (x − q) | E | |
//! | bending (`assembly::hinges`) | γ² H + γ dp D | γ² f − γ dp D (x − q) | E | |
//! | contact ([`contact`](super::contact)) | stencils | stencils | of the substep only | what colliders do |
//!
//! Material damping dp is part of membrane and bending, which know D. The work of pins needs no term: potentials are
//! compared from where the pins have dragged the cloth.
//!
//! A new term is a file here (or a kind of element in [`assembly`](super::assembly)) that implements [`Term`], and one line in
//! [`System::new`](super::assembly::System::new). What calls the terms, the assembly and the safeguard, knows none by name.

mod air_drag;
pub mod gravity;
mod inertia;

use bevy::math::DVec3;

pub use self::air_drag::AirDrag;
pub use self::gravity::Gravity;
pub use self::inertia::Inertia;
use super::assembly::{ImplicitStep, Linearization, Output, Part, Places, Stencil};
use super::material::Fabric;
use super::math::Scalar;

/// What a substep starts from. Nothing of it changes while the substep is taken. All vertices are numbered as the engine does.
#[derive(Clone, Copy, Debug)]
pub struct Substep<'a> {
    /// xₙ, m.
    pub x: &'a [DVec3],
    /// vₙ, m/s.
    pub v: &'a [DVec3],
    /// By vertex: whether it is pinned.
    pub held: &'a [bool],
    /// By vertex, kg.
    pub masses: &'a [f64],
    /// Of all vertices together, kg.
    pub mass: f64,
    /// Acceleration of gravity, m/s².
    pub gravity: DVec3,
    /// Velocity of the air, m/s.
    pub wind: DVec3,
    /// Velocity of the frame that speeds are judged in, m/s: that of the pins, or of the cloth as a whole. A cloth on a train is
    /// judged as one at home.
    pub frame: DVec3,
    /// Length Δt, s.
    pub dt: f64,
    /// Where it begins and ends, as shares of the step that it is a part of.
    pub from: f64,
    /// See [`from`](Self::from).
    pub to: f64,
}

/// What a term of single vertices adds to a row of A and b.
#[derive(Clone, Copy, Debug, Default)]
pub struct Row {
    /// Times the identity, to the diagonal of A, kg.
    pub diagonal: f64,
    /// To b, for moves from the point of linearization, kg·m.
    pub b: DVec3,
}

/// Positions that stored potentials are asked for.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a, T: Scalar> {
    /// Where the vertices are.
    pub places: Places<'a, T>,
    /// The parts that sums are made by.
    pub parts: &'a [Part],
}

/// A term of the step: forces, their part of A, and where their energy comes from. All methods do nothing unless said otherwise.
///
/// A substep calls [`begin`](Self::begin), then for each linearization [`prepare`](Self::prepare) and the three that add to A and b,
/// then [`stored`](Self::stored), [`driven`](Self::driven) and [`work`](Self::work) of where it leads, then [`end`](Self::end).
pub trait Term<T: Scalar>: Send + Sync {
    /// Takes over the constants of a fabric.
    fn set_fabric(&mut self, _fabric: &Fabric) {}

    /// Before a substep: targets move, contacts are found.
    fn begin(&mut self, _substep: &Substep) {}

    /// Before each linearization, on one thread.
    fn prepare(&mut self, _at: &Linearization<T>) {}

    /// Adds what elements give to a part of A and to its forces.
    fn add_elements(&self, _at: &Linearization<T>, _out: &mut Output<T>) {}

    /// Adds what single vertices give to the rows from `first` on.
    fn add_rows(&self, _at: &ImplicitStep, _masses: &[f64], _first: usize, _rows: &mut [Row]) {}

    /// Adds forces on points of the cloth, linearized at the points of `at`.
    fn add_stencils(&mut self, _at: &[DVec3], _out: &mut Vec<Stencil>) {}

    /// Whether it holds the cloth: a translation of all of it meets a force that grows with it.
    fn holds(&self) -> bool {
        false
    }

    /// Potential of its forces that depends on positions alone, J: the next step knows it already.
    fn stored(&mut self, _at: &Trial<T>) -> f64 {
        0.0
    }

    /// Potential of its forces that depends on the substep too, of the free vertices at `x`, J.
    fn driven(&mut self, _substep: &Substep, _x: &[DVec3], _parts: &[Part]) -> f64 {
        0.0
    }

    /// Forgets hidden state of positions that have nothing to do with these.
    fn settle(&mut self, _at: &Trial<T>) {}

    /// Potential of forces that hold for this substep alone, J: in what the descent lowers, and in no account of energy.
    fn substep_potential(&self, _x: &[DVec3]) -> f64 {
        0.0
    }

    /// Work that the world did on the cloth on its way from xₙ to `x`, J: energy that a step may gain. Not what pins do.
    fn work(&self, _substep: &Substep, _x: &[DVec3]) -> f64 {
        0.0
    }

    /// After a substep that led to `x`.
    fn end(&mut self, _x: &[DVec3]) {}
}
