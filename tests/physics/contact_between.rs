//! What of a collider is between the vertices of a cloth, and what is so fast that a step is taken in pieces.

use bevy::math::{DQuat, DVec3, Vec3};
use bevy_cloth::parry3d::shape::{HeightField, SharedShape};
use bevy_cloth::parry3d::utils::Array2;
use bevy_cloth::physics::{Cloth, Collider, Fabric, Pose, SolverSettings, StepOutcome};

use crate::meshes::TestMesh;

const DT: f64 = 1.0 / 60.0;

/// A horizontal square sheet of `n` × `n` vertices.
fn sheet(n: usize, side: f64, centre: DVec3) -> Cloth {
    let mut mesh = TestMesh::sheet(n, n, side, side);
    for x in &mut mesh.positions {
        *x = centre + DVec3::new(x.x - 0.5 * side, 0.0, -x.y - 0.5 * side);
    }
    Cloth::new(mesh.shape(), Fabric::cotton(), SolverSettings::default()).unwrap()
}

fn step(cloth: &mut Cloth, colliders: &[Collider]) -> u32 {
    cloth.set_colliders(colliders.iter().cloned()).unwrap();
    let report = cloth.step(DT);
    assert_eq!(report.outcome, StepOutcome::Accepted);
    report.substeps
}

fn triangles(cloth: &Cloth) -> impl Iterator<Item = [DVec3; 3]> {
    cloth.shape().triangles.iter().map(|triangle| triangle.vertices.map(|v| cloth.positions()[v as usize]))
}

/// Distance of a point from a segment.
fn to_segment(x: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let share = ((x - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    x.distance(a + share * (b - a))
}

#[test]
fn a_corner_holds_a_triangle_up_between_its_vertices() {
    let turn = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::Y);
    let pose = Pose { translation: DVec3::NEG_Y * 0.2 * 3.0_f64.sqrt(), rotation: turn };
    let cuboid = Collider::fixed(1, SharedShape::cuboid(0.2, 0.2, 0.2), pose, 0.5);
    let mut cloth = sheet(6, 0.8, DVec3::new(0.03, 0.02, 0.02));
    for _ in 0..60 {
        step(&mut cloth, core::slice::from_ref(&cuboid));
        // The corner is at the origin: no triangle above or below it may be below it.
        for [a, b, c] in triangles(&cloth) {
            let normal = (b - a).cross(c - a).normalize();
            let inside = |from: DVec3, to: DVec3| (to - from).cross(-from).dot(normal) >= 0.0;
            if inside(a, b) && inside(b, c) && inside(c, a) && a.dot(normal).abs() < 0.1 {
                let above = a.dot(normal) * normal.y.signum();
                assert!(above > 0.0, "{above}: {a} {b} {c}");
            }
        }
    }
    assert!(cloth.contacts().any(|contact| contact.weights.iter().all(|&weight| weight > 0.0)));
}

#[test]
fn a_rod_thinner_than_the_cells_carries_a_sheet() {
    let rod = Collider::fixed(1, SharedShape::capsule_x(1.0, 0.01), Pose::IDENTITY, 0.5);
    let mut cloth = sheet(6, 0.8, DVec3::new(0.0, 0.03, 0.0));
    for _ in 0..60 {
        step(&mut cloth, core::slice::from_ref(&rod));
        let near = triangles(&cloth).flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]);
        let nearest = near.flat_map(|(a, b)| (0..=20).map(move |i| a.lerp(b, 0.05 * f64::from(i))));
        let nearest = nearest.map(|x| to_segment(x, [DVec3::NEG_X, DVec3::X])).fold(1.0, f64::min);
        assert!(nearest > 0.0095, "{nearest}");
    }
    let top = cloth.positions().iter().map(|x| x.y).fold(f64::MIN, f64::max);
    assert!(top > 0.0, "{top}");
}

#[test]
fn forces_of_contact_are_means_over_the_pieces_of_a_step() {
    let mut cloth = sheet(6, 0.3, DVec3::Y * 0.003);
    cloth.set_settings(SolverSettings { substeps: 4, ..SolverSettings::default() });
    let floor = Collider::fixed(7, SharedShape::halfspace(Vec3::Y), Pose::IDENTITY, 0.5);
    for _ in 0..120 {
        assert_eq!(step(&mut cloth, core::slice::from_ref(&floor)), 4);
    }
    let force: DVec3 = cloth.contacts().map(|contact| contact.force).sum();
    let weight = 9.81 * cloth.masses().iter().sum::<f64>();
    assert!((force.y - weight).abs() < 0.02 * weight, "{force} {weight}");
    assert_eq!(cloth.contacts().count(), 36);
}

#[test]
fn a_step_is_taken_in_pieces_while_something_comes_in_fast() {
    let mut cloth = sheet(9, 0.4, DVec3::ZERO);
    let way = [-0.2, -0.04].map(|y| Pose::at(DVec3::Y * y));
    let ball = Collider { end: way[1], ..Collider::fixed(1, SharedShape::ball(0.1), way[0], 0.5) };
    assert!(step(&mut cloth, core::slice::from_ref(&ball)) > 1);
    let deepest = cloth.positions().iter().map(|x| x.distance(way[1].translation) - 0.1).fold(1.0, f64::min);
    assert!(deepest > -1e-6, "{deepest}");
    assert_eq!(step(&mut cloth, &[]), 1);
}

/// How far a collider pushes counts by what it pushes beside: what lands as a whole is not torn.
#[test]
fn a_fast_landing_is_taken_in_pieces_where_it_would_tear() {
    let substeps = |shape: SharedShape, height: f64| {
        let mut cloth = sheet(17, 0.4, DVec3::Y * height);
        let count = cloth.positions().len();
        let positions = cloth.positions().to_vec();
        cloth.set_state(&positions, &vec![DVec3::Y * -10.0; count]);
        step(&mut cloth, &[Collider::fixed(1, shape, Pose::IDENTITY, 0.5)])
    };
    assert_eq!(substeps(SharedShape::halfspace(Vec3::Y), 0.05), 1);
    assert!(substeps(SharedShape::ball(0.1), 0.15) > 1);
}

/// Its vertices kept off, but its coarse triangles were pressed into the ball.
#[test]
fn a_ball_at_fifty_metres_a_second_stays_on_its_side_of_triangles_too() {
    let radius = 0.1;
    let mut cloth = sheet(24, 1.0, DVec3::ZERO);
    let border = |x: f64| x.abs() > 0.499;
    for (vertex, x) in (0..).zip(cloth.positions().to_vec()) {
        if border(x.x) || border(x.z) {
            cloth.pin(vertex, x);
        }
    }
    let place = |step: u32| Pose::at(DVec3::Y * (50.0 * DT * f64::from(step) - 0.5).min(0.3));
    for i in 0..20 {
        let ball = Collider { end: place(i + 1), ..Collider::fixed(1, SharedShape::ball(radius), place(i), 0.5) };
        step(&mut cloth, core::slice::from_ref(&ball));
        let out = |x: DVec3| x.distance(place(i + 1).translation) - f64::from(radius);
        let vertices = cloth.positions().iter().copied().map(out).fold(f64::INFINITY, f64::min);
        let middles =
            triangles(&cloth).flat_map(|[a, b, c]| [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]);
        let faces = middles.map(out).fold(f64::INFINITY, f64::min);
        assert!(vertices > -1e-6 && faces > -0.003, "{i}: {vertices} {faces}");
    }
}

#[test]
fn a_watched_step_is_the_same_and_tells_of_its_pieces() {
    let ways = [-0.2, -0.04].map(|y| Pose::at(DVec3::Y * y));
    let ball = Collider { end: ways[1], ..Collider::fixed(1, SharedShape::ball(0.1), ways[0], 0.5) };
    let (mut watched, mut other) = (sheet(9, 0.4, DVec3::ZERO), sheet(9, 0.4, DVec3::ZERO));
    let mut told = Vec::new();
    watched.set_colliders([ball.clone()]).unwrap();
    let report = watched.step_watched(DT, Some(&mut |share, x| told.push((share, x[40].y))));
    assert_eq!(step(&mut other, &[ball]), report.substeps);
    assert_eq!(watched.positions(), other.positions());
    let shares: Vec<_> = (1..report.substeps).map(|i| f64::from(i) / f64::from(report.substeps)).collect();
    assert!(!shares.is_empty() && told.iter().map(|&(share, _)| share).eq(shares), "{told:?}");
    // The vertex in the middle is pushed up on and on, and ends above where it was told of last.
    assert!(told.is_sorted_by(|a, b| a.1 <= b.1) && told[told.len() - 1].1 < watched.positions()[40].y, "{told:?}");
}

/// The side that goes up over the rod is not kept from it by gravity, which pulls the other way.
#[test]
fn a_strip_slides_off_a_rod_towards_its_longer_side() {
    let (radius, width, cells) = (0.05, 0.1, 50);
    let mesh = TestMesh::sheet(3, cells + 1, width, 1.0);
    let fabric = Fabric { air_drag: 0.0, ..Fabric::isotropic(0.3, 1000.0, 0.0, 1e-6) };
    let mut cloth = Cloth::new(mesh.shape(), fabric, SolverSettings::default()).unwrap();
    // A part of it on one side, then half around the rod, then all the rest.
    let around = radius + 0.003;
    let half = around * core::f64::consts::PI;
    let wrapped = |x: &DVec3| {
        let along = -x.y - 0.08;
        let angle = along.clamp(0.0, half) / around;
        let down = along.min(0.0) - (along - half).max(0.0);
        DVec3::new(-around * angle.cos(), around * angle.sin() + down, x.x)
    };
    let positions: Vec<_> = mesh.positions.iter().map(wrapped).collect();
    cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
    let mut contact = cloth.contact_settings();
    contact.friction = 0.3;
    cloth.set_contact_settings(contact).unwrap();
    let rod = Collider::fixed(1, SharedShape::capsule_z(0.5, radius as f32), Pose::IDENTITY, 0.3);
    let lowest = |cloth: &Cloth| cloth.positions().iter().map(|x| x.y).fold(f64::MAX, f64::min);
    let start = lowest(&cloth);
    for _ in 0..45 {
        step(&mut cloth, core::slice::from_ref(&rod));
    }
    assert!(start - lowest(&cloth) > 0.2, "{}", start - lowest(&cloth));
}

#[test]
fn ground_is_no_shell() {
    let heights = Array2::new(3, 3, vec![0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0]);
    let field = SharedShape::new(HeightField::new(heights, Vec3::new(2.0, 1.0, 2.0)));
    let ground = Collider::fixed(1, field, Pose::IDENTITY, 0.5);
    // Begins a little below the surface, half of it.
    let mut cloth = sheet(8, 0.5, DVec3::new(0.6, 0.02, 0.6));
    for _ in 0..90 {
        step(&mut cloth, core::slice::from_ref(&ground));
    }
    let lowest = cloth.positions().iter().map(|x| x.y).fold(f64::MAX, f64::min);
    assert!(lowest > -1e-4, "{lowest}");
}

/// Contact turns a fast sheet aside, and what it comes to then was not in its way before.
#[test]
fn what_a_fast_sheet_is_turned_to_is_met_between_its_vertices_too() {
    let half = Vec3::new(0.14, 0.2, 1.0);
    let middle = |i: u32| Vec3::new(0.28 * i as f32, -0.18 * i as f32 - 0.2, 0.0);
    let stair = |i: u32| {
        (bevy_cloth::parry3d::math::Pose::from_translation(middle(i)), SharedShape::cuboid(half.x, half.y, half.z))
    };
    let stairs = Collider::fixed(0, SharedShape::compound((0..4).map(stair).collect()), Pose::IDENTITY, 0.3);
    let mut cloth = sheet(24, 1.0, DVec3::new(0.3, 0.4, 0.0));
    cloth.set_fabric(Fabric::isotropic(0.15, 1000.0, 0.3, 1e-5)).unwrap();
    let places = cloth.positions().to_vec();
    cloth.set_state(&places, &vec![DVec3::new(1.0, -5.0, 0.2); places.len()]);
    for _ in 0..40 {
        step(&mut cloth, core::slice::from_ref(&stairs));
        for [a, b, c] in triangles(&cloth) {
            let shares = (0..=8).flat_map(|i| (0..=8 - i).map(move |j| [i, j].map(|k| f64::from(k) / 8.0)));
            for [u, v] in shares {
                let x = a + u * (b - a) + v * (c - a);
                let depth = |i: u32| -((x - middle(i).as_dvec3()).abs() - half.as_dvec3()).max_element();
                let depth = (0..4).map(depth).fold(f64::NEG_INFINITY, f64::max);
                assert!(depth < 0.003, "{depth} at {x}");
            }
        }
    }
}
