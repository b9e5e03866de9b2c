//! Nothing depends on the frame of reference: the same cloth at home, in a lift and on a train.

use bevy::math::{DQuat, DVec3};
use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::physics::{Cloth, Collider, Fabric, Pose, Quality, SolverSettings};

use crate::meshes::TestMesh;

const DT: f64 = 1.0 / 60.0;
const FRAMES: [DVec3; 3] = [DVec3::new(0.0, 3.0, 0.0), DVec3::new(3.0, 0.0, 0.0), DVec3::new(-20.0, 0.5, 11.0)];

fn sheet(n: usize, settings: SolverSettings) -> Cloth {
    let mut mesh = TestMesh::sheet(n, n, 0.6, 0.6);
    // No two corners meet the box at once.
    let turn = DQuat::from_rotation_y(0.3) * DQuat::from_rotation_x(0.11) * DQuat::from_rotation_z(0.07);
    for x in &mut mesh.positions {
        *x = turn * DVec3::new(x.x - 0.3, 0.0, -x.y - 0.3) + 0.26 * DVec3::Y;
    }
    Cloth::new(mesh.shape(), Fabric::cotton(), settings).unwrap()
}

/// A cloth seen from what moves at a velocity.
struct Ride {
    cloth: Cloth,
    velocity: DVec3,
    steps: u32,
}

impl Ride {
    fn new(mut cloth: Cloth, velocity: DVec3) -> Self {
        cloth.boost(velocity);
        cloth.set_wind(velocity);
        Self { cloth, velocity, steps: 0 }
    }

    fn place(&self, steps: u32) -> DVec3 {
        f64::from(steps) * DT * self.velocity
    }

    fn step(&mut self, pins: &[(u32, DVec3)], on_box: bool) {
        let [start, end] = [self.steps, self.steps + 1].map(|steps| Pose::at(self.place(steps)));
        if on_box {
            let shape = SharedShape::cuboid(0.2, 0.2, 0.2);
            self.cloth.set_colliders([Collider { end, ..Collider::fixed(1, shape, start, 0.5) }]).unwrap();
        }
        for &(vertex, x) in pins {
            self.cloth.pin(vertex, x + self.place(self.steps + 1));
        }
        self.cloth.step(DT);
        self.steps += 1;
    }

    /// Positions as one who goes along sees them.
    fn seen(&self) -> Vec<DVec3> {
        self.cloth.positions().iter().map(|x| *x - self.place(self.steps)).collect()
    }

    fn fastest(&self) -> f64 {
        self.cloth.velocities().iter().map(|v| v.distance(self.velocity)).fold(0.0, f64::max)
    }
}

fn difference(a: &Ride, b: &Ride) -> f64 {
    a.seen().iter().zip(b.seen()).map(|(a, b)| a.distance(b)).fold(0.0, f64::max)
}

/// Solved exactly, so that only rounding is left of what the frame does: contact makes a thousandfold of that in a second.
#[test]
fn a_cloth_falls_on_a_box_that_moves_as_on_one_that_stands() {
    let start = || sheet(10, SolverSettings::reference());
    for velocity in FRAMES {
        let (mut home, mut away) = (Ride::new(start(), DVec3::ZERO), Ride::new(start(), velocity));
        for step in 0..60 {
            home.step(&[], true);
            away.step(&[], true);
            let difference = difference(&home, &away);
            assert!(difference < 1e-7, "{velocity}, step {step}: {difference:e} m");
        }
    }
}

#[test]
fn a_pinned_cloth_swings_on_a_train_as_at_home() {
    for settings in [SolverSettings::reference(), SolverSettings { newton_steps: 2, ..SolverSettings::reference() }] {
        let start = || sheet(10, settings);
        let pins: Vec<_> = [0, 10].map(|vertex| (vertex, start().positions()[vertex as usize])).into();
        for velocity in FRAMES {
            let (mut home, mut away) = (Ride::new(start(), DVec3::ZERO), Ride::new(start(), velocity));
            for step in 0..90 {
                home.step(&pins, false);
                away.step(&pins, false);
                let difference = difference(&home, &away);
                assert!(difference < 1e-7, "{velocity}, step {step}: {difference:e} m");
            }
        }
    }
}

/// Found by field report F1b: on anything that moved it trembled at .45 to .98 m/s for ever, at home at .011.
#[test]
fn a_cloth_on_a_box_that_moves_comes_to_rest() {
    for velocity in [DVec3::ZERO].into_iter().chain(FRAMES) {
        for level in [Quality::Medium, Quality::High] {
            let mut ride = Ride::new(sheet(16, level.settings()), velocity);
            (0..480).for_each(|_| ride.step(&[], true));
            let fastest = (0..60).map(|_| {
                ride.step(&[], true);
                ride.fastest()
            });
            let fastest = fastest.fold(0.0, f64::max);
            assert!(fastest < 0.03, "{velocity}, {level}: {fastest} m/s");
        }
    }
}

/// What the levels below solve a step of, several ticks long.
#[test]
fn long_steps_do_not_depend_on_the_frame_either() {
    let start = || sheet(10, SolverSettings::reference());
    let pins: Vec<_> = [0, 10].map(|vertex| (vertex, start().positions()[vertex as usize])).into();
    for velocity in FRAMES {
        let (mut home, mut away) = (start(), start());
        away.boost(velocity);
        away.set_wind(velocity);
        for step in 1..=20 {
            let place = f64::from(step) * 4.0 * DT * velocity;
            for &(vertex, x) in &pins {
                home.pin(vertex, x);
                away.pin(vertex, x + place);
            }
            home.step(4.0 * DT);
            away.step(4.0 * DT);
            let pairs = home.positions().iter().zip(away.positions());
            let difference = pairs.map(|(a, b)| a.distance(*b - place)).fold(0.0, f64::max);
            assert!(difference < 1e-7, "{velocity}, step {step}: {difference:e} m");
        }
    }
}
