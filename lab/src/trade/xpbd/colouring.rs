//! Colours of elements, such that those of one colour share no vertex.

/// The elements by colour, each colour in the order given: greedily, the first colour that none of its vertices has.
///
/// # Panics
/// If a vertex has more than 128 elements.
pub(super) fn by_colour<const V: usize>(elements: &[[u32; V]], vertex_count: usize) -> Vec<Vec<u32>> {
    let mut taken = vec![0_u128; vertex_count];
    let mut colours: Vec<Vec<u32>> = Vec::new();
    for (element, vertices) in elements.iter().enumerate() {
        let used = vertices.iter().fold(0, |used, &v| used | taken[v as usize]);
        let colour = used.trailing_ones() as usize;
        assert!(colour < 128, "a vertex has too many elements");
        for &v in vertices {
            taken[v as usize] |= 1 << colour;
        }
        if colour == colours.len() {
            colours.push(Vec::new());
        }
        colours[colour].push(element as u32);
    }
    colours
}

#[cfg(test)]
mod tests {
    use bevy_cloth::physics::BendingModel;

    use super::*;
    use crate::scenes::{Meshing, Sheet};

    #[test]
    fn elements_of_a_colour_share_no_vertex_and_colours_are_few() {
        let shape = Sheet::new(17, Meshing::Irregular).shape(BendingModel::Hinge);
        let elements: Vec<_> = shape.hinges.iter().map(|hinge| hinge.vertices).collect();
        let colours = by_colour(&elements, 289);
        assert_eq!(colours.iter().map(Vec::len).sum::<usize>(), elements.len());
        for colour in &colours {
            let mut vertices: Vec<_> = colour.iter().flat_map(|&element| elements[element as usize]).collect();
            vertices.sort_unstable();
            assert!(vertices.windows(2).all(|pair| pair[0] != pair[1]));
        }
        assert!(colours.len() < 30, "{}", colours.len());
    }
}
