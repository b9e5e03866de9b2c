//! Material axes of a triangle: warp along growing u, or along a direction of the mesh where there is no sane u.

use bevy::math::{DVec2, DVec3};

/// Orthonormal axes in the plane of a rest triangle.
pub(super) struct Frame {
    warp: DVec3,
    weft: DVec3,
}

impl Frame {
    /// Material coordinates (along warp, along weft) of a vector in the plane of the triangle.
    pub fn to_material(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.warp), v.dot(self.weft))
    }
}

/// The material axes of a triangle with area. Texture coordinates give a direction only, never a length: the metric is that
/// of the 3D rest triangle, so textures may be scaled, mirrored or atlased at will.
/// `turn` is cosine and sine of the angle from growing u to the warp.
pub(super) fn frame(corners: [DVec3; 3], uvs: Option<[[f32; 2]; 3]>, turn: DVec2) -> Frame {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize();
    let u = uvs.and_then(|uvs| direction_of_u(corners, uvs)).unwrap_or_else(|| fallback(normal));
    let u = u.reject_from_normalized(normal).normalize();
    let v = normal.cross(u);
    Frame { warp: u * turn.x + v * turn.y, weft: v * turn.x - u * turn.y }
}

/// ∂p/∂u of the linear map from texture to space, if the texture triangle has a sane shape.
fn direction_of_u([a, b, c]: [DVec3; 3], uvs: [[f32; 2]; 3]) -> Option<DVec3> {
    let [ua, ub, uc] = uvs.map(|[u, v]| DVec2::new(u as f64, v as f64));
    let (t1, t2) = (ub - ua, uc - ua);
    let area = t1.perp_dot(t2);
    let size = t1.length_squared().max(t2.length_squared());
    // Written so that NaN and infinity fail too.
    if !(size.is_finite() && area.abs() > 1e-6 * size) {
        return None;
    }
    ((b - a) * t2.y - (c - a) * t1.y).try_normalize().map(|u| u * area.signum())
}

/// Without texture coordinates the warp is the X axis laid into the plane of the triangle; where the triangle faces along X,
/// the Y axis. The choice is the same over each flat or gently curved part of a mesh.
fn fallback(normal: DVec3) -> DVec3 {
    if normal.x.abs() < 0.9 { DVec3::X } else { DVec3::Y }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [DVec3::new(1.0, 0.0, 5.0), DVec3::new(3.0, 0.0, 5.0), DVec3::new(1.0, 1.0, 5.0)];

    fn warp(uvs: Option<[[f32; 2]; 3]>, angle: f64) -> DVec3 {
        let frame = frame(CORNERS, uvs, DVec2::new(angle.cos(), angle.sin()));
        assert!(frame.warp.dot(frame.weft).abs() < 1e-15);
        frame.warp
    }

    #[test]
    fn warp_follows_u_whatever_the_scale_and_mirroring_of_the_texture() {
        assert!(warp(Some([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), 0.0).distance(DVec3::X) < 1e-12);
        assert!(warp(Some([[0.0, 0.0], [0.0, 9.0], [0.01, 0.0]]), 0.0).distance(DVec3::Y) < 1e-12);
        assert!(warp(Some([[0.0, 0.0], [-1.0, 0.0], [0.0, 1.0]]), 0.0).distance(-DVec3::X) < 1e-12);
        let turned = warp(Some([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), core::f64::consts::FRAC_PI_2);
        assert!(turned.distance(DVec3::Y) < 1e-12);
    }

    #[test]
    fn insane_texture_coordinates_fall_back_to_the_rest_triangle() {
        for uvs in [
            [[0.5, 0.5]; 3],
            [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]],
            [[f32::NAN, 0.0], [1.0, 0.0], [0.0, 1.0]],
            [[f32::INFINITY, 0.0], [1.0, 0.0], [0.0, 1.0]],
        ] {
            assert!(warp(Some(uvs), 0.0).distance(DVec3::X) < 1e-12, "{uvs:?}");
        }
        assert!(warp(None, 0.0).distance(DVec3::X) < 1e-12);
    }
}
