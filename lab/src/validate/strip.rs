//! A rectangle of cloth in the plane y = 0, along x from its beginning at 0.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, RestShape, RestShapeOptions, SolverSettings, SurfaceMesh};

/// Cells along and across a rectangle.
#[derive(Clone, Copy, Debug)]
pub struct Strip {
    /// m.
    pub length: f64,
    /// m.
    pub width: f64,
    /// Cells along it.
    pub along: u32,
    /// Cells across it.
    pub across: u32,
}

impl Strip {
    /// At rest, in the plane. All squares are halved along the same diagonal.
    pub fn cloth(&self, fabric: Fabric, settings: SolverSettings) -> Cloth {
        let (columns, rows) = (self.along + 1, self.across + 1);
        let place = |i: u32| {
            let (column, row) = (i % columns, i / columns);
            let x = self.length * f64::from(column) / f64::from(self.along);
            DVec3::new(x, 0.0, self.width * f64::from(row) / f64::from(self.across))
        };
        let positions: Vec<_> = (0..columns * rows).map(place).collect();
        let cells = (0..self.across).flat_map(|row| (0..self.along).map(move |column| row * columns + column));
        let triangles: Vec<_> =
            cells.flat_map(|a| [[a, a + columns, a + 1], [a + 1, a + columns, a + columns + 1]]).collect();
        let mesh = SurfaceMesh { positions: &positions, triangles: &triangles, uvs: None };
        let shape = RestShape::new(&mesh, &RestShapeOptions::default()).expect("a strip is a valid mesh");
        Cloth::new(shape, fabric, settings).expect("the fabric is valid")
    }
}

/// Puts a flat cloth elsewhere, at rest.
pub fn place(cloth: &mut Cloth, to: impl Fn(DVec3) -> DVec3) {
    let positions: Vec<_> = cloth.shape().positions.iter().map(|&x| to(x)).collect();
    cloth.set_state(&positions, &vec![DVec3::ZERO; positions.len()]);
}

/// Holds the vertices whose rest positions are in question where they are now.
pub fn pin(cloth: &mut Cloth, which: impl Fn(DVec3) -> bool) {
    for vertex in vertices(cloth, which) {
        cloth.pin(vertex, cloth.positions()[vertex as usize]);
    }
}

/// The vertices whose rest positions are in question.
pub fn vertices(cloth: &Cloth, which: impl Fn(DVec3) -> bool) -> Vec<u32> {
    let all = 0..cloth.masses().len() as u32;
    all.filter(|&vertex| which(cloth.shape().positions[vertex as usize])).collect()
}

/// Where these vertices are on average, m.
pub fn mean(cloth: &Cloth, vertices: &[u32]) -> DVec3 {
    vertices.iter().map(|&vertex| cloth.positions()[vertex as usize]).sum::<DVec3>() / vertices.len() as f64
}

/// Steps for so many seconds.
pub fn run(cloth: &mut Cloth, dt: f64, seconds: f64) {
    for _ in 0..(seconds / dt).round() as u32 {
        cloth.step(dt);
    }
}
