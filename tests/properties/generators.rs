//! Random surfaces, fabrics and motions.

use bevy::math::{DAffine3, DMat3, DQuat, DVec3};
use bevy_cloth::physics::{
    BendingModel, Cloth, Fabric, Integrator, RestShape, RestShapeOptions, SolverSettings, SurfaceMesh,
};
use proptest::prelude::*;

/// A surface mesh.
#[derive(Clone, Debug)]
pub struct Surface {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    pub uvs: Option<Vec<[f32; 2]>>,
}

impl Surface {
    pub fn mesh(&self) -> SurfaceMesh<'_> {
        SurfaceMesh { positions: &self.positions, triangles: &self.triangles, uvs: self.uvs.as_deref() }
    }

    pub fn shape(&self) -> RestShape {
        RestShape::new(&self.mesh(), &RestShapeOptions::default()).expect("a valid surface")
    }

    pub fn cloth(&self, fabric: Fabric, settings: SolverSettings) -> Cloth {
        Cloth::new(self.shape(), fabric, settings).expect("a valid fabric")
    }
}

/// Even over the logarithm.
fn logarithmic(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

/// Components in [−1, 1].
pub fn vector() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(|v: [f64; 3]| DVec3::from_array(v))
}

pub fn vectors(count: usize) -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec(vector(), count)
}

/// A turn and a shift of up to 10 m.
pub fn rigid_motion() -> impl Strategy<Value = DAffine3> {
    (vector(), 0.0..core::f64::consts::TAU, vector()).prop_map(|(axis, angle, shift)| {
        let turn = DQuat::from_axis_angle(axis.try_normalize().unwrap_or(DVec3::X), angle);
        DAffine3::from_mat3_translation(DMat3::from_quat(turn), 10.0 * shift)
    })
}

/// A curved, uneven sheet of 3 × 3 to 7 × 7 vertices, 0.1 m to 3 m a side, with random diagonals.
pub fn surface() -> impl Strategy<Value = Surface> {
    let size = (3_usize..8, 3_usize..8, logarithmic(0.1, 3.0), logarithmic(0.1, 3.0));
    size.prop_flat_map(|(columns, rows, width, height)| {
        let diagonals = prop::collection::vec(any::<bool>(), (columns - 1) * (rows - 1));
        (vectors(columns * rows), diagonals, any::<bool>()).prop_map(move |(off, diagonals, with_uvs)| {
            let place = |vertex: usize| {
                let (u, v) = ((vertex % columns) as f64, (vertex / columns) as f64);
                let cell = DVec3::new(width / (columns - 1) as f64, height / (rows - 1) as f64, 0.0);
                let bulge = 0.2 * width.min(height) * (u + 0.7 * v).sin();
                cell * DVec3::new(u, v, 0.0) + 0.25 * cell * off[vertex] + bulge * DVec3::Z
            };
            let cells = (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| row * columns + column));
            let triangles = cells.zip(&diagonals).flat_map(|(a, &diagonal)| {
                let [a, b, c, d] = [a, a + 1, a + columns, a + columns + 1].map(|v| v as u32);
                if diagonal { [[a, b, d], [a, d, c]] } else { [[a, b, c], [b, d, c]] }
            });
            let uv = |vertex: usize| [(vertex % columns) as f32, (vertex / columns) as f32];
            Surface {
                positions: (0..columns * rows).map(place).collect(),
                triangles: triangles.collect(),
                uvs: with_uvs.then(|| (0..columns * rows).map(uv).collect()),
            }
        })
    })
}

/// A fabric like those that exist.
pub fn ordinary_fabric() -> impl Strategy<Value = Fabric> {
    let fabrics: Vec<_> = Fabric::presets().map(|(_, fabric)| fabric).collect();
    prop::sample::select(fabrics)
}

/// Any fabric that is valid.
pub fn any_fabric() -> impl Strategy<Value = Fabric> {
    prop::array::uniform11(0.0..1.0_f64).prop_map(|shares| {
        let logarithmic = |i: usize, from: f64, to: f64| (from * (to / from).powf(shares[i])) as f32;
        let signed = |i: usize| (2.0 * shares[i] - 1.0) as f32;
        let (warp_stiffness, weft_stiffness) = (logarithmic(0, 1e-3, 1e9), logarithmic(1, 1e-3, 1e9));
        Fabric {
            density: logarithmic(2, 1e-4, 1e2),
            warp_stiffness,
            weft_stiffness,
            coupling: signed(3) * warp_stiffness.sqrt() * weft_stiffness.sqrt(),
            shear_stiffness: logarithmic(4, 1e-3, 1e9),
            warp_bending: logarithmic(5, 1e-9, 1.0),
            weft_bending: logarithmic(6, 1e-9, 1.0),
            bias_bending: logarithmic(7, 1e-9, 1.0),
            bending_poisson: signed(8),
            damping: logarithmic(9, 1e-4, 10.0),
            air_drag: logarithmic(10, 1e-2, 10.0),
        }
    })
}

pub fn any_bending() -> impl Strategy<Value = BendingModel> {
    prop::sample::select(vec![BendingModel::MidEdge, BendingModel::Hinge, BendingModel::None])
}

pub fn any_integrator() -> impl Strategy<Value = Integrator> {
    prop::sample::select(vec![Integrator::Bdf2, Integrator::BackwardEuler])
}

/// From 1 ms to 1 s.
pub fn any_step() -> impl Strategy<Value = f64> {
    logarithmic(1e-3, 1.0)
}
