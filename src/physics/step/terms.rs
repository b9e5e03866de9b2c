//! The terms of a cloth: those of its linear system, and contact.

use bevy::math::DVec3;

use super::substep::Step;
use crate::physics::assembly::{Ordering, Part, Stencil, System};
use crate::physics::contact::ContactLayer;
use crate::physics::material::Fabric;
use crate::physics::math::Scalar;
use crate::physics::mesh::RestShape;
use crate::physics::terms::Term;

/// All terms; see [`terms`](crate::physics::terms) for the list.
pub(super) struct Terms<T: Scalar> {
    /// A and b, and the terms that are not contact.
    pub system: System<T>,
    /// Contact with colliders, which has an active set that the step asks for.
    pub contact: ContactLayer,
}

impl<T: Scalar> Terms<T> {
    /// The parts that vertices are worked on by.
    pub fn parts(&self) -> &[Part] {
        self.system.matrix.pattern().parts()
    }

    fn each(&mut self) -> impl Iterator<Item = &mut dyn Term<T>> {
        let contact: &mut dyn Term<T> = &mut self.contact;
        self.system.terms().chain(core::iter::once(contact))
    }

    /// Begins a substep: targets are set and contacts found.
    pub fn begin(&mut self, step: &Step) {
        if step.around.colliders.is_empty() {
            self.contact.forget();
        } else {
            self.contact.detect(&step.around, &step.start);
        }
        self.each().for_each(|term| term.begin(&step.start));
    }

    /// Whether anything holds the cloth but pins.
    pub fn hold(&mut self) -> bool {
        self.each().any(|term| term.holds())
    }

    /// Forces on points of the cloth, linearized with vertices at `x`.
    pub fn stencils(&mut self, x: &[DVec3], out: &mut Vec<Stencil>) {
        out.clear();
        self.each().for_each(|term| term.add_stencils(x, out));
    }

    /// Potential of what holds for this substep alone, J.
    pub fn substep_potential(&mut self, x: &[DVec3]) -> f64 {
        self.each().map(|term| term.substep_potential(x)).sum()
    }

    /// Work of the world on the way from xₙ to `x`, J.
    pub fn work(&mut self, step: &Step, x: &[DVec3]) -> f64 {
        self.each().map(|term| term.work(&step.start, x)).sum()
    }

    /// Ends a substep that led to `x`.
    pub fn end(&mut self, step: &Step, x: &[DVec3]) {
        self.contact.remember(&step.around);
        self.each().for_each(|term| term.end(x));
    }
}

/// The contacts of a cloth whose vertices are numbered as `ordering` says.
pub(super) fn contact(shape: &RestShape, fabric: &Fabric, ordering: &Ordering) -> ContactLayer {
    let triangles = shape.triangles.iter().map(|triangle| triangle.vertices.map(|v| ordering.inner[v as usize]));
    ContactLayer::new(fabric, triangles.collect(), longest_sides(shape, ordering))
}

/// By vertex, as `ordering` numbers them: length of the longest side of the triangles around it at rest, m.
pub(super) fn longest_sides(shape: &RestShape, ordering: &Ordering) -> Vec<f64> {
    let mut sides = vec![0.0_f64; shape.positions.len()];
    for triangle in &shape.triangles {
        let [a, b, c] = triangle.vertices.map(|vertex| shape.positions[vertex as usize]);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a)).sqrt();
        for vertex in triangle.vertices.map(|vertex| ordering.inner[vertex as usize] as usize) {
            sides[vertex] = sides[vertex].max(longest);
        }
    }
    sides
}

#[cfg(test)]
mod tests {
    use bevy::math::DMat3;

    use super::super::{Engine, Pins, State, Stepper, World};
    use super::*;
    use crate::physics::assembly::ImplicitStep;
    use crate::physics::cloth::{SolverSettings, StepReport};
    use crate::physics::contact::ContactSettings;
    use crate::physics::mesh::{RestShapeOptions, SurfaceMesh};
    use crate::physics::terms::Substep;

    const DT: f64 = 1.0 / 60.0;
    const STIFFNESS: f64 = 20.0;

    /// A spring from a vertex to a point that moves on in each step.
    struct Spring {
        vertex: u32,
        target: DVec3,
        /// m in a step.
        way: DVec3,
        /// Whether it says what potential it has.
        honest: bool,
    }

    impl<T: Scalar> Term<T> for Spring {
        fn begin(&mut self, substep: &Substep) {
            self.target += (substep.to - substep.from) * self.way;
        }

        fn add_stencils(&mut self, at: &[DVec3], out: &mut Vec<Stencil>) {
            let force = STIFFNESS * (self.target - at[self.vertex as usize]);
            out.push(Stencil::of_vertex(self.vertex, force, DMat3::from_diagonal(DVec3::splat(STIFFNESS))));
        }

        fn holds(&self) -> bool {
            true
        }

        fn driven(&mut self, _: &Substep, x: &[DVec3], _: &[Part]) -> f64 {
            let square = x[self.vertex as usize].distance_squared(self.target);
            if self.honest { 0.5 * STIFFNESS * square } else { 0.0 }
        }
    }

    struct Stage {
        stepper: Stepper<f64>,
        state: State,
        masses: Vec<f64>,
        report: StepReport,
    }

    impl Stage {
        /// A square of 0.1 m and two triangles that nothing holds.
        fn new() -> Self {
            let positions = [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::X + DVec3::Z].map(|x| 0.1 * x);
            let mesh = SurfaceMesh { positions: &positions, triangles: &[[0, 2, 1], [1, 2, 3]], uvs: None };
            let shape = RestShape::new(&mesh, &RestShapeOptions::default()).unwrap();
            let fabric = Fabric::cotton();
            let ordering = Ordering::identity(4);
            Self {
                stepper: Stepper::new(&shape, &fabric, &SolverSettings::reference(), &ordering),
                state: State { positions: positions.to_vec(), velocities: vec![DVec3::ZERO; 4] },
                masses: shape.vertex_areas.iter().map(|area| area * f64::from(fabric.density)).collect(),
                report: StepReport::NONE,
            }
        }

        fn with_spring(way: DVec3, honest: bool) -> Self {
            let mut stage = Self::new();
            let spring = Spring { vertex: 3, target: stage.state.positions[3], way, honest };
            stage.stepper.terms.system.register(Box::new(spring));
            stage
        }

        fn step(&mut self, gravity: DVec3) {
            let pins = Pins::new(4);
            let (masses, mass) = (&self.masses[..], self.masses.iter().sum());
            let contact = ContactSettings::default();
            let world = World { masses, mass, gravity, wind: DVec3::ZERO, colliders: &[], contact };
            let step = world.substep([0.0, 1.0], DT, false, &self.state, &pins);
            self.stepper.step(&step, &mut self.report).unwrap();
            Engine::advance(&mut self.stepper, &mut self.state);
        }
    }

    #[test]
    fn a_term_of_its_own_holds_a_cloth_up() {
        let mut stage = Stage::with_spring(DVec3::ZERO, true);
        let start = stage.state.positions[3];
        let gravity = DVec3::NEG_Y * 9.81;
        (0..1500).for_each(|_| stage.step(gravity));
        let sag = stage.masses.iter().sum::<f64>() * 9.81 / STIFFNESS;
        let lowest = start - DVec3::Y * sag;
        assert!(stage.state.positions[3].distance(lowest) < 1e-3 * sag, "{} {lowest}", stage.state.positions[3]);
    }

    /// What moves a target gives the cloth energy. A term that says so is believed; energy from nowhere is taken away again.
    #[test]
    fn the_safeguard_counts_the_energy_of_a_term_that_it_does_not_know() {
        let way = DT * DVec3::new(1.0, 2.0, 0.0);
        let [honest, lying] = [true, false].map(|honest| {
            let mut stage = Stage::with_spring(way, honest);
            (0..60).for_each(|_| stage.step(DVec3::ZERO));
            stage
        });
        let taken_away = |stage: &Stage| stage.report.velocity_clamps + stage.report.fallbacks;
        assert!(taken_away(&honest) < 6 && taken_away(&lying) > 20, "{} {}", taken_away(&honest), taken_away(&lying));
        let mean = honest.state.velocities.iter().sum::<DVec3>() / 4.0;
        assert!(mean.distance(way / DT) < 1.5, "{mean}");
    }

    #[test]
    fn rows_of_terms_of_single_vertices_add_up() {
        let stage = Stage::new();
        let x = &stage.state.positions;
        let inertial: Vec<_> = x.iter().map(|x| *x + DVec3::Y).collect();
        let gravity = DVec3::NEG_Y;
        let step = ImplicitStep {
            dissipates: true,
            wind: DVec3::X,
            ..ImplicitStep::backward_euler(x, &inertial, 0.5, gravity)
        };
        // (M (y − x) + γ² M g + γ² α M w) / (M (1 + γ α)) of α = 1/s.
        let drift = stage.stepper.terms.system.free_drift(&step, &stage.masses);
        assert!(drift.distance((DVec3::Y + 0.25 * (gravity + DVec3::X)) / 1.5) < 1e-12, "{drift}");
    }
}
