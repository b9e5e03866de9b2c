//! Held vertices.

use bevy::math::{DAffine3, DQuat, DVec3};
use bevy_cloth::physics::{Cloth, Fabric, Precision, SolverSettings, StepOutcome};

use crate::meshes::TestMesh;

const DT: f64 = 1.0 / 60.0;

fn hung(settings: SolverSettings) -> Cloth {
    let mut cloth = Cloth::new(TestMesh::sheet(8, 8, 1.0, 1.0).shape(), Fabric::cotton(), settings).unwrap();
    for vertex in [0, 7] {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    cloth
}

#[test]
fn pinned_vertices_are_at_their_targets_to_the_last_bit_while_these_move() {
    for precision in [Precision::Single, Precision::Double] {
        for substeps in [1, 3] {
            let mut cloth = hung(SolverSettings { precision, substeps, ..Default::default() });
            for step in 0..30 {
                let target = DVec3::new((0.3 * f64::from(step)).sin(), 0.1, 1e-3 * f64::from(step * step));
                cloth.pin(0, target);
                assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);
                assert_eq!(cloth.positions()[0], target);
                assert_eq!(cloth.positions()[7], cloth.pin_target(7).unwrap());
            }
        }
    }
}

#[test]
fn a_moving_pin_pulls_its_neighbours_within_the_step() {
    let mut cloth = hung(SolverSettings::default());
    for _ in 0..120 {
        cloth.step(DT);
    }
    // Along the edge, where the sheet is stiff.
    let (pin, neighbour) = (cloth.positions()[0], cloth.positions()[8]);
    let pull = 0.3 * (pin - neighbour).normalize();
    cloth.pin(0, pin + pull);
    cloth.step(DT);
    let moved = (cloth.positions()[8] - neighbour).dot(pull.normalize());
    assert!(moved > 0.2, "{moved} m");
}

#[test]
fn without_pins_the_cloth_falls() {
    let mut cloth = hung(SolverSettings::default());
    for _ in 0..30 {
        cloth.step(DT);
    }
    cloth.clear_pins();
    assert_eq!(cloth.pinned().count(), 0);
    let before = cloth.positions()[0].y;
    for _ in 0..30 {
        cloth.step(DT);
    }
    assert!(cloth.positions()[0].y < before - 0.5);
}

#[test]
fn a_teleport_changes_nothing_but_the_place() {
    let map = DAffine3::from_rotation_translation(DQuat::from_rotation_y(1.0), DVec3::new(40.0, -3.0, 7.0));
    let (mut here, mut there) = (hung(SolverSettings::reference()), hung(SolverSettings::reference()));
    there.carry(map);
    for _ in 0..20 {
        here.step(DT);
        there.step(DT);
    }
    for (&x, &y) in here.positions().iter().zip(there.positions()) {
        let error = map.transform_point3(x).distance(y);
        assert!(error < 1e-9, "{error:e} m");
    }
}
