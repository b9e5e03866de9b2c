//! Bending against the rigidity asked for, in every direction and on every mesh.

use bevy::math::DVec3;
use bevy_cloth::physics::{BendingModel, Cloth, Fabric, RestShapeOptions, SolverSettings};

use crate::meshes::TestMesh;

/// Far larger than the sheet.
const RADIUS: f64 = 100.0;

/// Bending energy of a sheet bent to a cylinder whose axis is across `direction`, over that of a sheet of the rigidity asked for, as
/// if it were larger by so many cells: what is lost at its edges is left out.
fn rigidity(mesh: &dyn Fn(usize) -> TestMesh, fabric: Fabric, bending: BendingModel, direction: f64) -> f64 {
    // e N² + b N + c cells' worth of energy: what is left of three sizes is e.
    let [small, middle, large] = [12, 24, 36].map(|cells| energy(&mesh(cells), fabric, bending, direction));
    (small - 2.0 * middle + large) / (2.0 * 12.0 * 12.0)
}

/// In the energy of a cell of 1 m².
fn energy(mesh: &TestMesh, fabric: Fabric, bending: BendingModel, direction: f64) -> f64 {
    let shape = mesh.shape_with(&RestShapeOptions { bending, ..Default::default() });
    let mut cloth = Cloth::new(shape, fabric, SolverSettings::reference()).unwrap();
    // From the warp (X) towards the weft (−Y).
    let along = DVec3::new(direction.cos(), -direction.sin(), 0.0);
    let bend = |x: &DVec3| {
        let s = x.dot(along);
        let angle = s / RADIUS;
        *x + along * (RADIUS * angle.sin() - s) + DVec3::Z * RADIUS * (1.0 - angle.cos())
    };
    let positions: Vec<_> = cloth.shape().positions.iter().map(bend).collect();
    cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
    2.0 * RADIUS * RADIUS * cloth.energy().bending / fabric.bending_along(direction)
}

#[test]
fn mid_edge_normals_have_the_rigidity_of_the_fabric_in_every_direction() {
    let isotropic = Fabric::isotropic(0.15, 1e3, 0.0, 1e-3);
    let fabrics = [
        isotropic,
        Fabric { bending_poisson: 0.3, ..isotropic },
        Fabric { warp_bending: 4e-3, weft_bending: 1e-3, bias_bending: 1.5e-3, ..isotropic },
    ];
    let alternating = |n: usize| TestMesh::sheet(n + 1, n + 1, n as f64, n as f64);
    let jittered = |n: usize| TestMesh::jittered(n + 1, n + 1, n as f64, n as f64, 0.3);
    let narrow = |n: usize| TestMesh::sheet(2 * n + 1, n + 1, n as f64, n as f64);
    let meshes: [(&str, &dyn Fn(usize) -> TestMesh); 3] =
        [("alternating", &alternating), ("jittered", &jittered), ("cells of 1 : 2", &narrow)];
    for fabric in fabrics {
        for (name, mesh) in meshes {
            for direction in [0.0, 22.5, 45.0, 90.0, 135.0_f64] {
                let ratio = rigidity(mesh, fabric, BendingModel::MidEdge, direction.to_radians());
                // Jittered meshes of three sizes are not quite parts of one.
                assert!((ratio - 1.0).abs() < 2e-2, "{name}, {direction}°: {ratio}");
            }
        }
    }
}

#[test]
fn hinges_are_stiffer_across_diagonals() {
    let alternating = |n: usize| TestMesh::sheet(n + 1, n + 1, n as f64, n as f64);
    let fabric = Fabric::isotropic(0.15, 1e3, 0.0, 1e-3);
    let [straight, diagonal] = [0.0, core::f64::consts::FRAC_PI_4]
        .map(|direction| rigidity(&alternating, fabric, BendingModel::Hinge, direction));
    assert!((straight - 1.0).abs() < 1e-3 && (diagonal - 1.5).abs() < 1e-3, "{straight} {diagonal}");
}
