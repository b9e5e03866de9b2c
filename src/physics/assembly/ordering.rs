//! In which order the vertices stand in the linear system.
//!
//! They are sorted along the longest way through the cloth and cut into parts, which are bands across: so parts touch
//! little. Within a part they are sorted by colour, so that successive rows are not coupled and can be worked on at once,
//! and along the way again, so that neighbours are near each other in memory.

use bevy::math::DVec3;

use super::colouring::colour;
use crate::physics::mesh::RestShape;

/// Rows of a part, at least.
const PART: usize = 5000;
/// Most parts.
const MOST_PARTS: usize = 64;

/// An order of vertices.
#[derive(Clone, Debug)]
pub struct Ordering {
    /// Number of each vertex in the linear system.
    pub inner: Vec<u32>,
    /// Vertex of each number.
    pub outer: Vec<u32>,
    /// First numbers of the parts.
    pub part_starts: Vec<u32>,
}

impl Ordering {
    /// The order as it is, in one part.
    pub fn identity(vertex_count: usize) -> Self {
        let inner: Vec<u32> = (0..vertex_count as u32).collect();
        Self { outer: inner.clone(), inner, part_starts: vec![0] }
    }

    /// An order for a cloth.
    pub fn new(shape: &RestShape) -> Self {
        let count = shape.vertex_count();
        let along = along(&shape.positions);
        let parts = (count / PART).clamp(1, MOST_PARTS);
        let part_starts: Vec<_> = (0..parts).map(|part| (count * part / parts) as u32).collect();

        let mut neighbours = vec![Vec::new(); count];
        let triangles = shape.triangles.iter().map(|triangle| &triangle.vertices[..]);
        for element in triangles.chain(shape.bending_hinges().iter().map(|hinge| &hinge.vertices[..])) {
            for &vertex in element {
                neighbours[vertex as usize].extend(element.iter().filter(|&&other| other != vertex));
            }
        }
        let colours = colour(&neighbours, along.iter().copied());
        let mut outer = along;
        for part in 0..parts {
            let end = part_starts.get(part + 1).map_or(count, |&end| end as usize);
            outer[part_starts[part] as usize..end].sort_by_key(|&vertex| colours[vertex as usize]);
        }
        let mut inner = vec![0; count];
        for (number, &vertex) in outer.iter().enumerate() {
            inner[vertex as usize] = number as u32;
        }
        Self { inner, outer, part_starts }
    }
}

/// The vertices from one end of the cloth to the other.
pub(super) fn along(positions: &[DVec3]) -> Vec<u32> {
    let way = longest_way(positions);
    // In steps, so that rounding does not shuffle the vertices of a grid that are equally far along.
    let steps = 1e6 / way.length_squared();
    let mut vertices: Vec<u32> = (0..positions.len() as u32).collect();
    vertices
        .sort_by_cached_key(|&vertex| ((positions[vertex as usize] - positions[0]).dot(way) * steps).round() as i64);
    vertices
}

/// From one end to the other.
fn longest_way(positions: &[DVec3]) -> DVec3 {
    let farthest = |from: DVec3| {
        let distances = positions.iter().map(|&x| (x.distance_squared(from), x));
        distances.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(from, |(_, x)| x)
    };
    let end = farthest(positions.first().copied().unwrap_or_default());
    farthest(end) - end
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::mesh::{RestShapeOptions, SurfaceMesh};

    #[test]
    fn every_vertex_has_one_number_and_parts_are_bands() {
        let (columns, rows) = (40, 600);
        // Out of order.
        let count = columns * rows;
        let place = |i: u32| 7919 * i % count;
        let mut at = vec![0; count as usize];
        (0..count).for_each(|i| at[place(i) as usize] = i);
        let positions: Vec<_> =
            (0..count).map(|i| DVec3::new(f64::from(place(i) % columns), 0.0, f64::from(place(i) / columns))).collect();
        let cells = (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| row * columns + column));
        let triangles: Vec<_> = cells
            .flat_map(|a| [[a, a + columns, a + 1], [a + 1, a + columns, a + columns + 1]])
            .map(|triangle| triangle.map(|v| at[v as usize]))
            .collect();
        let mesh = SurfaceMesh { positions: &positions, triangles: &triangles, uvs: None };
        let shape = RestShape::new(&mesh, &RestShapeOptions::default()).unwrap();
        let positions = &shape.positions;

        let ordering = Ordering::new(&shape);
        let mut sorted = ordering.outer.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &v)| i as u32 == v));
        assert!(ordering.outer.iter().enumerate().all(|(i, &v)| ordering.inner[v as usize] as usize == i));

        assert_eq!(ordering.part_starts, [0, 6000, 12000, 18000]);
        let band: Vec<_> = ordering.outer[6000..12000].iter().map(|&v| positions[v as usize].z).collect();
        let (low, high) = (band.iter().copied().fold(f64::MAX, f64::min), band.iter().copied().fold(0.0, f64::max));
        assert!(high - low < 165.0, "{low} to {high}");
        // Most successive vertices have the same colour: they are far apart.
        let coupled = |pair: &[u32]| positions[pair[0] as usize].distance(positions[pair[1] as usize]) < 1.5;
        assert!(ordering.outer.windows(2).filter(|pair| coupled(pair)).count() < 50);
    }

    #[test]
    fn a_cloth_of_no_extent_is_one_part() {
        assert_eq!(along(&[]), [0; 0]);
        assert_eq!(along(&[DVec3::X; 3]), [0, 1, 2]);
        assert_eq!(Ordering::identity(3).part_starts, [0]);
    }
}
