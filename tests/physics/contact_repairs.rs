//! Faults of contact that were found by reading, each with what it did.

use bevy::math::DVec3;
use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::physics::{
    Cloth, Collider, ColliderError, ContactSettings, ContactSettingsError, Fabric, Pose, SolverSettings, StepOutcome,
};

use crate::meshes::TestMesh;

const DT: f64 = 1.0 / 60.0;

/// A level sheet of 0.3 m, its middle at a place.
fn sheet(n: usize, centre: DVec3) -> Cloth {
    let mut mesh = TestMesh::sheet(n, n, 0.3, 0.3);
    for x in &mut mesh.positions {
        *x = centre + DVec3::new(x.x - 0.15, 0.0, -x.y - 0.15);
    }
    Cloth::new(mesh.shape(), Fabric::cotton(), SolverSettings::default()).unwrap()
}

fn floor(friction: f64) -> Collider {
    Collider::fixed(7, SharedShape::halfspace(bevy::math::Vec3::Y), Pose::IDENTITY, friction)
}

/// Its stiffness was infinite, and so were the forces told.
#[test]
fn a_place_between_two_held_vertices_has_no_force() {
    let mut cloth = sheet(4, DVec3::ZERO);
    for vertex in 0..4 {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
    // It crosses the held side between the first two vertices, and just reaches it.
    let rod = SharedShape::capsule_z(0.05, 0.01);
    let place = 0.5 * (cloth.positions()[0] + cloth.positions()[1]) - 0.011 * DVec3::Y;
    cloth.set_colliders([Collider::fixed(1, rod, Pose::at(place), 0.5)]).unwrap();
    for _ in 0..10 {
        assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);
        assert!(cloth.contacts().all(|contact| contact.force.is_finite()));
        assert!(cloth.energy().total().is_finite());
    }
}

/// They were where the cloth was when the step began.
#[test]
fn contact_points_are_those_of_the_end_of_the_step() {
    let mut cloth = sheet(4, DVec3::Y * 0.003);
    cloth.set_fabric(Fabric { air_drag: 0.0, ..Fabric::cotton() }).unwrap();
    let x = cloth.positions().to_vec();
    cloth.set_state(&x, &vec![DVec3::X * 10.0; x.len()]);
    cloth.set_colliders([floor(0.0)]).unwrap();
    for _ in 0..3 {
        cloth.step(DT);
    }
    assert!(cloth.contacts().count() > 8);
    for contact in cloth.contacts() {
        let x = cloth.positions()[contact.vertices[0] as usize];
        assert!(contact.point.distance(x.with_y(0.0)) < 1e-9, "{} {x}", contact.point);
    }
}

#[test]
fn contacts_know_their_collider_after_others_were_set() {
    let mut cloth = sheet(4, DVec3::Y * 0.003);
    let far = Collider::fixed(9, SharedShape::ball(0.1), Pose::at(DVec3::X * 9.0), 0.5);
    cloth.set_colliders([floor(0.5)]).unwrap();
    cloth.step(DT);
    for others in [vec![far.clone(), floor(0.5)], vec![far], vec![]] {
        cloth.set_colliders(others).unwrap();
        assert!(cloth.contacts().count() > 0 && cloth.contacts().all(|contact| contact.collider == 7));
    }
}

/// A negative thickness ended in a panic, a negative friction in NaN.
#[test]
fn settings_that_mean_nothing_are_refused() {
    let mut cloth = sheet(4, DVec3::Y * 0.003);
    let good = cloth.contact_settings();
    for thickness in [0.0, -1.0, f64::INFINITY] {
        let refused = cloth.set_contact_settings(ContactSettings { thickness, ..good });
        assert_eq!(refused, Err(ContactSettingsError::Thickness(thickness)));
    }
    assert!(cloth.set_contact_settings(ContactSettings { thickness: f64::NAN, ..good }).is_err());
    assert_eq!(
        cloth.set_contact_settings(ContactSettings { friction: -0.1, ..good }),
        Err(ContactSettingsError::Friction(-0.1))
    );
    assert_eq!(cloth.contact_settings(), good);
    assert_eq!(cloth.set_contact_settings(ContactSettings { friction: 0.1, ..good }), Ok(()));
    let refused = cloth.set_colliders([floor(-1.0), floor(0.5)]);
    assert_eq!(refused, Err(ColliderError::Friction { id: 7, friction: -1.0 }));
    assert_eq!(cloth.colliders().len(), 1);
    assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);
}
