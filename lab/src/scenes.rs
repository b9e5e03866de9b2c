//! Scenes that others have been measured on too.

use bevy::asset::RenderAssetUsages;
use bevy::math::DVec3;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
use bevy_cloth::physics::{BendingModel, Cloth, Fabric, RestShape, RestShapeOptions, SolverSettings, SurfaceMesh};
use rand::rngs::StdRng;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use serde::Serialize;

/// Length of a frame, s.
pub const DT: f64 = 1.0 / 60.0;

/// How far an inner vertex of an irregular mesh is off its place in the grid, at most, along either axis, in cells.
const JITTER: f64 = 0.3;

/// The fabric of the hung sheet: E·t = 1000 N/m, ν = 0.3, D = 1e-5 N·m, 0.15 kg/m², with the damping and air drag that
/// [`Fabric::isotropic`] comes with.
pub fn fabric() -> Fabric {
    Fabric::isotropic(0.15, 1000.0, 0.3, 1e-5)
}

/// How a sheet is meshed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Meshing {
    /// A grid of squares, all halved along the same diagonal, numbered row by row.
    Grid,
    /// The grid with its inner vertices moved and its diagonals chosen at random.
    Irregular,
    /// The irregular mesh with its vertices and triangles in random order, as a file may have them.
    Shuffled,
}

/// A flat, horizontal square of 1 m × 1 m in the plane y = 0.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// m.
    pub positions: Vec<DVec3>,
    /// Texture coordinates: the place in the sheet.
    pub uvs: Vec<[f32; 2]>,
    /// Counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
    /// The two corners that hold it.
    pub corners: [u32; 2],
    /// The edge opposite the corners.
    pub free_edge: Vec<u32>,
}

impl Sheet {
    /// A sheet of n × n vertices; random choices are the same every time.
    ///
    /// # Panics
    /// If n < 2.
    pub fn new(n: u32, meshing: Meshing) -> Self {
        assert!(n >= 2, "a sheet has two vertices a side or more");
        let mut random = StdRng::seed_from_u64(u64::from(n));
        let irregular = meshing != Meshing::Grid;
        let cell = 1.0 / f64::from(n - 1);

        let mut positions = Vec::new();
        for (row, column) in (0..n).flat_map(|row| (0..n).map(move |column| (row, column))) {
            let inner = [row, column].iter().all(|&i| i > 0 && i < n - 1);
            let mut coordinate = |index: u32| {
                let off = if irregular && inner { random.random_range(-JITTER..=JITTER) } else { 0.0 };
                (f64::from(index) + off) * cell
            };
            positions.push(DVec3::new(coordinate(column), 0.0, coordinate(row)));
        }
        let mut triangles = Vec::new();
        for (row, column) in (0..n - 1).flat_map(|row| (0..n - 1).map(move |column| (row, column))) {
            let a = row * n + column;
            let [b, c, d] = [a + 1, a + n, a + n + 1];
            let other_diagonal = irregular && random.random();
            triangles.extend(if other_diagonal { [[a, c, d], [a, d, b]] } else { [[a, c, b], [b, c, d]] });
        }

        let mut order: Vec<u32> = (0..n * n).collect();
        if meshing == Meshing::Shuffled {
            order.shuffle(&mut random);
            triangles.shuffle(&mut random);
        }
        let mut placed = vec![DVec3::ZERO; positions.len()];
        for (position, &vertex) in positions.iter().zip(&order) {
            placed[vertex as usize] = *position;
        }
        Self {
            uvs: placed.iter().map(|p| [p.x as f32, p.z as f32]).collect(),
            positions: placed,
            triangles: triangles.into_iter().map(|triangle| triangle.map(|v| order[v as usize])).collect(),
            corners: [0, n - 1].map(|v| order[v as usize]),
            free_edge: order[(n * (n - 1)) as usize..].to_vec(),
        }
    }

    /// The sheet at rest.
    pub fn shape(&self, bending: BendingModel) -> RestShape {
        let mesh = SurfaceMesh { positions: &self.positions, triangles: &self.triangles, uvs: Some(&self.uvs) };
        let options = RestShapeOptions { bending, ..Default::default() };
        RestShape::new(&mesh, &options).expect("a sheet is a valid mesh")
    }

    /// The vertices of a cloth of this sheet whose places in it are in question.
    pub fn vertices(&self, cloth: &Cloth, which: impl Fn(DVec3) -> bool) -> Vec<u32> {
        let places = self.positions.iter().zip(&cloth.shape().simulated);
        places.filter(|(place, _)| which(**place)).filter_map(|(_, simulated)| *simulated).collect()
    }

    /// The sheet as an asset, with the attributes of an ordinary mesh.
    pub fn mesh(&self) -> Mesh {
        let positions: Vec<_> = self.positions.iter().map(|p| p.as_vec3().to_array()).collect();
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; positions.len()])
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, self.uvs.clone())
            .with_inserted_indices(Indices::U32(self.triangles.as_flattened().to_vec()))
    }

    /// The sheet as cloth, held by its two corners, at rest, under standard gravity.
    pub fn hang(&self, settings: SolverSettings) -> Cloth {
        let shape = self.shape(BendingModel::default());
        let corners = self.corners.map(|v| shape.simulated[v as usize].expect("every vertex has a triangle"));
        let mut cloth = Cloth::new(shape, fabric(), settings).expect("the fabric is valid");
        for vertex in corners {
            cloth.pin(vertex, cloth.positions()[vertex as usize]);
        }
        cloth
    }

    /// How far the free edge of a cloth of this sheet is below where it began, on average, m.
    pub fn fall(&self, cloth: &Cloth) -> f64 {
        let heights = self.free_edge.iter().filter_map(|&v| cloth.shape().simulated[v as usize]);
        -heights.map(|v| cloth.positions()[v as usize].y).sum::<f64>() / self.free_edge.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_meshing_covers_the_square_and_faces_up() {
        for meshing in [Meshing::Grid, Meshing::Irregular, Meshing::Shuffled] {
            let sheet = Sheet::new(9, meshing);
            assert_eq!((sheet.positions.len(), sheet.triangles.len()), (81, 128));
            let areas = sheet.triangles.iter().map(|triangle| {
                let [a, b, c] = triangle.map(|v| sheet.positions[v as usize]);
                0.5 * (b - a).cross(c - a).y
            });
            assert!(areas.clone().all(|area| area > 0.0), "{meshing:?}");
            assert!((areas.sum::<f64>() - 1.0).abs() < 1e-12, "{meshing:?}");
            assert_eq!(sheet.corners.map(|v| sheet.positions[v as usize]), [DVec3::ZERO, DVec3::X]);
            assert!(sheet.free_edge.iter().all(|&v| sheet.positions[v as usize].z == 1.0), "{meshing:?}");
        }
    }

    #[test]
    fn a_hung_sheet_has_its_mass_and_two_pins() {
        let cloth = Sheet::new(6, Meshing::Shuffled).hang(SolverSettings::default());
        assert!((cloth.masses().iter().sum::<f64>() - 0.15).abs() < 1e-8);
        assert_eq!(cloth.pinned().count(), 2);
    }
}
