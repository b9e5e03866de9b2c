//! Vertices in the middle of another triangle's edge: to the eye the mesh is one there, to the simulation it is open.

use std::collections::{HashMap, HashSet};

use bevy::math::{DVec3, I64Vec3};

use super::RestShape;

/// Cells that the way along one edge is looked at in, at most: beyond, an edge is so much longer than the others that the mesh
/// has other troubles.
const MOST_CELLS: f64 = 1e4;

impl RestShape {
    /// Vertices at the border that lie on another triangle's edge at the border, as near as `tolerance`, m, without being one of
    /// its ends: the mesh opens there under load.
    pub fn t_junctions(&self, tolerance: f64) -> Vec<u32> {
        let at = |vertex: u32| self.positions[vertex as usize];
        let lengths: f64 = self.boundary.iter().map(|&[a, b]| at(a).distance(at(b))).sum();
        let size = (lengths / self.boundary.len() as f64).max(4.0 * tolerance);
        if self.boundary.is_empty() || !(size > 0.0 && size.is_finite()) {
            return Vec::new();
        }
        let cell = |p: DVec3| (p / size).floor().as_i64vec3();
        let mut cells: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
        let border: HashSet<u32> = self.boundary.as_flattened().iter().copied().collect();
        for vertex in border {
            cells.entry(cell(at(vertex))).or_default().push(vertex);
        }
        let mut found = HashSet::new();
        for &[a, b] in &self.boundary {
            let (start, way) = (at(a), at(b) - at(a));
            let steps = (way.length() / size).ceil().clamp(1.0, MOST_CELLS);
            for step in 0..=steps as u32 {
                let near = neighbourhood(cell(start + way * (f64::from(step) / steps)));
                for &vertex in near.filter_map(|cell| cells.get(&cell)).flatten() {
                    if vertex != a && vertex != b && lies_between(at(vertex) - start, way, tolerance) {
                        found.insert(vertex);
                    }
                }
            }
        }
        let mut found: Vec<_> = found.into_iter().collect();
        found.sort_unstable();
        found
    }
}

/// Whether a point is on the way between two others, and at neither of them. Relative to the first.
fn lies_between(point: DVec3, way: DVec3, tolerance: f64) -> bool {
    let along = point.dot(way) / way.length_squared();
    let margin = tolerance / way.length();
    along > margin && along < 1.0 - margin && point.distance(along * way) <= tolerance
}

fn neighbourhood(cell: I64Vec3) -> impl Iterator<Item = I64Vec3> {
    (0..27).map(move |i| cell.saturating_add(I64Vec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::mesh::{RestShapeOptions, SurfaceMesh};

    #[test]
    fn a_vertex_midway_on_an_edge_is_found_and_corners_are_not() {
        // One large triangle above, two small ones below, that share its corners but have one more vertex between them.
        let positions = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [1.0, 0.0], [1.0, -1.0]];
        let mut positions = positions.map(|[x, y]| DVec3::new(x, y, 0.3 * x));
        let triangles = [[0, 1, 2], [0, 4, 3], [3, 4, 1]];
        let found = |positions: &[DVec3]| {
            let mesh = SurfaceMesh { positions, triangles: &triangles, uvs: None };
            RestShape::new(&mesh, &RestShapeOptions::default()).unwrap().t_junctions(1e-5)
        };
        assert_eq!(found(&positions), [3]);
        positions[3].z += 1e-6;
        assert_eq!(found(&positions), [3]);
        positions[3].z += 1e-3;
        assert_eq!(found(&positions), [0; 0]);
    }
}
