//! In which order vertices stand in memory.

use bevy_cloth::physics::RestShape;

/// An order of vertices.
#[derive(Clone, Debug)]
pub(super) struct Order {
    /// Place of each vertex.
    pub inner: Vec<u32>,
    /// Vertex at each place.
    pub outer: Vec<u32>,
}

impl Order {
    /// In bands across the longest side of the rest shape's bounding box, each as wide as a typical edge, and in each band along
    /// the second side: neighbours are near each other in memory, and elements taken in this order go through it evenly.
    pub fn new(shape: &RestShape) -> Self {
        let x = &shape.positions;
        let low = x.iter().copied().reduce(|a, b| a.min(b)).unwrap_or_default();
        let extent = x.iter().map(|&x| x - low).reduce(|a, b| a.max(b)).unwrap_or_default();
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| extent[b].total_cmp(&extent[a]));
        let mut lengths: Vec<_> = shape.edges.iter().map(|e| x[e[0] as usize].distance(x[e[1] as usize])).collect();
        let middle = lengths.len() / 2;
        let width = *lengths.select_nth_unstable_by(middle, f64::total_cmp).1;

        let place = |v: u32| {
            let x = x[v as usize] - low;
            ((x[axes[0]] / width).round() as i64, x[axes[1]])
        };
        let mut outer: Vec<u32> = (0..x.len() as u32).collect();
        outer.sort_by(|&a, &b| {
            let (a, b) = (place(a), place(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let mut inner = vec![0; x.len()];
        for (place, &vertex) in outer.iter().enumerate() {
            inner[vertex as usize] = place as u32;
        }
        Self { inner, outer }
    }
}

#[cfg(test)]
mod tests {
    use bevy_cloth::physics::BendingModel;

    use super::*;
    use crate::scenes::{Meshing, Sheet};

    #[test]
    fn neighbours_are_near_each_other() {
        let shape = Sheet::new(20, Meshing::Shuffled).shape(BendingModel::Hinge);
        let order = Order::new(&shape);
        assert!((0..400).all(|v| order.outer[order.inner[v] as usize] == v as u32));
        let apart = |e: &[u32; 2]| order.inner[e[0] as usize].abs_diff(order.inner[e[1] as usize]);
        assert!(shape.edges.iter().map(apart).max() < Some(60));
    }
}
