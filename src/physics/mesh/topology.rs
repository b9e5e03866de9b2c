//! Triangles worth keeping, and the edges between them.

use std::collections::HashSet;

use bevy::math::DVec3;

/// A triangle that becomes an element.
pub(super) struct CleanTriangle {
    /// Index in the mesh.
    pub source: u32,
    /// Its vertices after welding.
    pub welded: [u32; 3],
}

/// Area below which a triangle is degenerate, relative to the square of its longest edge: the material frame of a thinner
/// one is rounding noise. (An aspect of 1e4 has 5e-5.)
const MIN_RELATIVE_AREA: f64 = 1e-8;

/// Whether the material frame of a triangle is no rounding noise.
pub(super) fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    let area = 0.5 * (b - a).cross(c - a).length();
    // One so large that its area has no number has no frame either.
    area > MIN_RELATIVE_AREA * longest && area.is_finite()
}

/// Splits the triangles of a mesh into elements and the indices of those that are none: without area once welded, or
/// with the same three vertices as an earlier one (the back of a double-sided mesh).
pub(super) fn clean_triangles(
    triangles: &[[u32; 3]],
    positions: &[DVec3],
    welded: &[u32],
) -> (Vec<CleanTriangle>, Vec<u32>) {
    let mut seen = HashSet::with_capacity(triangles.len());
    let (mut kept, mut dropped) = (Vec::with_capacity(triangles.len()), Vec::new());
    for (source, vertices) in triangles.iter().enumerate() {
        let welded = vertices.map(|v| welded[v as usize]);
        let mut key = welded;
        key.sort_unstable();
        if has_area(welded.map(|v| positions[v as usize])) && seen.insert(key) {
            kept.push(CleanTriangle { source: source as u32, welded });
        } else {
            dropped.push(source as u32);
        }
    }
    (kept, dropped)
}

/// One side of an edge.
struct Side {
    edge: [u32; 2],
    opposite: u32,
    triangle: usize,
}

/// A pair of triangles at an edge.
pub(super) struct HingeTopology {
    /// The ends of the edge, then the two opposite vertices.
    pub vertices: [u32; 4],
    /// The two triangles.
    pub triangles: [usize; 2],
}

/// All edges of a set of triangles, with what lies beside each.
pub(super) struct Edges {
    /// Sorted by edge, then by triangle.
    sides: Vec<Side>,
}

impl Edges {
    pub fn new(triangles: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut sides: Vec<Side> = triangles
            .enumerate()
            .flat_map(|(triangle, [a, b, c])| {
                [(a, b, c), (b, c, a), (c, a, b)].map(|(from, to, opposite)| Side {
                    edge: [from.min(to), from.max(to)],
                    opposite,
                    triangle,
                })
            })
            .collect();
        sides.sort_by_key(|side| (side.edge, side.triangle));
        Self { sides }
    }

    fn groups(&self) -> impl Iterator<Item = &[Side]> {
        self.sides.chunk_by(|a, b| a.edge == b.edge)
    }

    fn edges_with(&self, count: impl Fn(usize) -> bool) -> Vec<[u32; 2]> {
        self.groups().filter(|group| count(group.len())).map(|group| group[0].edge).collect()
    }

    pub fn all(&self) -> Vec<[u32; 2]> {
        self.edges_with(|_| true)
    }

    pub fn boundary(&self) -> Vec<[u32; 2]> {
        self.edges_with(|n| n == 1)
    }

    pub fn non_manifold(&self) -> Vec<[u32; 2]> {
        self.edges_with(|n| n > 2)
    }

    /// One hinge for each pair of triangles at each edge.
    pub fn hinges(&self) -> impl Iterator<Item = HingeTopology> {
        self.groups().flat_map(|group| {
            (0..group.len()).flat_map(move |i| {
                (i + 1..group.len()).map(move |j| {
                    let (first, second) = (&group[i], &group[j]);
                    HingeTopology {
                        vertices: [first.edge[0], first.edge[1], first.opposite, second.opposite],
                        triangles: [first.triangle, second.triangle],
                    }
                })
            })
        })
    }
}
