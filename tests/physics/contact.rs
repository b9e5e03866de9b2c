//! Contact with the world.

use bevy::math::{DQuat, DVec3};
use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::physics::{Cloth, Collider, ColliderError, Fabric, Pose, SolverSettings, StepOutcome};

use crate::meshes::TestMesh;

const DT: f64 = 1.0 / 60.0;

/// A horizontal square sheet of `n` × `n` vertices.
fn sheet(n: usize, side: f64, centre: DVec3) -> Cloth {
    turned_sheet(n, side, centre, DQuat::IDENTITY)
}

fn turned_sheet(n: usize, side: f64, centre: DVec3, turn: DQuat) -> Cloth {
    let mut mesh = TestMesh::sheet(n, n, side, side);
    for x in &mut mesh.positions {
        *x = centre + turn * DVec3::new(x.x - 0.5 * side, 0.0, -x.y - 0.5 * side);
    }
    Cloth::new(mesh.shape(), Fabric::cotton(), SolverSettings::default()).unwrap()
}

fn floor(friction: f64) -> Collider {
    Collider::fixed(7, SharedShape::halfspace(bevy::math::Vec3::Y), Pose::IDENTITY, friction)
}

fn ball() -> Collider {
    Collider::fixed(1, SharedShape::ball(0.3), Pose::IDENTITY, 0.5)
}

fn run(cloth: &mut Cloth, colliders: &[Collider], steps: u32, mut check: impl FnMut(&Cloth)) {
    for _ in 0..steps {
        cloth.set_colliders(colliders.iter().cloned()).unwrap();
        let report = cloth.step(DT);
        assert_eq!(report.outcome, StepOutcome::Accepted);
        check(cloth);
    }
}

fn fastest(cloth: &Cloth) -> f64 {
    cloth.velocities().iter().map(|v| v.length()).fold(0.0, f64::max)
}

fn mean(values: &[DVec3]) -> DVec3 {
    values.iter().sum::<DVec3>() / values.len() as f64
}

#[test]
fn a_sheet_dropped_on_a_ball_stays_outside_and_stays_there() {
    let mut cloth = sheet(20, 0.8, DVec3::new(0.0, 0.35, 0.0));
    let start = cloth.energy().total();
    run(&mut cloth, &[ball()], 360, |cloth| {
        let deepest = cloth.positions().iter().map(|x| x.length() - 0.3).fold(f64::MAX, f64::min);
        assert!(deepest >= 0.0, "{deepest}");
        assert!(cloth.energy().total() <= start + 1e-3 * start.abs());
    });
    let top = cloth.positions().iter().map(|x| x.y).fold(f64::MIN, f64::max);
    assert!((0.3..0.31).contains(&top), "{top}");
    assert!(fastest(&cloth) < 0.1, "{}", fastest(&cloth));
}

/// Coulomb: at rest below the angle of friction, g (sin α − μ cos α) above.
#[test]
fn a_sheet_on_a_slope_stays_or_slides_as_coulomb_says() {
    // That of a pair is the geometric mean of both, and that of the cloth is .5.
    let friction: f64 = 0.4;
    let of_collider = friction * friction / 0.5;
    for (tangent, slides) in [(0.36_f64, false), (0.6, true)] {
        let turn = DQuat::from_rotation_z(-tangent.atan());
        let slope = Collider { end: Pose { rotation: turn, ..Pose::IDENTITY }, ..floor(of_collider) };
        let slope = Collider { start: slope.end, ..slope };
        let mut cloth = turned_sheet(6, 0.2, turn * DVec3::Y * 0.003, turn);
        // Without the drag of the air.
        cloth.set_fabric(Fabric::isotropic(0.15, 1000.0, 0.3, 1e-5).undamped()).unwrap();
        run(&mut cloth, core::slice::from_ref(&slope), 30, |_| {});
        let (x, v) = (mean(cloth.positions()), mean(cloth.velocities()));
        run(&mut cloth, core::slice::from_ref(&slope), 60, |_| {});
        if slides {
            let (sine, cosine) = tangent.atan().sin_cos();
            let expected = 9.81 * (sine - friction * cosine);
            let measured = (mean(cloth.velocities()) - v).length();
            assert!((measured / expected - 1.0).abs() < 0.02, "{measured} {expected}");
        } else {
            let moved = mean(cloth.positions()).distance(x);
            assert!(moved < 1e-3, "{moved}");
        }
    }
}

/// From the first step on, however long that is: nothing has to give before it holds.
#[test]
fn a_sheet_put_on_a_slope_holds_at_once() {
    for dt in [1.0 / 30.0, 1.0 / 240.0] {
        // At .95 of the angle of friction.
        let turn = DQuat::from_rotation_z(-0.95_f64.atan());
        let pose = Pose { rotation: turn, ..Pose::IDENTITY };
        let slope = Collider { start: pose, end: pose, ..floor(2.0) };
        let mut cloth = turned_sheet(6, 0.2, turn * DVec3::Y * 0.003, turn);
        cloth.set_fabric(Fabric::isotropic(0.15, 1000.0, 0.3, 1e-5).undamped()).unwrap();
        cloth.set_colliders([slope]).unwrap();
        let start = mean(cloth.positions());
        for _ in 0..(0.2 / dt) as u32 {
            cloth.step(dt);
        }
        let moved = (mean(cloth.positions()) - start).dot(turn * DVec3::X);
        assert!(moved.abs() < 3e-4, "{dt}: {moved}");
    }
}

/// Friction in an impact is bounded by what presses: a cloth that were glued would be stretched by the whole way of the ball.
#[test]
fn a_fast_ball_takes_a_curtain_along_and_does_not_tear_it() {
    for friction in [0.0, 0.1, 0.5] {
        let mut cloth = turned_sheet(32, 1.0, DVec3::ZERO, DQuat::from_rotation_x(core::f64::consts::FRAC_PI_2));
        for vertex in 0..32 {
            cloth.pin(vertex, cloth.positions()[vertex as usize]);
        }
        let place = |step: u32| Pose::at(DVec3::new(0.0, -0.2, f64::from(step) * 6.0 * DT - 0.25));
        let mut stretch = 0.0_f64;
        for step in 0..30 {
            let ball = Collider::fixed(1, SharedShape::ball(0.1), place(step), friction);
            cloth.set_colliders([Collider { end: place(step + 1), ..ball }]).unwrap();
            assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);
            stretch = stretch.max(cloth.stretch().rms);
        }
        // All of its motion would stretch it by 6 %.
        assert!(stretch > 2e-3, "{friction}: the ball hits nothing");
        assert!(stretch < 0.06, "{friction}: {stretch}");
    }
}

/// Linearised ahead, BDF2 drives free corners as fast as even thick air slows them; and cells that are coarse beside the ball lie on
/// places between their vertices, which come and go.
#[test]
fn a_cloth_that_lies_comes_to_rest_with_its_free_corners_coarse_or_fine() {
    for n in [12, 16, 20] {
        let mut cloth = sheet(n, 1.0, DVec3::new(0.0, 0.31, 0.0));
        cloth.set_fabric(Fabric { air_drag: 8.0, ..Fabric::cotton() }).unwrap();
        run(&mut cloth, &[ball()], 480, |_| {});
        assert!(fastest(&cloth) < 1e-3, "{n}: {}", fastest(&cloth));
    }
}

#[test]
fn forces_of_contact_carry_the_weight() {
    let mut cloth = sheet(8, 0.3, DVec3::new(0.0, 0.004, 0.0));
    run(&mut cloth, &[floor(0.5)], 120, |_| {});
    let force: DVec3 = cloth.contacts().map(|contact| contact.force).sum();
    let weight = 9.81 * cloth.masses().iter().sum::<f64>();
    assert!((force - weight * DVec3::Y).length() < 0.01 * weight, "{force} {weight}");
    for contact in cloth.contacts() {
        assert_eq!(contact.collider, 7);
        assert!(contact.normal.distance(DVec3::Y) < 1e-12 && contact.point.y.abs() < 1e-12);
        let x = cloth.positions()[contact.vertices[0] as usize];
        assert!((x.y - 0.003).abs() < 3e-4, "{x}");
    }
    assert!(fastest(&cloth) < 1e-3, "{}", fastest(&cloth));
}

#[test]
fn a_fast_sheet_does_not_pass_through_a_thin_wall() {
    let wall = Collider::fixed(3, SharedShape::cuboid(0.5, 0.5, 0.005), Pose::IDENTITY, 0.5);
    for turn in [DQuat::from_rotation_x(1.5), DQuat::IDENTITY] {
        let mut cloth = turned_sheet(8, 0.3, DVec3::new(0.0, 0.0, 1.0), turn);
        let (x, v) = (cloth.positions().to_vec(), vec![DVec3::new(0.0, 0.0, -50.0); 64]);
        cloth.set_state(&x, &v);
        run(&mut cloth, core::slice::from_ref(&wall), 10, |cloth| {
            assert!(cloth.positions().iter().all(|x| x.z >= 0.005 || x.abs().max_element() > 0.5));
        });
    }
}

#[test]
fn a_belt_takes_a_sheet_along() {
    let mut cloth = sheet(6, 0.2, DVec3::new(0.0, 0.003, 0.0));
    for step in 0..120 {
        let at = |step: f64| Pose::at(DVec3::X * step * DT);
        cloth
            .set_colliders([Collider { start: at(step.into()), end: at(f64::from(step) + 1.0), ..floor(0.5) }])
            .unwrap();
        cloth.step(DT);
    }
    let v = mean(cloth.velocities());
    assert!((v - DVec3::X).length() < 0.01, "{v}");
}

#[test]
fn what_begins_inside_comes_out_without_haste() {
    let mut cloth = sheet(10, 0.3, DVec3::new(0.0, 0.2, 0.0));
    let fall = 9.81 * 3.0;
    run(&mut cloth, &[ball()], 180, |cloth| assert!(fastest(cloth) < fall));
    assert!(cloth.positions().iter().all(|x| x.length() > 0.299));
}

#[test]
fn a_collider_that_is_not_touched_changes_no_bit() {
    let far = Collider::fixed(2, SharedShape::ball(1.0), Pose::at(DVec3::X * 50.0), 0.5);
    let steps = |colliders: &[Collider]| {
        let mut cloth = sheet(8, 0.3, DVec3::ZERO);
        cloth.pin(0, cloth.positions()[0]);
        run(&mut cloth, colliders, 30, |_| {});
        cloth.positions().to_vec()
    };
    assert_eq!(steps(&[]), steps(&[far]));
}

#[test]
fn contact_is_the_same_in_every_run() {
    let drop = || {
        let mut cloth = sheet(12, 0.8, DVec3::new(0.0, 0.31, 0.0));
        run(&mut cloth, &[ball()], 40, |_| {});
        cloth.positions().to_vec()
    };
    assert_eq!(drop(), drop());
}

#[test]
fn a_collider_that_is_nowhere_is_left_out() {
    let mut cloth = sheet(4, 0.2, DVec3::ZERO);
    let nowhere = cloth.set_colliders([Collider { end: Pose::at(DVec3::NAN), ..ball() }]);
    assert_eq!(nowhere, Err(ColliderError::Pose(1)));
    assert!(cloth.colliders().is_empty());
    assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);
}

#[test]
fn a_collider_stands_still_until_it_is_set_again() {
    let mut cloth = sheet(4, 0.2, DVec3::Y);
    let end = Pose::at(DVec3::NEG_Y);
    cloth.set_colliders([Collider { end, ..ball() }]).unwrap();
    cloth.step(DT);
    assert_eq!(cloth.colliders()[0].start, end);
}
