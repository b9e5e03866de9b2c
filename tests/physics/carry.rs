//! Carrying and boosting a cloth in motion: found by turns within a frame that whipped capes at 67 m/s.

use bevy::math::{DAffine3, DQuat, DVec3};
use bevy_cloth::physics::{Cloth, Collider, Fabric, Pose, SolverSettings};
use parry3d::shape::SharedShape;

use crate::meshes::TestMesh;

const DT: f64 = 1.0 / 60.0;

fn swinging(settings: SolverSettings, fabric: Fabric) -> Cloth {
    let mut cloth = Cloth::new(TestMesh::sheet(9, 9, 1.0, 1.0).shape(), fabric, settings).unwrap();
    for vertex in [0, 8] {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    for _ in 0..30 {
        cloth.step(DT);
    }
    cloth
}

#[test]
fn a_cloth_in_motion_goes_on_where_it_was_carried_as_it_would_have_gone_on() {
    // About the axis of gravity, so that this is the same.
    let map = DAffine3::from_rotation_translation(DQuat::from_rotation_y(1.0), DVec3::new(40.0, -3.0, 7.0));
    let start = || swinging(SolverSettings::reference(), Fabric::cotton());
    let (mut here, mut there) = (start(), start());
    there.carry(map);
    for step in 0..30 {
        here.step(DT);
        there.step(DT);
        for (&x, &y) in here.positions().iter().zip(there.positions()) {
            let error = map.transform_point3(x).distance(y);
            assert!(error < 1e-8, "step {step}: {error:e} m");
        }
    }
}

#[test]
fn contact_goes_on_where_cloth_and_collider_are_carried() {
    let turn = DQuat::from_rotation_y(2.0);
    let map = DAffine3::from_rotation_translation(turn, DVec3::new(3.0, 0.0, 7.0));
    // A little into the middle of the cloth.
    let middle = swinging(SolverSettings::reference(), Fabric::cotton()).positions()[40];
    let at = Pose::at(middle + DVec3::new(0.0, 0.0, 0.29));
    let moved = Pose { translation: map.transform_point3(at.translation), rotation: turn * at.rotation };
    let start = || {
        let mut cloth = swinging(SolverSettings::reference(), Fabric::cotton());
        cloth.set_colliders([Collider::fixed(7, SharedShape::ball(0.3), at, 0.5)]).unwrap();
        for _ in 0..3 {
            cloth.step(DT);
        }
        assert!(cloth.contacts().count() > 0, "{:?}", cloth.positions()[40]);
        cloth
    };
    let (mut here, mut there) = (start(), start());
    there.carry(map);
    there.set_colliders([Collider::fixed(7, SharedShape::ball(0.3), moved, 0.5)]).unwrap();
    for step in 0..10 {
        here.step(DT);
        there.step(DT);
        for (&x, &y) in here.positions().iter().zip(there.positions()) {
            let error = map.transform_point3(x).distance(y);
            assert!(error < 1e-6, "step {step}: {error:e} m");
        }
    }
}

#[test]
fn a_boost_is_a_change_of_the_frame_of_reference() {
    let velocity = DVec3::new(30.0, 2.0, -5.0);
    let fabric = Fabric { air_drag: 0.0, ..Fabric::cotton() };
    let start = || {
        let mut cloth = swinging(SolverSettings::reference(), fabric);
        cloth.clear_pins();
        cloth.step(DT);
        cloth
    };
    let (mut still, mut boosted) = (start(), start());
    boosted.boost(velocity);
    for step in 1..=20 {
        still.step(DT);
        boosted.step(DT);
        for (&x, &y) in still.positions().iter().zip(boosted.positions()) {
            let error = (x + velocity * DT * f64::from(step)).distance(y);
            // Where a step is linearized still depends on the frame of reference, by so much.
            assert!(error < 1e-3, "step {step}: {error:e} m");
        }
    }
}

#[test]
fn air_drag_acts_against_the_wind() {
    let fabric = Fabric { air_drag: 3.0, ..Fabric::cotton() };
    let mut cloth = Cloth::new(TestMesh::sheet(5, 5, 1.0, 1.0).shape(), fabric, SolverSettings::default()).unwrap();
    cloth.set_gravity(DVec3::ZERO);
    let wind = DVec3::new(4.0, 0.0, 1.0);
    cloth.set_wind(wind);
    for _ in 0..300 {
        cloth.step(DT);
    }
    assert!(cloth.velocities().iter().all(|v| v.distance(wind) < 1e-3), "it goes with the wind at last");
}
