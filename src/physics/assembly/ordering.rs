//! In which order the vertices stand in the linear system.
//!
//! They are sorted along the longest way through the cloth: so neighbours are near each other in memory, and parts, which
//! are bands across, touch little.

use bevy::math::DVec3;

/// Rows of a part, at least.
const PART: usize = 2500;
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

    /// An order for vertices at these places.
    pub fn new(positions: &[DVec3]) -> Self {
        let count = positions.len();
        let along = longest_way(positions);
        // In steps, so that rounding does not shuffle the vertices of a grid that are equally far along.
        let steps = 1e6 / along.length_squared();
        let mut outer: Vec<u32> = (0..count as u32).collect();
        outer.sort_by_cached_key(|&vertex| {
            ((positions[vertex as usize] - positions[0]).dot(along) * steps).round() as i64
        });

        let parts = (count / PART).clamp(1, MOST_PARTS);
        let part_starts = (0..parts).map(|part| (count * part / parts) as u32).collect();
        let mut inner = vec![0; count];
        for (number, &vertex) in outer.iter().enumerate() {
            inner[vertex as usize] = number as u32;
        }
        Self { inner, outer, part_starts }
    }
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

    #[test]
    fn every_vertex_has_one_number_and_neighbours_are_near() {
        let (columns, rows) = (40, 300);
        // Out of order.
        let place = |i: u32| 7919 * i % (columns * rows);
        let positions: Vec<_> = (0..columns * rows)
            .map(|i| DVec3::new(f64::from(place(i) % columns), 0.0, f64::from(place(i) / columns)))
            .collect();
        let ordering = Ordering::new(&positions);
        let mut sorted = ordering.outer.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &v)| i as u32 == v));
        assert!(ordering.outer.iter().enumerate().all(|(i, &v)| ordering.inner[v as usize] as usize == i));

        assert_eq!(ordering.part_starts, [0, 3000, 6000, 9000]);
        // A part is a band across.
        let band: Vec<_> = ordering.outer[3000..6000].iter().map(|&v| positions[v as usize].z).collect();
        let (low, high) = (band.iter().copied().fold(f64::MAX, f64::min), band.iter().copied().fold(0.0, f64::max));
        assert!(high - low < 90.0, "{low} to {high}");
    }

    #[test]
    fn few_vertices_are_one_part() {
        assert_eq!(Ordering::new(&[]).part_starts, [0]);
        let ordering = Ordering::new(&[DVec3::X; 3]);
        assert_eq!((ordering.outer.len(), &ordering.part_starts[..]), (3, &[0][..]));
    }
}
