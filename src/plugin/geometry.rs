//! Boxes around points, and linear maps taken apart.

use bevy::math::{DMat3, DVec3};

/// Iterations of [`polar`] at most: a stretch of 1e6 along one axis takes 24.
const ITERATIONS: u32 = 40;

/// Lower and upper corner of the box around points.
pub(super) fn extent(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Q and P of the polar decomposition Q P of a linear map that has an inverse: Q is orthogonal, and mirrors if the map does; P is
/// symmetric and positive definite. By Newton's iteration (Higham 1986).
pub(super) fn polar(linear: DMat3) -> (DMat3, DMat3) {
    let mut orthogonal = linear;
    for _ in 0..ITERATIONS {
        let next = 0.5 * (orthogonal + orthogonal.inverse().transpose());
        let done = next.abs_diff_eq(orthogonal, 1e-15);
        orthogonal = next;
        if done {
            break;
        }
    }
    let stretch = orthogonal.transpose() * linear;
    (orthogonal, 0.5 * (stretch + stretch.transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_taken_apart_into_turn_and_stretch() {
        let turn = DMat3::from_rotation_z(2.5) * DMat3::from_rotation_x(0.7);
        for scale in [DVec3::ONE, DVec3::splat(1e-3), DVec3::new(2.0, 1.0, 0.5), DVec3::new(1e5, 1.0, 1.0)] {
            let axes = DMat3::from_rotation_y(0.3);
            let expected = axes * DMat3::from_diagonal(scale) * axes.transpose();
            for sign in [1.0, -1.0] {
                let (orthogonal, stretch) = polar(sign * turn * expected);
                let error = 1e-9 * scale.max_element();
                assert!(stretch.abs_diff_eq(expected, error), "{stretch} is not {expected}");
                assert!((orthogonal * stretch).abs_diff_eq(sign * turn * expected, error));
            }
        }
    }
}
