//! A rectangle of cloth in the plane y = 0, along x from its beginning at 0.

use bevy::math::DVec3;
use bevy_cloth::physics::{
    BendingModel, Cloth, Fabric, Integrator, Precision, RestShape, RestShapeOptions, SolverKind, SolverSettings,
    SurfaceMesh,
};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

/// How a rectangle is meshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Squares, all halved along the same diagonal.
    OneDiagonal,
    /// Squares, halved along either diagonal in turns.
    Alternating,
    /// Like `Alternating`, with inner vertices moved at random by so much of a cell at most, along either axis.
    Jittered(f64),
    /// Triangles of equal sides, as long as a cell; the ends are ragged.
    Equilateral,
}

impl Pattern {
    /// What tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneDiagonal => "one diagonal",
            Self::Alternating => "alternating",
            Self::Jittered(_) => "jittered",
            Self::Equilateral => "equilateral",
        }
    }
}

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
    /// How it is meshed.
    pub pattern: Pattern,
    /// How it bends.
    pub bending: BendingModel,
}

impl Strip {
    /// Squares halved along the same diagonal, with the default bending.
    pub fn new(length: f64, width: f64, along: u32, across: u32) -> Self {
        Self { length, width, along, across, pattern: Pattern::OneDiagonal, bending: BendingModel::default() }
    }

    /// At rest, in the plane.
    pub fn cloth(&self, fabric: Fabric, settings: SolverSettings) -> Cloth {
        let mut random = StdRng::seed_from_u64(5);
        let (columns, rows) = (self.along + 1, self.across + 1);
        let (dx, dz) = (self.length / f64::from(self.along), self.width / f64::from(self.across));
        let mut place = |i: u32| {
            let (column, row) = (i % columns, i / columns);
            // The first cell may be clamped.
            let inner = column > 1 && column < columns - 1 && row > 0 && row < rows - 1;
            let [off_x, off_z] = match self.pattern {
                Pattern::Jittered(most) if inner => [(); 2].map(|()| random.random_range(-most..=most)),
                Pattern::Equilateral => [0.5 * f64::from(row % 2), 0.0],
                _ => [0.0; 2],
            };
            DVec3::new((f64::from(column) + off_x) * dx, 0.0, (f64::from(row) + off_z) * dz)
        };
        let positions: Vec<_> = (0..columns * rows).map(&mut place).collect();
        let cells = (0..self.across).flat_map(|row| (0..self.along).map(move |column| (row, column)));
        let triangles: Vec<_> = cells
            .flat_map(|(row, column)| {
                let a = row * columns + column;
                let [b, c, d] = [a + 1, a + columns, a + columns + 1];
                let other_diagonal = match self.pattern {
                    Pattern::OneDiagonal => false,
                    Pattern::Alternating | Pattern::Jittered(_) => (row + column) % 2 == 1,
                    Pattern::Equilateral => row % 2 == 1,
                };
                if other_diagonal { [[a, c, d], [a, d, b]] } else { [[a, c, b], [b, c, d]] }
            })
            .collect();
        let mesh = SurfaceMesh { positions: &positions, triangles: &triangles, uvs: None };
        let options = RestShapeOptions { bending: self.bending, ..Default::default() };
        let shape = RestShape::new(&mesh, &options).expect("a strip is a valid mesh");
        Cloth::new(shape, fabric, settings).expect("the fabric is valid")
    }
}

/// Settings to find a rest with: it does not depend on them, and long steps of backward Euler are soon there.
pub fn resting(tolerance: f32) -> SolverSettings {
    SolverSettings {
        integrator: Integrator::BackwardEuler,
        kind: SolverKind::conjugate_gradient(tolerance),
        ..Default::default()
    }
}

/// Solves so well that what is left to see is the step alone.
pub fn exact() -> SolverSettings {
    SolverSettings { kind: SolverKind::conjugate_gradient(1e-6), precision: Precision::Double, ..Default::default() }
}

/// Steps until nothing moves.
pub fn rest(cloth: &mut Cloth) {
    for _ in 0..2000 {
        cloth.step(0.1);
        if cloth.velocities().iter().all(|v| v.length() < 1e-6) {
            break;
        }
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
