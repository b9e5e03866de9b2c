//! Meshes and states for the tests.

use bevy::math::DVec3;
use bevy_cloth::physics::{RestShape, RestShapeOptions, SurfaceMesh};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

pub struct TestMesh {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    pub uvs: Vec<[f32; 2]>,
}

impl TestMesh {
    /// `n` × `m` vertices over `width` (along X) × `height` (along −Y), row 0 at the top, u along X and v along −Y. The
    /// diagonals alternate.
    pub fn sheet(n: usize, m: usize, width: f64, height: f64) -> Self {
        let (mut positions, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..m {
            for column in 0..n {
                let (s, t) = (column as f64 / (n - 1) as f64, row as f64 / (m - 1) as f64);
                positions.push(DVec3::new(s * width, -t * height, 0.0));
                uvs.push([s as f32, t as f32]);
            }
        }
        for row in 0..m - 1 {
            for column in 0..n - 1 {
                let [a, b, c, d] = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(r, s)| ((row + r) * n + column + s) as u32);
                if (row + column) % 2 == 0 {
                    triangles.extend([[a, c, b], [b, c, d]]);
                } else {
                    triangles.extend([[a, c, d], [a, d, b]]);
                }
            }
        }
        Self { positions, triangles, uvs }
    }

    /// The same with interior vertices moved by up to `amount` of the spacing, in the plane; texture coordinates follow.
    pub fn jittered(n: usize, m: usize, width: f64, height: f64, amount: f64) -> Self {
        let mut mesh = Self::sheet(n, m, width, height);
        let mut rng = rng(7);
        let spacing = DVec3::new(width / (n - 1) as f64, height / (m - 1) as f64, 0.0);
        for row in 1..m - 1 {
            for column in 1..n - 1 {
                let vertex = row * n + column;
                mesh.positions[vertex] += amount * spacing * random_vector(&mut rng);
                let p = mesh.positions[vertex];
                mesh.uvs[vertex] = [(p.x / width) as f32, (-p.y / height) as f32];
            }
        }
        mesh
    }

    pub fn shape(&self) -> RestShape {
        self.shape_with(&RestShapeOptions::default())
    }

    pub fn shape_with(&self, options: &RestShapeOptions) -> RestShape {
        let mesh = SurfaceMesh { positions: &self.positions, triangles: &self.triangles, uvs: Some(&self.uvs) };
        RestShape::new(&mesh, options).expect("a valid test mesh")
    }
}

pub fn rng(seed: u64) -> StdRng {
    StdRng::seed_from_u64(seed)
}

/// Components in [−1, 1].
pub fn random_vector(rng: &mut StdRng) -> DVec3 {
    DVec3::from_array(core::array::from_fn(|_| rng.random_range(-1.0..1.0)))
}

/// `positions` moved by up to `amount` in each direction.
pub fn crumpled(positions: &[DVec3], amount: f64, seed: u64) -> Vec<DVec3> {
    let mut rng = rng(seed);
    positions.iter().map(|&p| p + amount * random_vector(&mut rng)).collect()
}
