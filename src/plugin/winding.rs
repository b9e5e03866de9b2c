//! Which triangles of a mesh are wound against those beside them.

/// For each triangle 1, or −1 where it is wound against most of what it hangs together with: flipped by mistake, or the back of
/// another on the same vertices. `None` if there is none such.
pub(super) fn signs(triangles: &[[u32; 3]]) -> Option<Vec<f32>> {
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
    for pair in sides.windows(2).filter(|pair| pair[0].edge == pair[1].edge) {
        let [a, b] = [&pair[0], &pair[1]].map(|side| triangles[side.triangle as usize]);
        // Neighbours pass their edge in opposite directions.
        let opposite = same_winding(a, b).map_or(pair[0].forward == pair[1].forward, |same| !same);
        sets.join(pair[0].triangle, pair[1].triangle, opposite);
    }
    let mut votes = vec![0_i32; triangles.len()];
    for triangle in 0..triangles.len() as u32 {
        let (root, opposite) = sets.find(triangle);
        votes[root as usize] += if opposite { -1 } else { 1 };
    }
    let signs: Vec<f32> = (0..triangles.len() as u32)
        .map(|triangle| {
            let (root, opposite) = sets.find(triangle);
            if opposite == (votes[root as usize] < 0) { 1.0 } else { -1.0 }
        })
        .collect();
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

/// Disjoint sets (Tarjan 1975) of triangles that hang together, each with whether it is wound against the first of its set.
struct Sets {
    parents: Vec<(u32, bool)>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).map(|triangle| (triangle, false)).collect() }
    }

    /// The first triangle of its set, and whether it is wound against that.
    fn find(&mut self, triangle: u32) -> (u32, bool) {
        let (mut root, mut opposite) = (triangle, false);
        while self.parents[root as usize].0 != root {
            let (parent, turned) = self.parents[root as usize];
            (root, opposite) = (parent, opposite ^ turned);
        }
        // Shortens the way for the next time.
        let (mut at, mut left) = (triangle, opposite);
        while self.parents[at as usize].0 != root {
            let (parent, turned) = core::mem::replace(&mut self.parents[at as usize], (root, left));
            (at, left) = (parent, left ^ turned);
        }
        (root, opposite)
    }

    fn join(&mut self, a: u32, b: u32, opposite: bool) {
        let ((a, turned_a), (b, turned_b)) = (self.find(a), self.find(b));
        if a != b {
            self.parents[a.max(b) as usize] = (a.min(b), turned_a ^ turned_b ^ opposite);
        }
    }
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
