//! Vertices split along UV or normal seams become one again.

use std::collections::HashMap;

use bevy::math::{DVec3, I64Vec3};

use super::SurfaceMesh;

/// For each vertex the first vertex of the mesh within `distance` of it (itself if there is none).
///
/// Points are hashed into cells of the weld distance and compared with the 27 cells around, so that the result does not
/// depend on where the cells lie. `None` takes 1e-5 of the diagonal of the bounding box of what triangles use: a vertex without
/// triangle may be anywhere.
pub(super) fn weld(mesh: &SurfaceMesh, distance: Option<f64>) -> Vec<u32> {
    let positions = mesh.positions;
    let used = mesh.triangles.as_flattened().iter().map(|&vertex| positions[vertex as usize]);
    let (min, max) = used.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
    let diagonal = if mesh.triangles.is_empty() { 0.0 } else { (max - min).length() };
    // The floor keeps the cell numbers within i64 for a weld distance of zero.
    let distance = distance.unwrap_or(1e-5 * diagonal).max(1e-12 * diagonal).max(f64::MIN_POSITIVE);

    let cell = |p: DVec3| ((p - min) / distance).floor().as_i64vec3();
    let mut cells: HashMap<I64Vec3, Vec<u32>> = HashMap::with_capacity(positions.len());
    let mut representative = Vec::with_capacity(positions.len());
    let (low, high) = (min - distance, max + distance);
    for (vertex, &p) in positions.iter().enumerate() {
        if !(p.cmpge(low).all() && p.cmple(high).all()) {
            // Nothing is near it, and its cell may have no number.
            representative.push(vertex as u32);
            continue;
        }
        let centre = cell(p);
        let near = neighbourhood().filter_map(|offset| cells.get(&(centre + offset))).flatten().copied();
        let first = near.filter(|&v| positions[v as usize].distance(p) <= distance).min();
        let chosen = first.unwrap_or(vertex as u32);
        if first.is_none() {
            cells.entry(centre).or_default().push(chosen);
        }
        representative.push(chosen);
    }
    representative
}

fn neighbourhood() -> impl Iterator<Item = I64Vec3> {
    (0..27).map(|i| I64Vec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn welded<const N: usize>(points: [[f64; 3]; N], distance: Option<f64>) -> Vec<u32> {
        let positions = points.map(DVec3::from);
        weld(&SurfaceMesh { positions: &positions, triangles: &[[0, 1, 4], [3, 2, 4]], uvs: None }, distance)
    }

    #[test]
    fn near_vertices_become_the_first_of_them_and_far_ones_stay() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0 + 4e-6, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.1, 0.0]];
        assert_eq!(welded(points, None), [0, 1, 1, 0, 4]);
        assert_eq!(welded(points, Some(0.0)), [0, 1, 2, 0, 4]);
        assert_eq!(welded(points, Some(0.2)), [0, 1, 1, 0, 1]);
    }

    #[test]
    fn vertices_without_triangle_say_nothing_about_the_extent() {
        for far in [500.0, 1e6, 1e300, f64::MAX] {
            let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.001, 0.0], [0.0, 0.0, 0.0], [1.0, 0.1, 0.0]];
            let [a, b, c, d, e] = corners;
            let points = [a, b, c, d, e, [far, 0.0, 0.0], [1.0, 0.1, 0.0]];
            assert_eq!(welded(points, None), [0, 1, 2, 0, 4, 5, 4], "{far}");
        }
    }
}
