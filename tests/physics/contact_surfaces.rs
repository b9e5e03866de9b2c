//! Contact with meshes of triangles that have no inside: level ground, hills, stairs, domes, ceilings.

use bevy::math::{DQuat, DVec3, Vec3};
use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::physics::{Cloth, Collider, Fabric, Pose, SolverSettings, StepOutcome};
use bevy_cloth::plugin::{ClothCollider, ClothColliderKind};

use crate::meshes::TestMesh;

const DT: f64 = 1.0 / 60.0;

type Triangles = (Vec<Vec3>, Vec<[u32; 3]>);

/// A square sheet of `side` m, `cells` cells along each, level before it is turned.
fn sheet(cells: usize, side: f64, centre: DVec3, turn: DQuat) -> Cloth {
    let mut mesh = TestMesh::sheet(cells + 1, cells + 1, side, side);
    for x in &mut mesh.positions {
        *x = centre + turn * DVec3::new(x.x - 0.5 * side, 0.0, -x.y - 0.5 * side);
    }
    Cloth::new(mesh.shape(), Fabric::cotton(), SolverSettings::default()).unwrap()
}

fn tilted() -> DQuat {
    DQuat::from_rotation_x(0.3) * DQuat::from_rotation_z(0.2)
}

/// Ground over a square of `side` m.
fn ground(cells: usize, side: f32, height: impl Fn(f32, f32) -> f32) -> Triangles {
    let n = cells + 1;
    let at = |i: usize| side * (i as f32 / cells as f32 - 0.5);
    let places = (0..n * n).map(|i| (at(i % n), at(i / n)));
    let vertices = places.map(|(x, z)| Vec3::new(x, height(x, z), z)).collect();
    let corners = (0..cells * cells).map(|i| (i / cells * n + i % cells) as u32);
    let n = n as u32;
    (vertices, corners.flat_map(|a| [[a, a + n, a + 1], [a + 1, a + n, a + n + 1]]).collect())
}

fn flat(cells: usize, side: f32) -> Triangles {
    ground(cells, side, |_, _| 0.0)
}

/// As many faces again, seen from behind.
fn doubled((vertices, mut triangles): Triangles) -> Triangles {
    triangles.extend(triangles.clone().into_iter().map(|[a, b, c]| [a, c, b]));
    (vertices, triangles)
}

/// A ball of 0.3 m, or its upper half.
fn ball(half: bool) -> Triangles {
    let (vertices, mut triangles) = parry3d_ball();
    if half {
        triangles.retain(|triangle| triangle.iter().all(|&vertex| vertices[vertex as usize].y > -1e-3));
    }
    (vertices, triangles)
}

fn parry3d_ball() -> Triangles {
    SharedShape::ball(0.3).as_ball().expect("a ball").to_trimesh(24, 24)
}

fn collider((vertices, triangles): Triangles) -> ClothCollider {
    ClothCollider::trimesh(vertices, triangles).expect("a shape")
}

fn fixed(collider: &ClothCollider) -> Collider {
    Collider::fixed(1, collider.shape().clone(), Pose::IDENTITY, 0.5)
}

fn run(cloth: &mut Cloth, collider: &ClothCollider, steps: u32) {
    cloth.set_colliders([fixed(collider)]).unwrap();
    for _ in 0..steps {
        assert_eq!(cloth.step(DT).outcome, StepOutcome::Accepted);
    }
}

fn fastest(cloth: &Cloth) -> f64 {
    cloth.velocities().iter().map(|v| v.length()).fold(0.0, f64::max)
}

fn lowest(cloth: &Cloth) -> f64 {
    cloth.positions().iter().map(|x| x.y).fold(f64::MAX, f64::min)
}

/// The way of each vertex is straight across a triangle: as long as both distances, but for rounding. Found by field report F2a.
#[test]
fn a_level_sheet_lies_on_a_level_plane() {
    for cells in [1, 3, 8, 20] {
        let (vertices, triangles) = flat(cells, 3.0);
        let two_sided = SharedShape::trimesh(vertices.clone(), triangles.clone()).unwrap();
        let one_sided = collider((vertices, triangles));
        assert_eq!(one_sided.kind(), ClothColliderKind::OneSided);
        for ground in [one_sided, ClothCollider::new(two_sided), collider(doubled(flat(cells, 3.0)))] {
            for height in [0.02, 0.2, 1.0, 1.7] {
                let mut cloth = sheet(14, 1.0, DVec3::Y * height, DQuat::IDENTITY);
                run(&mut cloth, &ground, 90);
                let (lowest, fastest) = (lowest(&cloth), fastest(&cloth));
                let what = format!("{cells} {height} {:?}: {lowest} m, {fastest} m/s", ground.kind());
                assert!(lowest > 0.0 && fastest < 0.01, "{what}");
            }
        }
    }
}

fn noise(x: f32, z: f32) -> f32 {
    let hash = |i: i32, j: i32| (((i * 73_856_093) ^ (j * 19_349_663)).rem_euclid(1009)) as f32 / 1009.0;
    hash((8.0 * x).round() as i32, (8.0 * z).round() as i32)
}

/// Found by field report F2b: as a shell, they tear cloth about for good.
#[test]
fn uneven_open_ground_lets_cloth_rest() {
    let wave = |x: f32| (x * core::f32::consts::TAU / 1.2).sin();
    let cases = [
        ("random, 1 m cells", ground(4, 4.0, |x, z| 0.3 * noise(x, z)), 0.8, 0.02),
        ("random, 50 cm cells", ground(8, 4.0, |x, z| 0.1 * noise(x, z)), 0.8, 0.02),
        ("hills of 10 cm", ground(40, 4.0, |x, z| 0.05 * wave(x) * wave(z)), 0.8, 0.05),
        ("a dome", ball(true), 0.45, 0.05),
    ];
    for (what, triangles, height, rest) in cases {
        let ground = collider(triangles);
        assert_eq!(ground.kind(), ClothColliderKind::OneSided, "{what}");
        let mut cloth = sheet(24, 1.2, DVec3::new(0.03, height, 0.02), tilted());
        run(&mut cloth, &ground, 480);
        let speed = fastest(&cloth);
        assert!(speed < rest, "{what}: {speed} m/s");
        if what != "a dome" {
            assert!(lowest(&cloth) > -0.06, "{what}: {} m", lowest(&cloth));
        }
    }
}

/// What is behind a surface that is solid from one side, or beside its rim, is as if that were not there.
#[test]
fn cloth_behind_a_sheet_or_beside_its_rim_is_left_alone() {
    let turned = DQuat::from_rotation_x(core::f64::consts::FRAC_PI_2);
    let table = collider(flat(1, 2.0));
    let cases = [
        // Hung below, upright and level, near and far, in the middle and at the rim.
        (DVec3::new(0.0, -0.52, 0.0), turned),
        (DVec3::new(0.0, -0.505, 0.7), turned),
        (DVec3::new(0.0, -0.02, 0.0), DQuat::IDENTITY),
        (DVec3::new(0.8, -0.3, 0.6), tilted()),
        // Beside it.
        (DVec3::new(0.0, -0.3, 1.02), turned),
    ];
    for (centre, turn) in cases {
        let drape = |colliders: bool| {
            let mut cloth = sheet(12, 1.0, centre, turn);
            for vertex in [0, 12] {
                cloth.pin(vertex, cloth.positions()[vertex as usize]);
            }
            if colliders {
                run(&mut cloth, &table, 60);
            } else {
                for _ in 0..60 {
                    cloth.step(DT);
                }
            }
            cloth.positions().to_vec()
        };
        let [with, without] = [drape(true), drape(false)];
        let furthest = with.iter().zip(&without).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(furthest < 1e-3, "{centre}: {furthest} m");
    }
}

#[test]
fn a_cloth_hangs_over_the_edges_of_a_table_of_one_layer() {
    let table = collider(flat(1, 0.6));
    let mut cloth = sheet(16, 1.0, DVec3::new(0.02, 0.1, 0.01), DQuat::from_rotation_y(0.3));
    run(&mut cloth, &table, 480);
    let over = |x: &&DVec3| x.x.abs() < 0.25 && x.z.abs() < 0.25;
    let middle = cloth.positions()[8 * 17 + 8];
    // It lies in folds.
    assert!((0.0..0.05).contains(&middle.y), "{middle}");
    let top = cloth.positions().iter().filter(over).filter(|x| x.y > 0.0).count();
    assert!(top > 40 && lowest(&cloth) < -0.1, "{top} {}", lowest(&cloth));
    assert!(fastest(&cloth) < 0.3, "{} m/s", fastest(&cloth));
}

/// Found by field report F5.
#[test]
fn doubled_faces_are_a_solid_or_a_surface_with_two_sides() {
    let solid = collider(doubled(ball(false)));
    let shell = collider(doubled(flat(8, 3.0)));
    assert_eq!((solid.kind(), shell.kind()), (ClothColliderKind::Solid, ClothColliderKind::TwoSided));
    assert!(solid.shape().contains_local_point(Vec3::new(0.1, 0.05, 0.02)));
    // The same with the inner faces first.
    let (vertices, triangles) = doubled(ball(false));
    let inner = collider((vertices, triangles.into_iter().rev().collect()));
    assert!(inner.shape().contains_local_point(Vec3::new(0.1, 0.05, 0.02)));
    let mut cloth = sheet(20, 0.8, DVec3::new(0.0, 0.35, 0.0), DQuat::IDENTITY);
    run(&mut cloth, &solid, 360);
    assert!(fastest(&cloth) < 0.1 && cloth.positions().iter().all(|x| x.length() > 0.29), "{}", fastest(&cloth));
}

/// Found by field report F7: a few that are wound the other way are taken as turned.
#[test]
fn turned_faces_are_turned_back() {
    for every in [2, 3, 1000] {
        for (triangles, kind) in [(ball(false), ClothColliderKind::Solid), (flat(8, 3.0), ClothColliderKind::OneSided)]
        {
            let (vertices, mut triangles) = triangles;
            triangles.iter_mut().step_by(every).for_each(|[_, b, c]| core::mem::swap(b, c));
            let collider = collider((vertices, triangles));
            assert_eq!(collider.kind(), kind, "{every}");
            if kind == ClothColliderKind::Solid {
                assert!(collider.shape().contains_local_point(Vec3::new(0.1, 0.05, 0.02)), "{every}");
            }
        }
    }
    // A room: nothing is turned, it is said in the log.
    let (vertices, triangles) = ball(false);
    let room = collider((vertices, triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect()));
    assert_eq!(room.kind(), ClothColliderKind::Solid);
    assert!(!room.shape().contains_local_point(Vec3::ZERO) && room.shape().contains_local_point(Vec3::X));
}
