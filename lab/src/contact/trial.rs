//! A cloth among bodies, watched from step to step.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, StepOutcome, StepReport};

use super::body::Body;
use super::depth;
use super::row::{Row, Wanted};

/// Vertices may be this deep, mm: the shapes are in f32, which rounds places to a part of that.
pub const ROUNDING: f64 = 1e-3;

/// A cloth and bodies, and the worst of what was seen of them.
pub struct Trial {
    /// The cloth.
    pub cloth: Cloth,
    /// What it may touch.
    pub bodies: Vec<Body>,
    /// s.
    pub time: f64,
    dt: f64,
    steps: u32,
    look_every: u32,
    seen: Seen,
    energy: Balance,
}

/// The worst of all steps.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The deepest vertex, m: below zero if none was ever inside.
    pub vertex_depth: f64,
    /// The deepest point of a triangle, m.
    pub face_depth: f64,
    /// Vertices that passed through a body, each as often as it did.
    pub passed: u32,
    /// Steps that could not be taken, or after which a number was not finite.
    pub failed: u32,
    /// See [`StepReport::rescues`].
    pub rescues: u32,
    /// See [`StepReport::fallbacks`].
    pub fallbacks: u32,
    /// See [`StepReport::velocity_clamps`].
    pub velocity_clamps: u32,
}

/// Energy that was there, came in by bodies, and is there.
#[derive(Clone, Copy, Debug)]
struct Balance {
    /// At the beginning, J.
    start: f64,
    /// Of the motion at the beginning, J.
    kinetic: f64,
    /// Potential of gravity at its lowest, J.
    lowest: f64,
    /// Potential of gravity at the beginning, J.
    height: f64,
    /// Work of bodies, J.
    work: f64,
    /// The same, what they took back counted as well, J.
    turnover: f64,
    /// The most that was ever there and not accounted for, J.
    gain: f64,
}

impl Trial {
    /// From now on, in steps of `dt` seconds.
    pub fn new(cloth: Cloth, bodies: Vec<Body>, dt: f64) -> Self {
        let none = f64::NEG_INFINITY;
        let seen = Seen {
            vertex_depth: none,
            face_depth: none,
            passed: 0,
            failed: 0,
            rescues: 0,
            fallbacks: 0,
            velocity_clamps: 0,
        };
        let energy = cloth.energy();
        let energy = Balance {
            start: energy.total(),
            kinetic: energy.kinetic,
            lowest: energy.gravity,
            height: energy.gravity,
            work: 0.0,
            turnover: 0.0,
            gain: 0.0,
        };
        Self { cloth, bodies, time: 0.0, dt, steps: 0, look_every: 1, seen, energy }
    }

    /// Measures depths after every so many steps only: for shapes whose distances take longer than the steps.
    pub fn looking_every(self, steps: u32) -> Self {
        Self { look_every: steps, ..self }
    }

    /// What was seen so far.
    pub fn seen(&self) -> Seen {
        self.seen
    }

    /// Takes a step.
    pub fn step(&mut self) {
        self.take(|cloth, dt, ways| cloth.step_watched(dt, Some(&mut |share, x| ways.push((share, x.to_vec())))));
    }

    /// Takes a step by a function that does nothing but that: what else there is to do is not timed with it.
    pub fn step_by(&mut self, step: impl FnOnce(&mut Cloth, f64) -> StepReport) {
        self.take(|cloth, dt, _| step(cloth, dt));
    }

    /// Takes a step by a function that may say where the vertices are after shares of it.
    fn take(&mut self, step: impl FnOnce(&mut Cloth, f64, &mut Vec<(f64, Vec<DVec3>)>) -> StepReport) {
        let span = [self.time, self.time + self.dt];
        self.cloth.set_colliders((0..).zip(&self.bodies).map(|(id, body)| body.collider(id, span))).expect("colliders");
        let mut ways = vec![(0.0, self.cloth.positions().to_vec())];
        let report = step(&mut self.cloth, self.dt, &mut ways);
        ways.push((1.0, self.cloth.positions().to_vec()));
        self.time = span[1];
        self.steps += 1;
        let Self { cloth, bodies, seen, .. } = self;
        if self.steps.is_multiple_of(self.look_every) {
            seen.vertex_depth = seen.vertex_depth.max(depth::vertices(cloth, bodies, span[1]));
            seen.face_depth = seen.face_depth.max(depth::faces(cloth, bodies, span[1]));
        }
        for way in ways.windows(2) {
            let shares = [way[0].0, way[1].0];
            seen.passed += depth::passed([&way[0].1, &way[1].1], bodies, span, shares);
        }
        let finite = cloth.positions().iter().chain(cloth.velocities()).all(|x| x.is_finite());
        seen.failed += u32::from(report.outcome != StepOutcome::Accepted || !finite);
        seen.rescues += report.rescues;
        seen.fallbacks += report.fallbacks;
        seen.velocity_clamps += report.velocity_clamps;
        self.balance(span);
    }

    fn balance(&mut self, [start, end]: [f64; 2]) {
        let (bodies, energy) = (&self.bodies, &mut self.energy);
        let work = self.cloth.contacts().filter_map(|contact| {
            let body = bodies.get(contact.collider as usize)?;
            let carried = contact.point - body.pose(start).place(body.pose(end).local(contact.point));
            Some(contact.force.dot(carried))
        });
        let work: f64 = work.sum();
        energy.work += work;
        energy.turnover += work.abs();
        let now = self.cloth.energy();
        energy.lowest = energy.lowest.min(now.gravity);
        energy.gain = energy.gain.max(now.total() - energy.start - energy.work);
    }

    /// Takes steps for so many seconds.
    pub fn run(&mut self, seconds: f64) {
        self.run_with(seconds, |_| {});
    }

    /// Takes steps for so many seconds, and looks after each.
    pub fn run_with(&mut self, seconds: f64, mut after: impl FnMut(&Self)) {
        for _ in 0..(seconds / self.dt).round() as u32 {
            self.step();
            after(self);
        }
    }

    /// The greatest speed of a vertex now, m/s.
    pub fn peak_speed(&self) -> f64 {
        self.cloth.velocities().iter().map(|v| v.length()).fold(0.0, f64::max)
    }

    /// The mean over so many seconds of the greatest speed of a vertex, mm/s.
    pub fn jitter(&mut self, seconds: f64) -> f64 {
        let (mut sum, mut steps) = (0.0, 0.0);
        self.run_with(seconds, |trial| {
            sum += trial.peak_speed();
            steps += 1.0;
        });
        1e3 * sum / steps
    }

    /// How high the highest vertex is, m.
    pub fn highest(&self) -> f64 {
        self.cloth.positions().iter().map(|x| x.y).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The centre of mass, m.
    pub fn centre(&self) -> DVec3 {
        let masses = self.cloth.masses();
        let weighted = self.cloth.positions().iter().zip(masses).map(|(&x, &m)| m * x);
        weighted.sum::<DVec3>() / masses.iter().sum::<f64>()
    }

    /// The judgements that every scene has: how deep, whether through, whether finite, what had to be mended.
    pub fn rows(&self, scene: &str) -> Vec<Row> {
        let seen = self.seen;
        let thickness = self.cloth.contact_settings().thickness;
        let row = |what: &str, measured, wanted| Row::new(scene, what, measured, wanted);
        let depth = 1e3 * seen.vertex_depth;
        vec![
            row("vertex depth/mm", depth, Wanted::AtMost(ROUNDING)),
            row("face depth/mm", 1e3 * seen.face_depth, Wanted::AtMost(1e3 * thickness)),
            row("in the layer/mm", (depth + 1e3 * thickness).max(0.0), Wanted::Known),
            row("passed through", seen.passed.into(), Wanted::AtMost(0.0)),
            row("steps failed", seen.failed.into(), Wanted::AtMost(0.0)),
            row("rescues", seen.rescues.into(), Wanted::Known),
            row("fallbacks", seen.fallbacks.into(), Wanted::Known),
            row("velocity clamps", seen.velocity_clamps.into(), Wanted::Known),
        ]
    }

    /// The most energy that was ever there beside what there was and what the bodies brought, of what took part: motion and fall,
    /// and their work. Says nothing where pins are moved: their work is not known.
    pub fn energy_row(&self, scene: &str) -> Row {
        let Balance { kinetic, lowest, height, turnover, gain, .. } = self.energy;
        let part = kinetic + (height - lowest) + turnover;
        Row::new(scene, "energy gained/%", 100.0 * gain / part.max(f64::MIN_POSITIVE), Wanted::AtMost(1.0))
    }
}

#[cfg(test)]
mod tests {
    use bevy_cloth::physics::{Pose, SolverSettings};

    use super::*;
    use crate::contact::solid::Solid;
    use crate::scenes::{DT, fabric};
    use crate::validate::strip::{Strip, place};

    fn above(height: f64) -> Trial {
        let mut cloth = Strip::new(0.2, 0.2, 4, 4).cloth(fabric(), SolverSettings::default());
        place(&mut cloth, |x| x + DVec3::Y * height);
        Trial::new(cloth, vec![Body::fixed(Solid::HalfSpace, 0.5, Pose::IDENTITY)], DT)
    }

    #[test]
    fn a_sheet_in_mid_air_touches_nothing_and_gains_nothing() {
        let mut trial = above(10.0);
        trial.run(0.5);
        let rows = trial.rows("air");
        assert!(rows.iter().all(|row| row.met), "{rows:?}");
        assert!(trial.energy_row("air").met && trial.seen().vertex_depth < -8.0);
        assert!(trial.centre().y < 10.0 && trial.peak_speed() > 1.0);
    }

    #[test]
    fn a_sheet_under_the_ground_is_seen() {
        let mut trial = above(-0.2);
        trial.step();
        let missed: Vec<_> = trial.rows("ground").into_iter().filter(|row| !row.met).map(|row| row.what).collect();
        assert!(missed.iter().any(|what| what.starts_with("passed")), "{missed:?}");
    }
}
