//! Contact with the world.

use bevy::math::DVec3;
use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::physics::{Cloth, Collider, Fabric, Pose, SolverSettings};

use crate::meshes::TestMesh;

/// The fabric of the drop of a sheet on a ball: 1000 N/m.
fn membrane() -> Fabric {
    Fabric::isotropic(0.15, 1000.0, 0.3, 1e-5)
}

/// A horizontal square sheet of `n` × `n` vertices.
fn sheet(n: usize, side: f64, centre: DVec3) -> Cloth {
    let mut mesh = TestMesh::sheet(n, n, side, side);
    for x in &mut mesh.positions {
        *x = centre + DVec3::new(x.x - 0.5 * side, 0.0, -x.y - 0.5 * side);
    }
    let fabric = if std::env::var("COTTON").is_ok() { Fabric::cotton() } else { membrane() };
    Cloth::new(mesh.shape(), fabric, SolverSettings::default()).unwrap()
}

fn fastest(cloth: &Cloth) -> f64 {
    cloth.velocities().iter().map(|v| v.length()).fold(0.0, f64::max)
}

#[test]
fn probe_drop() {
    let n = std::env::var("N").ok().and_then(|n| n.parse().ok()).unwrap_or(32);
    let mut cloth = sheet(n, 1.0, DVec3::new(0.0, 0.35, 0.0));
    let ball = Collider::fixed(1, SharedShape::ball(0.3), Pose::IDENTITY, 0.5);
    for frame in 0..600 {
        cloth.set_colliders([ball.clone()]);
        let r = cloth.step(1.0 / 60.0);
        let gap = cloth.positions().iter().map(|x| x.length() - 0.3).fold(f64::MAX, f64::min);
        if frame < 40 || frame % 20 == 0 {
            println!(
                "{frame} {:?} it {} fb {} cl {} cs {} re {} gap {:.5} fast {:.5} touching {:.5} contacts {} rms {:.3} t {:.2} c {:.2}",
                r.outcome,
                r.iterations,
                r.fallbacks,
                r.velocity_clamps,
                r.contact_solves,
                r.rescues,
                gap,
                fastest(&cloth),
                cloth.contacts().map(|c| cloth.velocities()[c.vertices[0] as usize].length()).fold(0.0, f64::max),
                cloth.contacts().count(),
                cloth.stretch().rms * 100.0,
                r.total.as_secs_f64() * 1e3,
                r.contact.as_secs_f64() * 1e3
            );
        }
    }
}
