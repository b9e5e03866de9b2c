//! Which way round the triangles of a surface are.

use bevy::math::Vec3;
use bevy::platform::collections::{HashMap, HashSet};

/// Whether each edge is passed as often in one direction as in the other.
pub(super) fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut turns: HashMap<[u32; 2], i32> = HashMap::new();
    for [from, to] in triangles.iter().flat_map(edges) {
        *turns.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
    }
    turns.values().all(|&turns| turns == 0)
}

/// Whether no edge is passed twice in one direction: then all triangles are seen counter-clockwise from the same side.
pub(super) fn is_consistent(triangles: &[[u32; 3]]) -> bool {
    let mut passed = HashSet::with_capacity(3 * triangles.len());
    triangles.iter().flat_map(edges).all(|edge| passed.insert(edge))
}

/// The edges of a triangle, in its direction.
fn edges(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Turns triangles so that neighbors agree; of each connected part the fewer, and of a tie those that make the volume negative. Says
/// how many; `None`, and nothing is turned, if they cannot agree: three at an edge, or a Möbius strip.
pub(super) fn agree(triangles: &mut [[u32; 3]], vertices: &[Vec3]) -> Option<usize> {
    let mut beside: HashMap<[u32; 2], Vec<(usize, bool)>> = HashMap::new();
    for (index, triangle) in triangles.iter().enumerate() {
        for [from, to] in edges(triangle) {
            beside.entry([from.min(to), from.max(to)]).or_default().push((index, from < to));
        }
    }
    let mut turned = vec![None; triangles.len()];
    for first in 0..triangles.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let mut part = vec![first];
        let mut next = 0;
        while let Some(&index) = part.get(next) {
            next += 1;
            let its = turned[index]?;
            for [from, to] in edges(&triangles[index]) {
                for &(other, rising) in &beside[&[from.min(to), from.max(to)]] {
                    // Neighbors pass their edge in opposite directions.
                    let wanted = its ^ (rising == (from < to));
                    match turned[other] {
                        _ if other == index => {}
                        None => {
                            turned[other] = Some(wanted);
                            part.push(other);
                        }
                        Some(decided) if decided != wanted => return None,
                        Some(_) => {}
                    }
                }
            }
        }
        let few = part.iter().filter(|&&index| turned[index] == Some(true)).count();
        let as_turned = part.iter().map(|&index| turn(triangles[index], turned[index] == Some(true)));
        let others = 2 * few > part.len() || (2 * few == part.len() && volume(as_turned, vertices) < 0.0);
        for index in part.into_iter().filter(|_| others) {
            turned[index] = turned[index].map(|turned| !turned);
        }
    }
    for (triangle, &turned) in triangles.iter_mut().zip(&turned) {
        *triangle = turn(*triangle, turned == Some(true));
    }
    Some(turned.iter().filter(|&&turned| turned == Some(true)).count())
}

/// The other way round, if it is to be.
pub(super) fn turn([a, b, c]: [u32; 3], turned: bool) -> [u32; 3] {
    if turned { [a, c, b] } else { [a, b, c] }
}

/// Volume within a closed surface, m³; negative if its triangles face inwards.
pub(super) fn volume(triangles: impl Iterator<Item = [u32; 3]>, vertices: &[Vec3]) -> f64 {
    let middle = vertices.first().copied().unwrap_or_default().as_dvec3();
    let corner = |vertex: u32| vertices[vertex as usize].as_dvec3() - middle;
    triangles.map(|triangle| triangle.map(corner)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// What is left where triangles lie on each other.
pub(super) struct Distinct {
    /// One of each that has the same corners, the first.
    pub triangles: Vec<[u32; 3]>,
    /// Those of them whose other side is a triangle as well.
    pub doubled: usize,
}

/// Finds triangles that have the same corners as others.
pub(super) fn distinct(triangles: &[[u32; 3]]) -> Distinct {
    // By corners in order: the first, and whether both directions have been seen.
    let mut seen: HashMap<[u32; 3], (bool, bool)> = HashMap::with_capacity(triangles.len());
    let (mut kept, mut doubled) = (Vec::with_capacity(triangles.len()), 0);
    for &triangle in triangles {
        let mut corners = triangle;
        corners.sort_unstable();
        let [low, middle, _] = corners;
        let rising = edges(&triangle).contains(&[low, middle]);
        match seen.get_mut(&corners) {
            None => {
                seen.insert(corners, (rising, false));
                kept.push(triangle);
            }
            Some((first, both)) if *first != rising && !*both => {
                *both = true;
                doubled += 1;
            }
            Some(_) => {}
        }
    }
    Distinct { triangles: kept, doubled }
}
