//! Surfaces of revolution: vessels and turned wood.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};

/// Points on each rounded corner.
const ARC: usize = 5;

/// Corners around the axis.
const SEGMENTS: usize = 64;

/// Turns an outline of (radius, height) about the y axis. From the lower end of the axis outwards, up, and back to the axis, it is
/// the surface of a solid. Its corners are rounded, `radius` before and behind each.
pub fn turned(outline: &[(f32, f32)], radius: f32) -> Mesh {
    let outline = rounded(outline, radius);
    let direction = |segment: usize| Vec2::from_angle(std::f32::consts::TAU * segment as f32 / SEGMENTS as f32);
    let ring = |point: &Vec2| {
        let point = *point;
        (0..SEGMENTS).map(direction).map(move |d| Vec3::new(point.x * d.x, point.y, point.x * d.y))
    };
    let positions: Vec<Vec3> = outline.iter().flat_map(ring).collect();
    let vertex = |ring: usize, segment: usize| (ring * SEGMENTS + segment % SEGMENTS) as u32;
    let mut indices = Vec::new();
    for ring in 0..outline.len() - 1 {
        for segment in 0..SEGMENTS {
            let (a, b) = (vertex(ring, segment), vertex(ring, segment + 1));
            let (c, d) = (vertex(ring + 1, segment), vertex(ring + 1, segment + 1));
            // On the axis two of the corners are one place.
            if outline[ring].x > 0.0 {
                indices.extend([a, c, b]);
            }
            if outline[ring + 1].x > 0.0 {
                indices.extend([b, c, d]);
            }
        }
    }
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices));
    // What is flat stays so up to its rim.
    mesh.compute_area_weighted_normals();
    mesh
}

/// Replaces each inner corner by an arc.
fn rounded(outline: &[(f32, f32)], radius: f32) -> Vec<Vec2> {
    let points: Vec<Vec2> = outline.iter().map(|&point| point.into()).collect();
    let mut smooth = vec![points[0]];
    for corner in points.windows(3) {
        let towards = |other: Vec2| {
            let way = other - corner[1];
            corner[1] + way * (radius / way.length()).min(0.5)
        };
        let (start, end) = (towards(corner[0]), towards(corner[2]));
        for nth in 0..ARC {
            let share = nth as f32 / (ARC - 1) as f32;
            smooth.push(start.lerp(corner[1], share).lerp(corner[1].lerp(end, share), share));
        }
    }
    smooth.push(points[points.len() - 1]);
    smooth
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_cloth::prelude::ClothCollider;

    #[test]
    fn a_closed_outline_is_a_solid() {
        let mesh = turned(&[(0.0, 0.0), (0.5, 0.0), (0.5, 1.0), (0.0, 1.0)], 0.1);
        let collider = ClothCollider::from_mesh(&mesh).expect("a surface");
        let is_inside = |x, y, z| collider.shape().contains_local_point(Vec3::new(x, y, z));
        assert!(is_inside(0.0, 0.5, 0.0) && is_inside(0.3, 0.1, -0.3));
        assert!(!is_inside(0.6, 0.5, 0.0) && !is_inside(0.0, 1.1, 0.0));
        assert!(!is_inside(0.49, 0.99, 0.0), "the rim is round");
    }
}
