//! Colours of nodes, such that neighbours differ.

/// A colour for each node of a graph, greedily in this order: the first that no neighbour has. A node may be listed several
/// times among the neighbours of another.
pub(crate) fn colour(neighbours: &[Vec<u32>], order: impl Iterator<Item = u32>) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let mut colours = vec![NONE; neighbours.len()];
    // By colour: the last node that a neighbour of this colour was found for.
    let mut taken_for = Vec::new();
    for node in order {
        for &neighbour in &neighbours[node as usize] {
            if let Some(taken) = taken_for.get_mut(colours[neighbour as usize] as usize) {
                *taken = node;
            }
        }
        let free = taken_for.iter().position(|&taken| taken != node).unwrap_or_else(|| {
            taken_for.push(NONE);
            taken_for.len() - 1
        });
        colours[node as usize] = free as u32;
    }
    colours
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_differ_and_colours_are_few() {
        // A ring of six, with one chord.
        let edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [0, 2]];
        let mut neighbours = vec![Vec::new(); 6];
        for [a, b] in edges {
            neighbours[a as usize].push(b);
            neighbours[b as usize].push(a);
        }
        let colours = colour(&neighbours, 0..6);
        assert!(edges.iter().all(|[a, b]| colours[*a as usize] != colours[*b as usize]), "{colours:?}");
        assert_eq!(colours.iter().max(), Some(&2));
    }
}
