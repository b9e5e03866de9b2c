//! Convex hulls of points.

use bevy::math::Vec3;
use parry3d::shape::SharedShape;
use parry3d::transformation::try_convex_hull;

use super::error::ClothShapeError;

/// Height over a plane, relative to the size in it, below which points are in the plane.
const FLAT: f32 = 1e-5;

/// The smallest convex body around points.
pub(super) fn hull(points: &[Vec3]) -> Result<SharedShape, ClothShapeError> {
    finite(points)?;
    if is_flat(points) {
        return Err(ClothShapeError::NoHull);
    }
    // The search goes wrong where points are equal.
    let mut distinct = points.to_vec();
    distinct.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    distinct.dedup();
    let (vertices, triangles) = try_convex_hull(&distinct).map_err(|_| ClothShapeError::NoHull)?;
    SharedShape::convex_mesh(vertices, &triangles).ok_or(ClothShapeError::NoHull)
}

/// Points that are numbers.
pub(super) fn finite(points: &[Vec3]) -> Result<(), ClothShapeError> {
    match points.iter().position(|point| !point.is_finite()) {
        Some(index) => Err(ClothShapeError::NotFinite(index)),
        None => Ok(()),
    }
}

/// Whether all points are in one plane: that through the first, the one farthest from it, and the one farthest from the line
/// through both.
fn is_flat(points: &[Vec3]) -> bool {
    let Some(&origin) = points.first() else { return true };
    let largest = |measure: &dyn Fn(Vec3) -> f32| {
        points.iter().map(|&p| p - origin).max_by(|&a, &b| measure(a).total_cmp(&measure(b))).unwrap_or_default()
    };
    let length = largest(&Vec3::length);
    let axis = length.normalize_or_zero();
    let breadth = largest(&|p| p.reject_from_normalized(axis).length());
    let normal = axis.cross(breadth).normalize_or_zero();
    let height = largest(&|p| p.dot(normal).abs()).dot(normal).abs();
    height <= FLAT * length.length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_in_a_plane_have_no_hull() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let slope = |p: Vec3| Vec3::new(p.x, p.y, 3.0 * p.x - p.y);
        for points in [&[][..], &[Vec3::ONE], &[Vec3::ONE; 5], &[Vec3::ZERO, Vec3::X, 2.0 * Vec3::X], &triangle] {
            assert_eq!(hull(points).err(), Some(ClothShapeError::NoHull), "{points:?}");
        }
        let plane: Vec<_> = (0..100).map(|i| slope(Vec3::new((i % 10) as f32, (i / 10) as f32, 0.0))).collect();
        assert_eq!(hull(&plane).err(), Some(ClothShapeError::NoHull));
        let thick: Vec<_> = plane.iter().copied().chain([Vec3::new(0.0, 0.0, 0.1)]).collect();
        assert!(hull(&thick).is_ok());
        assert_eq!(hull(&[Vec3::ZERO, Vec3::NAN]).err(), Some(ClothShapeError::NotFinite(1)));
    }

    #[test]
    fn small_and_large_ones_are_found_with_points_repeated() {
        let corners: Vec<_> = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
        for size in [1e-3, 1.0, 1e4] {
            let points: Vec<_> = corners.iter().chain(&corners).map(|&corner| size * corner).collect();
            let aabb = hull(&points).expect("a hull").compute_local_aabb();
            assert!(aabb.mins.abs_diff_eq(Vec3::ZERO, 0.0) && aabb.maxs.abs_diff_eq(Vec3::splat(size), 0.0));
        }
    }
}
