//! A restored cloth goes on to the last bit.

use bevy::math::{DVec3, Vec3};
use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::physics::{
    BendingModel, Cloth, Collider, Fabric, Integrator, Pose, RestShapeOptions, Snapshot, SnapshotError, SolverSettings,
};

use crate::meshes::TestMesh;

const DT: f64 = 1.0 / 60.0;

/// A level sheet, held at two corners, of which one moves, above a ball that moves and a floor.
struct Scene {
    n: usize,
    settings: SolverSettings,
    bending: BendingModel,
}

impl Scene {
    fn new(settings: SolverSettings) -> Self {
        Self { n: 15, settings, bending: BendingModel::default() }
    }

    fn cloth(&self) -> Cloth {
        let mut mesh = TestMesh::jittered(self.n, self.n, 0.8, 0.8, 0.2);
        for x in &mut mesh.positions {
            *x = DVec3::new(x.x - 0.4, 0.32, -x.y - 0.4);
        }
        let shape = mesh.shape_with(&RestShapeOptions { bending: self.bending, ..Default::default() });
        Cloth::new(shape, Fabric::cotton(), self.settings).unwrap()
    }

    fn step(&self, cloth: &mut Cloth, tick: u32) {
        let at = |tick: u32| Pose::at(DVec3::new(0.1 * (0.2 * f64::from(tick)).sin(), 0.0, 0.0));
        let ball = Collider { id: 5, shape: SharedShape::ball(0.3), start: at(tick), end: at(tick + 1), friction: 0.5 };
        let floor = Collider::fixed(9, SharedShape::halfspace(Vec3::Y), Pose::at(DVec3::NEG_Y * 0.1), 0.5);
        cloth.set_colliders([ball, floor]).unwrap();
        cloth.clear_pins();
        let lift = DVec3::Y * 0.05 * (0.1 * f64::from(tick)).sin();
        cloth.pin(0, cloth.shape().positions[0] + lift);
        if !(40..=50).contains(&tick) {
            cloth.pin(self.n as u32 - 1, cloth.shape().positions[self.n - 1]);
        }
        cloth.step(DT);
    }

    fn run(&self, cloth: &mut Cloth, ticks: core::ops::Range<u32>) -> Vec<[Vec<DVec3>; 2]> {
        ticks
            .map(|tick| {
                self.step(cloth, tick);
                [cloth.positions().to_vec(), cloth.velocities().to_vec()]
            })
            .collect()
    }

    /// Steps to a tick, on to a later one, and there again from the first: the same cloth, and another.
    fn check(&self, at: u32, further: u32) {
        let mut cloth = self.cloth();
        self.run(&mut cloth, 0..at);
        let snapshot = cloth.snapshot();
        let ahead = self.run(&mut cloth, at..at + further);
        assert!(cloth.contacts().next().is_some(), "it touches something");
        cloth.restore(&snapshot).unwrap();
        assert_eq!(cloth.snapshot(), snapshot);
        assert!(self.run(&mut cloth, at..at + further) == ahead, "the same cloth");
        let mut other = self.cloth();
        other.restore(&snapshot).unwrap();
        assert!(self.run(&mut other, at..at + further) == ahead, "another cloth");
    }
}

fn backward_euler() -> SolverSettings {
    SolverSettings { integrator: Integrator::BackwardEuler, ..Default::default() }
}

fn double() -> SolverSettings {
    SolverSettings { precision: bevy_cloth::physics::Precision::Double, ..Default::default() }
}

#[test]
fn a_restored_cloth_goes_on_bit_for_bit() {
    for settings in [SolverSettings::default(), backward_euler(), double()] {
        for at in [1, 30, 45] {
            Scene::new(settings).check(at, 30);
        }
    }
}

#[test]
fn it_does_with_every_way_of_bending_and_several_substeps() {
    for bending in [BendingModel::Hinge, BendingModel::None] {
        Scene { bending, ..Scene::new(SolverSettings::default()) }.check(30, 20);
    }
    Scene::new(SolverSettings { substeps: 3, newton_steps: 2, ..Default::default() }).check(30, 20);
}

#[test]
fn it_does_in_several_parts() {
    Scene { n: 105, ..Scene::new(SolverSettings::default()) }.check(12, 4);
}

/// All of it, as `set_state` leaves out what is hidden.
#[test]
fn positions_and_velocities_alone_are_not_enough() {
    let scene = Scene::new(SolverSettings::default());
    let mut cloth = scene.cloth();
    scene.run(&mut cloth, 0..30);
    let (x, v) = (cloth.positions().to_vec(), cloth.velocities().to_vec());
    let ahead = scene.run(&mut cloth, 30..40);
    cloth.set_state(&x, &v);
    assert!(scene.run(&mut cloth, 30..40) != ahead);
}

#[test]
fn settings_and_fabric_are_those_of_the_snapshot() {
    let scene = Scene::new(SolverSettings::default());
    let mut cloth = scene.cloth();
    scene.run(&mut cloth, 0..30);
    let snapshot = cloth.snapshot();
    let ahead = scene.run(&mut cloth, 30..40);
    cloth.set_fabric(Fabric::silk()).unwrap();
    cloth.set_settings(double());
    cloth.set_gravity(DVec3::X);
    scene.run(&mut cloth, 30..40);
    cloth.restore(&snapshot).unwrap();
    assert!(scene.run(&mut cloth, 30..40) == ahead);
}

#[test]
fn it_takes_about_120_bytes_a_vertex_and_100_a_touch() {
    let scene = Scene { n: 60, ..Scene::new(SolverSettings::default()) };
    let mut cloth = scene.cloth();
    cloth.step(DT);
    cloth.step(DT);
    let free = cloth.snapshot().size() as f64 / 3600.0;
    assert!((96.0..130.0).contains(&free), "{free}");
    let mut cloth = scene.cloth();
    scene.run(&mut cloth, 0..30);
    let snapshot = cloth.snapshot();
    let touching = snapshot.size() as f64 / 3600.0;
    assert!(touching < 230.0, "{touching}");
    assert!(snapshot.clone().positions().as_ptr() == snapshot.positions().as_ptr(), "a clone shares it");
}

#[test]
fn another_cloth_refuses_it_and_stays_as_it_is() {
    let scene = Scene::new(SolverSettings::default());
    let mut cloth = scene.cloth();
    scene.run(&mut cloth, 0..5);
    let snapshot = cloth.snapshot();
    let finer = Scene { n: 16, ..Scene::new(SolverSettings::default()) };
    let hinged = Scene { bending: BendingModel::Hinge, ..Scene::new(SolverSettings::default()) };
    for other in [finer, hinged] {
        let mut other = other.cloth();
        let before = other.snapshot();
        let error = other.restore(&snapshot).unwrap_err();
        assert_eq!(error, SnapshotError::Shape);
        assert!(error.to_string().contains("another cloth"));
        assert_eq!(other.snapshot(), before);
    }
}

#[test]
fn states_that_cannot_be_are_refused() {
    let mut cloth = Scene::new(SolverSettings::default()).cloth();
    let (mut x, v) = (cloth.positions().to_vec(), cloth.velocities().to_vec());
    let short = cloth.try_set_state(&x[1..], &v).unwrap_err();
    assert_eq!(short, SnapshotError::Count { what: "positions", found: 224, expected: 225 });
    assert!(cloth.try_set_state(&x, &[]).is_err());
    x[7].z = f64::NAN;
    assert_eq!(cloth.try_set_state(&x, &v), Err(SnapshotError::NotFinite { vertex: 7 }));
    x[7].z = 0.25;
    cloth.try_set_state(&x, &v).unwrap();
    assert_eq!(cloth.positions()[7].z, 0.25);
}

#[cfg(feature = "serialize")]
mod written {
    use super::*;

    fn read(text: &str) -> Snapshot {
        ron::from_str(text).unwrap()
    }

    #[test]
    fn it_goes_through_a_file_to_the_last_bit() {
        for settings in [SolverSettings::default(), double()] {
            let scene = Scene::new(settings);
            let mut cloth = scene.cloth();
            scene.run(&mut cloth, 0..33);
            let snapshot = cloth.snapshot();
            let back = read(&ron::to_string(&snapshot).unwrap());
            assert_eq!(back, snapshot);
            let ahead = scene.run(&mut cloth, 33..50);
            let mut other = scene.cloth();
            other.restore(&back).unwrap();
            assert!(scene.run(&mut other, 33..50) == ahead);
        }
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let scene = Scene::new(SolverSettings::default());
        let mut cloth = scene.cloth();
        scene.run(&mut cloth, 0..33);
        let before = cloth.snapshot();
        let text = ron::to_string(&before).unwrap();
        let edit = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            read(&text.replacen(from, to, 1))
        };
        let mut refuse = |snapshot: Snapshot| cloth.restore(&snapshot).unwrap_err();
        assert_eq!(refuse(edit("version:1", "version:9")), SnapshotError::Version { found: 9, expected: 1 });
        assert!(matches!(refuse(edit("surplus:", "surplus:NaN,old:")), SnapshotError::Damaged(_)));
        assert!(matches!(refuse(edit("positions:[", "positions:[(0.0,0.0,0.0),")), SnapshotError::Count { .. }));
        assert!(matches!(refuse(edit("turns:Single([", "turns:Single([0.0,")), SnapshotError::Damaged(_)));
        assert!(matches!(refuse(edit("turns:Single", "turns:Double")), SnapshotError::Damaged(_)));
        assert!(matches!(refuse(edit("held:[", "held:[4000,")), SnapshotError::Damaged(_)));
        assert_eq!(cloth.snapshot(), before);
    }
}
