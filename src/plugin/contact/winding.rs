//! Which way round the triangles of a surface are.

use bevy::math::Vec3;
use bevy::platform::collections::{HashMap, HashSet};

use crate::plugin::winding::Windings;

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
    let Windings { of, can_agree } = Windings::new(triangles);
    if !can_agree {
        return None;
    }
    let mut parts = vec![Vec::new(); triangles.len()];
    for (&(first, turned), &triangle) in of.iter().zip(&*triangles) {
        parts[first as usize].push(turn(triangle, turned));
    }
    let counts = of.iter().filter(|(_, turned)| *turned).fold(vec![0; triangles.len()], |mut counts, &(first, _)| {
        counts[first as usize] += 1;
        counts
    });
    let others = |(part, count): (Vec<[u32; 3]>, usize)| {
        2 * count > part.len() || (2 * count == part.len() && volume(part.into_iter(), vertices) < 0.0)
    };
    let others: Vec<bool> = parts.into_iter().zip(counts).map(others).collect();
    let mut count = 0;
    for (triangle, (first, turned)) in triangles.iter_mut().zip(of) {
        let turned = turned ^ others[first as usize];
        *triangle = turn(*triangle, turned);
        count += usize::from(turned);
    }
    Some(count)
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
