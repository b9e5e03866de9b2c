//! From the parameters of a run to a cloth in its state, and to where its pins are.

use bevy::math::DVec3;
use bevy_cloth::physics::{BendingModel, Cloth, RestShape, RestShapeOptions, SolverSettings, SurfaceMesh};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use super::sample::{Held, Meshing, PinMotion, SIZE, Sample, Start, Throw};
use crate::scenes::{self, Sheet};

/// Steps between two teleports.
const TELEPORT_EVERY: u32 = 8;

/// A run laid out in space.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The mesh at rest.
    pub sheet: Sheet,
    /// Where the vertices start, m.
    pub positions: Vec<DVec3>,
    /// How fast, m/s.
    pub velocities: Vec<DVec3>,
    /// Vertices that are held.
    pub held: Vec<u32>,
    /// How far the scene is from the origin, m.
    pub away: DVec3,
    bending: BendingModel,
    pins: PinMotion,
    detail: u64,
    /// Which way moving pins go.
    way: DVec3,
}

impl Scene {
    /// Lays a run out.
    pub fn new(sample: &Sample) -> Self {
        let mut random = StdRng::seed_from_u64(sample.detail);
        let sheet = sheet(sample.side, sample.meshing);
        let way = direction(&mut random);
        let away = sample.distance * direction(&mut random);
        let positions = lay(&sheet.positions, sample.side, sample.start, &mut random);
        let velocities = throw(&positions, sample.throw, &mut random);
        let held = match sample.held {
            Held::Free => Vec::new(),
            Held::Corners => sheet.corners.to_vec(),
            Held::Edge => (0..sample.side).collect(),
        };
        let positions = positions.into_iter().map(|x| x + away).collect();
        let (bending, pins, detail) = (sample.bending_model.into(), sample.pins, sample.detail);
        Self { sheet, positions, velocities, held, away, bending, pins, detail, way }
    }

    /// The rest shape; no two vertices are one.
    pub fn shape(&self) -> RestShape {
        let Sheet { positions, triangles, uvs, .. } = &self.sheet;
        let mesh = SurfaceMesh { positions, triangles, uvs: Some(uvs) };
        let options = RestShapeOptions { weld_distance: Some(0.0), bending: self.bending, ..Default::default() };
        RestShape::new(&mesh, &options).expect("a sheet is a valid mesh")
    }

    /// The cloth at the start.
    pub fn cloth(&self, sample: &Sample) -> Cloth {
        let substeps = if self.pins == PinMotion::Still { sample.substeps } else { 1 };
        let settings = SolverSettings { substeps, ..sample.settings() };
        let mut cloth = Cloth::new(self.shape(), sample.fabric(), settings).expect("the fabric is valid");
        cloth.set_state(&self.positions, &self.velocities);
        for &vertex in &self.held {
            cloth.pin(vertex, self.positions[vertex as usize]);
        }
        cloth
    }

    /// How far each held vertex is from its start at the end of a step, which is at a time (s), m.
    pub fn pins_at(&self, step: u32, time: f64) -> Vec<(u32, DVec3)> {
        let jump = (step + TELEPORT_EVERY / 2) / TELEPORT_EVERY;
        let mut random = StdRng::seed_from_u64(self.detail.wrapping_add(u64::from(jump)));
        let mut moved = || match self.pins {
            PinMotion::Still => DVec3::ZERO,
            PinMotion::Moving(speed) => speed * time * self.way,
            PinMotion::Teleporting(_) if jump == 0 => DVec3::ZERO,
            PinMotion::Teleporting(distance) => distance * within_cube(&mut random),
        };
        self.held.iter().map(|&vertex| (vertex, moved())).collect()
    }

    /// Tells the cloth where its pins are to be at the end of a step.
    pub fn move_pins(&self, cloth: &mut Cloth, step: u32, time: f64) {
        if self.pins != PinMotion::Still {
            for (vertex, moved) in self.pins_at(step, time) {
                cloth.pin(vertex, self.positions[vertex as usize] + moved);
            }
        }
    }

    /// Vertices that nothing holds.
    pub fn free(&self) -> Vec<u32> {
        (0..self.positions.len() as u32).filter(|vertex| !self.held.contains(vertex)).collect()
    }
}

/// The sheet, its rows and columns moved as the meshing has it.
fn sheet(side: u32, meshing: Meshing) -> Sheet {
    let cells = (side - 1) as usize;
    let (widths, heights) = match meshing {
        Meshing::Even => return Sheet::new(side, scenes::Meshing::Grid),
        Meshing::Irregular => return Sheet::new(side, scenes::Meshing::Irregular),
        Meshing::Slivers { aspect } => {
            let mut heights = vec![1.0; cells];
            heights[cells / 2] = 1.0 / aspect;
            (vec![1.0; cells], heights)
        }
        Meshing::Graded { ratio } => {
            let grown: Vec<_> = (0..cells).map(|i| ratio.powf(i as f64 / (cells - 1) as f64)).collect();
            (grown.clone(), grown)
        }
    };
    let mut sheet = Sheet::new(side, scenes::Meshing::Grid);
    let (columns, rows) = (marks(&widths), marks(&heights));
    for (vertex, x) in sheet.positions.iter_mut().enumerate() {
        *x = DVec3::new(columns[vertex % side as usize], 0.0, rows[vertex / side as usize]);
    }
    sheet
}

/// Where pieces of these lengths begin and end when they fill the side.
fn marks(lengths: &[f64]) -> Vec<f64> {
    let whole: f64 = lengths.iter().sum();
    let mut end = 0.0;
    let ends = lengths.iter().map(|length| {
        end += length * SIZE / whole;
        end
    });
    core::iter::once(0.0).chain(ends).collect()
}

fn lay(rest: &[DVec3], side: u32, start: Start, random: &mut StdRng) -> Vec<DVec3> {
    let centre = DVec3::new(0.5, 0.0, 0.5) * SIZE;
    let laid = rest.iter().enumerate().map(|(vertex, &x)| match start {
        Start::Rest => x,
        Start::Crumpled { by } => x + by * within_cube(random),
        Start::Point { noise } => centre + noise * within_cube(random),
        Start::Line { noise } => DVec3::new(x.x, 0.0, 0.0) + noise * within_cube(random),
        Start::Inverted if vertex as u32 / side % 2 == 1 => DVec3::new(SIZE - x.x, x.y, x.z),
        Start::Inverted => x,
        Start::Stretched { times } => centre + times * (x - centre),
    });
    laid.collect()
}

fn throw(positions: &[DVec3], throw: Throw, random: &mut StdRng) -> Vec<DVec3> {
    let centre = positions.iter().sum::<DVec3>() / positions.len() as f64;
    let way = direction(random);
    let thrown = positions.iter().map(|&x| match throw {
        Throw::Still => DVec3::ZERO,
        Throw::Thrown(speed) => speed * way,
        Throw::Spun(speed) => speed / (0.5 * SIZE) * way.cross(x - centre).clamp_length_max(0.5 * SIZE),
        Throw::Scattered(speed) => speed * direction(random),
    });
    thrown.collect()
}

/// Components in [−1, 1].
fn within_cube(random: &mut StdRng) -> DVec3 {
    DVec3::from_array(core::array::from_fn(|_| random.random_range(-1.0..=1.0)))
}

fn direction(random: &mut StdRng) -> DVec3 {
    within_cube(random).try_normalize().unwrap_or(DVec3::X)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(start: Start) -> Sample {
        Sample::plain(start, 0.01, 100.0, false, 3)
    }

    #[test]
    fn slivers_and_graded_cells_are_as_extreme_as_asked_and_cover_the_sheet() {
        for (meshing, shortest) in [
            (Meshing::Slivers { aspect: 1e4 }, 1.0 / (6.0 + 1e-4) * 1e-4),
            (Meshing::Graded { ratio: 1e3 }, 1.0 / (0..7).map(|i| 1e3_f64.powf(f64::from(i) / 6.0)).sum::<f64>()),
        ] {
            let shape = Scene::new(&Sample { meshing, ..plain(Start::Rest) }).shape();
            assert_eq!((shape.vertex_count(), shape.triangles.len(), shape.dropped.len()), (64, 98, 0));
            assert!((shape.vertex_areas.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let edge = |&[a, b]: &[u32; 2]| shape.positions[a as usize].distance(shape.positions[b as usize]);
            let least = shape.edges.iter().map(edge).fold(f64::MAX, f64::min);
            assert!((least / shortest - 1.0).abs() < 1e-6, "{meshing:?}: {least} of {shortest}");
        }
    }

    #[test]
    fn starts_are_what_they_are_called() {
        let extent = |start| {
            let positions = Scene::new(&plain(start)).positions;
            let bounds = positions.iter().fold((DVec3::MAX, DVec3::MIN), |(a, b), &x| (a.min(x), b.max(x)));
            bounds.1 - bounds.0
        };
        assert_eq!(extent(Start::Rest), DVec3::new(1.0, 0.0, 1.0));
        assert!(extent(Start::Crumpled { by: 1.0 }).min_element() > 1.5);
        assert_eq!(extent(Start::Point { noise: 0.0 }), DVec3::ZERO);
        assert_eq!(extent(Start::Line { noise: 0.0 }), DVec3::X);
        assert!((extent(Start::Stretched { times: 100.0 }) - DVec3::new(100.0, 0.0, 100.0)).length() < 1e-12);
        // Inverted, every other triangle faces down.
        let scene = Scene::new(&Sample { meshing: Meshing::Even, ..plain(Start::Inverted) });
        let faces_up = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.map(|v| scene.positions[v as usize]);
            (b - a).cross(c - a).y > 0.0
        };
        assert_eq!(scene.sheet.triangles.iter().filter(faces_up).count(), scene.sheet.triangles.len() / 2);
    }

    #[test]
    fn pins_stay_move_or_jump() {
        let sample = plain(Start::Rest);
        let moved = |pins, step| Scene::new(&Sample { pins, ..sample.clone() }).pins_at(step, 0.5);
        assert!(moved(PinMotion::Still, 9).iter().all(|&(_, by)| by == DVec3::ZERO));
        assert!(moved(PinMotion::Moving(100.0), 9).iter().all(|&(_, by)| (by.length() - 50.0).abs() < 1e-12));
        let [before, after, later] = [3, 4, 11].map(|step| moved(PinMotion::Teleporting(10.0), step));
        assert!(before.iter().all(|&(_, by)| by == DVec3::ZERO));
        assert!(after == later && after[0].1 != after[1].1 && after[0].1.length() > 0.0);
    }
}
