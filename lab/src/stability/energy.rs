//! Whether a cloth gains energy, told in f64 from its states alone, without what the solver says of itself.
//!
//! What a cloth has, kinetic and elastic energy, must not exceed what it had in any earlier state and was given since: what
//! gravity did as it fell, and the work of its pins, up to a share of all that was in play since. Damping, drag and the
//! integrator only take away. Pins that move in a step of Δt do at most the work `E(xₙ with the pins moved) − E(xₙ)`, as if
//! they moved at once and the cloth followed (it is what the step of backward Euler is measured by: see `cloth/safeguard.rs`
//! in the library).
//!
//! Elastic energy is not quite a function of the positions: the turns of mid-edge normals lag behind, and hold energy until
//! they have settled, so it is told twice, settled in f64 and as the library has it, and only a gain that both show is one. And a
//! triangle that is collapsed to a line has no angle with its neighbours: there any energy of bending may be.

use core::f64::consts::PI;

use bevy::math::DVec3;
use bevy_cloth::physics::mesh::Hinge;
use bevy_cloth::physics::{Cloth, Precision, PreconditionerKind, SolverKind, SolverSettings};
use serde::Serialize;

/// Share of the energy in play that may be gained over any number of steps. The safeguard of the library allows 5 % of what
/// there is by then, which is up to 1/0.95 of what there was; the rest is rounding.
pub const TOLERANCE: f64 = 0.055;

/// Height of a triangle over its longest side, below which f32 cannot tell how it lies: an angle is then off by a hundredth.
const THIN: f64 = 1e-5;

/// Energies of the free vertices after a step, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Account {
    /// Kinetic.
    pub kinetic: f64,
    /// Elastic, in f64 and with all turns of mid-edge normals settled.
    pub elastic: f64,
    /// Elastic, as the library has it.
    pub told: f64,
    /// The most that bending may have at collapsed triangles, which have no angle.
    pub unclear: f64,
    /// What gravity has done since the start.
    pub fallen: f64,
    /// What the pins have done since the start, at most.
    pub work: f64,
    /// The same, with what they took back counted as given.
    pub worked: f64,
    /// What gravity gives to a cloth at rest in the longest step so far.
    pub fall: f64,
}

impl Account {
    /// What the cloth has, at least.
    fn least(&self) -> f64 {
        self.kinetic + (self.elastic.min(self.told) - self.unclear).max(0.0)
    }

    /// What it has, at most.
    fn most(&self) -> f64 {
        self.kinetic + self.elastic.max(self.told) + self.unclear
    }

    /// What it has at least beyond what it was given at most since `before`, as a share of what was in play since.
    fn gain_since(&self, before: &Self, deepest: f64) -> f64 {
        let given = before.most() + self.work - before.work + self.fallen - before.fallen;
        let in_play = before.most() + self.worked - before.worked + deepest - before.fallen + self.fall;
        (self.least() - given) / in_play
    }
}

/// Keeps account of a cloth step by step.
pub struct Accountant {
    /// Measures elastic energy in f64.
    twin: Cloth,
    free: Vec<u32>,
    mass: f64,
    start: Vec<DVec3>,
    history: Vec<Account>,
}

impl Accountant {
    /// For a cloth at its start, of which these vertices are free.
    pub fn new(cloth: &Cloth, free: Vec<u32>) -> Self {
        let kind = SolverKind::ConjugateGradient {
            tolerance: 0.0,
            relative_tolerance: 0.0,
            max_iterations: 1,
            preconditioner: PreconditionerKind::BlockJacobi,
        };
        let settings = SolverSettings { kind, precision: Precision::Double, ..Default::default() };
        let twin = Cloth::new(cloth.shape().clone(), *cloth.fabric(), settings).expect("the fabric is valid");
        let (mass, start) = (cloth.masses().iter().sum(), cloth.positions().to_vec());
        let mut accountant = Self { twin, free, mass, start, history: Vec::new() };
        let (kinetic, elastic) = (accountant.kinetic(cloth), accountant.elastic(cloth.positions()));
        let unclear = accountant.unclear(cloth.positions());
        accountant.history.push(Account { kinetic, elastic, told: told(cloth), unclear, ..Default::default() });
        accountant
    }

    fn elastic(&mut self, positions: &[DVec3]) -> f64 {
        self.twin.set_state(positions, &vec![DVec3::ZERO; positions.len()]);
        told(&self.twin)
    }

    /// The most that bending may have at triangles so thin that f32 cannot tell how they lie, J.
    fn unclear(&self, x: &[DVec3]) -> f64 {
        let (shape, fabric) = (self.twin.shape(), self.twin.fabric());
        let is_unclear = |hinge: &&Hinge| {
            let [a, b, c, d] = hinge.vertices.map(|v| x[v as usize]);
            let thin = |opposite: DVec3| {
                let longest = (b - a).length().max((opposite - a).length()).max((opposite - b).length());
                (b - a).cross(opposite - a).length() <= THIN * longest * longest
            };
            thin(c) || thin(d)
        };
        // Three times as much as a hinge folded by half a turn: mid-edge normals may make it stiffer by as much.
        let most = |hinge: &Hinge| fabric.bending_along(hinge.direction) * hinge.length / hinge.height * PI * PI;
        shape.bending_hinges().iter().filter(is_unclear).map(most).sum()
    }

    fn kinetic(&self, cloth: &Cloth) -> f64 {
        let (masses, velocities) = (cloth.masses(), cloth.velocities());
        self.free.iter().map(|&v| 0.5 * masses[v as usize] * velocities[v as usize].length_squared()).sum()
    }

    fn last(&self) -> &Account {
        self.history.last().expect("the start is there")
    }

    /// Bounds the work that the pins of the cloth will do in the step from here, J.
    pub fn work_of_pins(&mut self, cloth: &Cloth) -> f64 {
        let mut moved = cloth.positions().to_vec();
        for (vertex, target) in cloth.pinned() {
            moved[vertex as usize] = target;
        }
        let now = self.last().elastic.min(self.last().told);
        if moved == cloth.positions() { 0.0 } else { self.elastic(&moved) - now }
    }

    /// The account after a step of `dt` (s) in which pins did so much work (J).
    pub fn after(&mut self, cloth: &Cloth, dt: f64, work: f64) -> Account {
        let (x, masses, gravity) = (cloth.positions(), cloth.masses(), cloth.gravity());
        let weight = |v: usize| masses[v] * gravity.dot(x[v] - self.start[v]);
        let fallen = self.free.iter().map(|&v| weight(v as usize)).sum();
        let before = *self.last();
        let account = Account {
            kinetic: self.kinetic(cloth),
            elastic: self.elastic(x),
            told: told(cloth),
            unclear: self.unclear(x),
            fallen,
            work: before.work + work,
            worked: before.worked + work.abs(),
            fall: before.fall.max(self.mass * gravity.length_squared() * dt * dt),
        };
        self.history.push(account);
        account
    }

    /// What the cloth has now beyond what it was given since any earlier state, as a share of what was in play since: since
    /// the state for which that is most.
    pub fn gain(&self) -> f64 {
        let now = self.last();
        let mut deepest = now.fallen;
        let gains = self.history.iter().rev().skip(1).map(|before| {
            deepest = deepest.max(before.fallen);
            now.gain_since(before, deepest)
        });
        gains.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Elastic energy, as the library has it, J.
fn told(cloth: &Cloth) -> f64 {
    let energy = cloth.energy();
    energy.membrane + energy.bending
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::sample::{Held, Meshing, PinMotion, Sample, Start, Throw};
    use crate::stability::scene::Scene;

    fn scene(sample: &Sample) -> (Cloth, Accountant) {
        let scene = Scene::new(sample);
        let cloth = scene.cloth(sample);
        let accountant = Accountant::new(&cloth, scene.free());
        (cloth, accountant)
    }

    fn stretched() -> Sample {
        let start = Start::Stretched { times: 2.0 };
        Sample { coupling: 0.0, meshing: Meshing::Even, ..Sample::plain(start, 0.01, 100.0, false, 3) }
    }

    #[test]
    fn elastic_energy_is_that_of_the_formula() {
        // Twice as large both ways: ε = 3/2, so ½ k0 ε² + ½ k2 ε² = 225 J/m²; nothing is bent or sheared.
        let (_, accountant) = scene(&stretched());
        assert!((accountant.history[0].most() - 225.0).abs() < 1e-4, "{:?}", accountant.history);
    }

    #[test]
    fn energy_from_nowhere_is_seen_and_that_from_gravity_is_not() {
        let sample = Sample { held: Held::Free, start: Start::Rest, ..stretched() };
        let (mut cloth, mut accountant) = scene(&sample);
        let down = |by: f64| Scene::new(&sample).positions.iter().map(|&x| x - DVec3::Y * by).collect::<Vec<_>>();
        let speed = (2.0 * 9.81 * 2.0_f64).sqrt();
        cloth.set_state(&down(2.0), &vec![DVec3::new(0.0, -speed, 0.0); 64]);
        accountant.after(&cloth, 0.01, 0.0);
        assert!(accountant.gain().abs() < 1e-9);
        cloth.set_state(&down(2.0), &vec![DVec3::new(0.0, -1.1 * speed, 0.0); 64]);
        accountant.after(&cloth, 0.01, 0.0);
        let gain = accountant.gain();
        assert!((gain - 0.21).abs() < 1e-3, "{gain}");
    }

    #[test]
    fn pins_may_do_work() {
        let sample = Sample { pins: PinMotion::Moving(1.0), throw: Throw::Still, start: Start::Rest, ..stretched() };
        let (mut cloth, mut accountant) = scene(&sample);
        Scene::new(&sample).move_pins(&mut cloth, 0, 0.1);
        let work = accountant.work_of_pins(&cloth);
        assert!(work > 0.0);
        let mut moved = cloth.positions().to_vec();
        for (vertex, target) in cloth.pinned() {
            moved[vertex as usize] = target;
        }
        cloth.set_state(&moved, &vec![DVec3::ZERO; moved.len()]);
        accountant.after(&cloth, 0.1, work);
        assert!(accountant.gain().abs() < 1e-9);
        // The same motion without them is a gain.
        let (mut cloth, mut accountant) = scene(&sample);
        cloth.set_state(&moved, &vec![DVec3::ZERO; moved.len()]);
        accountant.after(&cloth, 0.1, 0.0);
        let fall = cloth.masses().iter().sum::<f64>() * 9.81_f64.powi(2) * 0.1_f64.powi(2);
        assert!((accountant.gain() * fall / work - 1.0).abs() < 1e-3, "{} of {fall} J, {work} J", accountant.gain());
    }
}
