//! Triangles in batches that share no vertex.

use core::ops::Range;

use crate::physics::assembly::Part;
use crate::physics::math::ROWS;

/// Triangles that are swept at once.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    pub vertices: [[u32; ROWS]; 3],
    /// Which triangle of the rest shape stands at each place; none where the batch is filled up with a copy of the first, whose rest
    /// data must make it move nothing.
    sources: [Option<u32>; ROWS],
}

/// Batches by part: those of the triangles that lie in it, and at the end those of triangles across parts.
#[derive(Clone, Debug)]
pub(super) struct Batches {
    all: Vec<Batch>,
    starts: Vec<usize>,
}

impl Batches {
    pub fn new(triangles: &[[u32; 3]], vertex_count: usize, parts: &[Part]) -> Self {
        let part_of = |vertex: u32| parts.partition_point(|part| part.rows.end <= vertex as usize);
        let across = parts.len();
        let mut by_part = vec![Vec::new(); across + 1];
        for (source, vertices) in (0..).zip(triangles) {
            let [a, b, c] = vertices.map(part_of);
            by_part[if a == b && b == c { a } else { across }].push(source);
        }
        let (mut all, mut starts) = (Vec::new(), vec![0]);
        for mut group in by_part {
            // What is near each other is worked on one after the other, in whatever order the mesh has its triangles.
            group.sort_by_key(|&source: &u32| {
                let mut vertices = triangles[source as usize];
                vertices.sort_unstable();
                vertices
            });
            for color in by_color(&group, triangles, vertex_count) {
                all.extend(color.chunks(ROWS).map(|sources| batch(sources, triangles)));
            }
            starts.push(all.len());
        }
        Self { all, starts }
    }

    pub fn all(&self) -> &[Batch] {
        &self.all
    }

    /// The batches of a part.
    pub fn inside(&self, part: usize) -> Range<usize> {
        self.starts[part]..self.starts[part + 1]
    }

    /// The batches across parts.
    pub fn across(&self) -> Range<usize> {
        self.inside(self.starts.len() - 2)
    }

    /// The triangle at each place of each batch.
    pub fn sources(&self) -> impl Iterator<Item = &[Option<u32>]> {
        self.all.iter().map(|batch| &batch.sources[..])
    }
}

fn batch(sources: &[u32], triangles: &[[u32; 3]]) -> Batch {
    let place = |lane: usize| sources.get(lane).copied();
    let vertex = |lane: usize, which: usize| triangles[place(lane).unwrap_or(sources[0]) as usize][which];
    Batch {
        vertices: core::array::from_fn(|which| core::array::from_fn(|lane| vertex(lane, which))),
        sources: core::array::from_fn(place),
    }
}

/// These triangles by color, such that those of one color share no vertex: greedily, each has the first that none of its vertices has.
/// What would need more than 64 colors, in a fan, is left out: a sweep need not be complete.
fn by_color(group: &[u32], triangles: &[[u32; 3]], vertex_count: usize) -> Vec<Vec<u32>> {
    // By vertex, a bit for each color of its triangles.
    let mut taken = vec![0_u64; vertex_count];
    let mut colors: Vec<Vec<u32>> = Vec::new();
    for &source in group {
        let vertices = triangles[source as usize].map(|vertex| vertex as usize);
        let color = vertices.iter().fold(0, |all, &vertex| all | taken[vertex]).trailing_ones();
        if color == u64::BITS {
            continue;
        }
        for vertex in vertices {
            taken[vertex] |= 1 << color;
        }
        if color as usize == colors.len() {
            colors.push(Vec::new());
        }
        colors[color as usize].push(source);
    }
    colors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_batch_has_a_vertex_twice_and_every_triangle_stands_once() {
        let triangles: Vec<[u32; 3]> = (0..40).flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 5]]).collect();
        let part = |index, rows| Part { index, rows, slices: 0..0, groups: 0..0, incoming: 0..0 };
        let batches = Batches::new(&triangles, 45, &[part(0, 0..20), part(1, 20..45)]);
        let mut found = Vec::new();
        for batch in batches.all() {
            let sources = batch.sources.iter().flatten();
            let mut vertices: Vec<_> = sources.clone().flat_map(|&source| triangles[source as usize]).collect();
            let count = vertices.len();
            vertices.sort_unstable();
            vertices.dedup();
            assert_eq!(vertices.len(), count);
            found.extend(sources.copied());
        }
        found.sort_unstable();
        assert_eq!(found, (0..80).collect::<Vec<_>>());
        for batch in &batches.all()[batches.inside(1)] {
            assert!(batch.vertices.iter().flatten().all(|&vertex| vertex >= 20));
        }
        assert!(!batches.across().is_empty());
    }

    #[test]
    fn what_a_fan_has_too_many_of_is_left_out() {
        let triangles: Vec<[u32; 3]> = (1..1000).map(|i| [0, i, i + 1]).collect();
        let parts = [Part { index: 0, rows: 0..1001, slices: 0..0, groups: 0..0, incoming: 0..0 }];
        assert_eq!(Batches::new(&triangles, 1001, &parts).all().len(), 64);
    }
}
