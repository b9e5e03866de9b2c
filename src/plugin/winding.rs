//! Which triangles of a mesh are wound against those beside them.

use super::sets::Sets;

/// How the triangles of a mesh are wound against each other.
pub(super) struct Windings {
    /// For each triangle the first of those that it hangs together with by edges, and whether it is wound against that.
    pub of: Vec<(u32, bool)>,
    /// Whether all could be wound alike: no three are at an edge, and there is no Möbius strip.
    pub can_agree: bool,
}

impl Windings {
    /// Compares each triangle with those beside it.
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let mut sets = Sets::new(triangles.len());
        let mut sides: Vec<Side> = (0..)
            .zip(triangles)
            .flat_map(|(triangle, &[a, b, c])| {
                let side =
                    |(from, to): (u32, u32)| Side { edge: [from.min(to), from.max(to)], triangle, forward: from < to };
                [(a, b), (b, c), (c, a)].map(side)
            })
            .collect();
        sides.sort_unstable();
        let mut can_agree = true;
        for at_edge in sides.chunk_by(|a, b| a.edge == b.edge) {
            can_agree &= at_edge.len() <= 2;
            for pair in at_edge.windows(2) {
                let [a, b] = [&pair[0], &pair[1]].map(|side| triangles[side.triangle as usize]);
                // Neighbors pass their edge in opposite directions.
                let opposite = same_winding(a, b).map_or(pair[0].forward == pair[1].forward, |same| !same);
                can_agree &= sets.join(pair[0].triangle, pair[1].triangle, opposite);
            }
        }
        Self { of: (0..triangles.len() as u32).map(|triangle| sets.find(triangle)).collect(), can_agree }
    }
}

/// For each triangle 1, or −1 where it is wound against most of what it hangs together with: flipped by mistake, or the back of
/// another on the same vertices. `None` if there is none such.
pub(super) fn signs(triangles: &[[u32; 3]]) -> Option<Vec<f32>> {
    let Windings { of, .. } = Windings::new(triangles);
    let mut votes = vec![0_i32; triangles.len()];
    for &(first, opposite) in &of {
        votes[first as usize] += if opposite { -1 } else { 1 };
    }
    let sign = |(first, opposite): (u32, bool)| if opposite == (votes[first as usize] < 0) { 1.0 } else { -1.0 };
    let signs: Vec<f32> = of.into_iter().map(sign).collect();
    signs.contains(&-1.0).then_some(signs)
}

/// Whether two triangles of the same vertices are wound alike; `None` for others.
fn same_winding(a: [u32; 3], b: [u32; 3]) -> Option<bool> {
    let start = b.iter().position(|&v| v == a[0])?;
    match [b[(start + 1) % 3], b[(start + 2) % 3]] {
        [p, q] if [p, q] == [a[1], a[2]] => Some(true),
        [p, q] if [q, p] == [a[1], a[2]] => Some(false),
        _ => None,
    }
}

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    edge: [u32; 2],
    triangle: u32,
    forward: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four triangles of a strip, wound alike.
    const STRIP: [[u32; 3]; 4] = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]];

    fn flipped([a, b, c]: [u32; 3]) -> [u32; 3] {
        [b, a, c]
    }

    #[test]
    fn what_is_wound_alike_is_left_alone() {
        assert_eq!(signs(&STRIP), None);
        assert_eq!(signs(&STRIP.map(flipped)), None);
        assert_eq!(signs(&[]), None);
        // A tetrahedron.
        assert_eq!(signs(&[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]), None);
    }

    #[test]
    fn the_few_that_run_against_the_others_are_turned() {
        let [a, b, c, d] = STRIP;
        assert_eq!(signs(&[a, flipped(b), c, d]), Some(vec![1.0, -1.0, 1.0, 1.0]));
        assert_eq!(signs(&[flipped(a), b, c, d]), Some(vec![-1.0, 1.0, 1.0, 1.0]));
        // As many: the first is right.
        assert_eq!(signs(&[a, flipped(b), c, flipped(d)]), Some(vec![1.0, -1.0, 1.0, -1.0]));
        assert_eq!(signs(&[a, b, [6, 7, 8], c, flipped(d)]), Some(vec![1.0, 1.0, 1.0, 1.0, -1.0]));
    }

    #[test]
    fn backs_on_the_same_vertices_are_turned_wherever_they_stand() {
        let back = STRIP.map(flipped);
        let after: Vec<_> = STRIP.into_iter().chain(back).collect();
        assert_eq!(signs(&after), Some([[1.0; 4], [-1.0; 4]].concat()));
        let beside: Vec<_> = STRIP.into_iter().zip(back).flat_map(|(front, back)| [front, back]).collect();
        assert_eq!(signs(&beside), Some([1.0, -1.0].repeat(4)));
        // One that is there twice is no back.
        assert_eq!(signs(&[STRIP[0], [1, 2, 0], STRIP[1]]), None);
    }
}
