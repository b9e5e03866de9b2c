//! Momentum of a cloth that nothing holds.

use bevy::math::{DMat3, DVec3};

/// Corrects a truncated solve of a cloth that nothing holds, so that linear momentum is exact whatever the tolerance and the precision,
/// and angular momentum up to the geometric stiffness.
///
/// Elastic forces have no part in the mean of the moves, so that is made `mean`. About the center of mass the moves are corrected by
/// `R (RᵀMR)⁻¹ Rᵀ r` (R: three rotations, r: the residual of the moves).
pub(super) fn correct(
    moves: &mut [DVec3],
    mean: DVec3,
    residual: impl Fn(usize) -> DVec3,
    x: &[DVec3],
    masses: &[f64],
) {
    let total: f64 = masses.iter().sum();
    let weighted = |values: &[DVec3]| masses.iter().zip(values).map(|(&m, &x)| m * x).sum::<DVec3>() / total;
    let center = weighted(x);
    let (mut torque, mut inertia) = (DVec3::ZERO, DMat3::ZERO);
    for (vertex, (&mass, &x)) in masses.iter().zip(x).enumerate() {
        let arm = x - center;
        torque += arm.cross(residual(vertex));
        // The inertia tensor, m (|a|² I − a aᵀ).
        let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
        inertia += mass * (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer);
    }
    let translation = mean - weighted(moves);
    // A cloth collapsed to a line has no inertia about it: then there is no turn to correct.
    let scale = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
    let turn = if inertia.determinant() > 1e-9 * scale.powi(3) { inertia.inverse() * torque } else { DVec3::ZERO };
    for (d, &x) in moves.iter_mut().zip(x) {
        *d += translation + turn.cross(x - center);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rigid_error_is_removed_to_rounding() {
        let x = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.3, 0.2, 0.9)];
        let masses = [1.0, 2.0, 0.5, 3.0];
        let rigid = |x: DVec3| DVec3::new(0.1, -0.2, 0.3) + DVec3::new(0.5, 0.4, -0.1).cross(x);
        let mean = (0..4).map(|v| masses[v] * rigid(x[v])).sum::<DVec3>() / 6.5;
        let mut moves = [DVec3::ZERO; 4];
        correct(&mut moves, mean, |v| masses[v] * rigid(x[v]), &x, &masses);
        for (d, x) in moves.iter().zip(x) {
            assert!(d.distance(rigid(x)) < 1e-14);
        }
    }

    #[test]
    fn a_cloth_on_a_line_is_translated_only() {
        let x = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        let mut moves = [DVec3::ZERO; 3];
        correct(&mut moves, DVec3::Y, |_| DVec3::Y, &x, &[1.0; 3]);
        assert_eq!(moves, [DVec3::Y; 3]);
    }
}
