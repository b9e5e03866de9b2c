//! An open mesh that is solid from one side: ground, a floor, a wall of one layer.

use bevy::math::DVec3;
use parry3d::query::PointQueryWithLocation;
use parry3d::shape::{TriMesh, TriMeshTopology, TrianglePointLocation};

use super::surface::Nearest;

/// Distances below this are rounding of f32, m: they have no direction.
const ROUNDING: f64 = 1e-6;
/// Looked so far at least, m: what rests on it goes nowhere, and asks no further.
const LEAST: f64 = 1e-3;

/// Whether a mesh is one: its triangles say which side is outside, and the first of them has a side without neighbour. (Whoever builds
/// such a mesh puts such a triangle first: looking at all of them would take too long in every step.)
pub(crate) fn is_sheet(mesh: &TriMesh) -> bool {
    let border = |topology: &TriMeshTopology| (0..3).any(|edge| is_rim(topology, edge));
    mesh.pseudo_normals_if_oriented().is_some() && mesh.topology().is_some_and(border)
}

/// The nearest point of it. Behind the surface distances are negative, but not beside its rim: that has no inside.
pub(super) fn nearest(mesh: &TriMesh, p: DVec3, within: f64) -> Nearest {
    let within = within + LEAST;
    let found = mesh.project_local_point_and_get_location_with_max_dist(p.as_vec3(), false, within as f32);
    let (Some((on, (index, location))), Some(normals), Some(topology)) =
        (found, mesh.pseudo_normals_if_oriented(), mesh.topology())
    else {
        return Nearest { distance: within, normal: DVec3::Y };
    };
    let [a, b, c] = mesh.indices()[index as usize].map(|vertex| mesh.vertices()[vertex as usize].as_dvec3());
    let of_face = (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::Y);
    let (up, rim) = match location {
        TrianglePointLocation::OnEdge(edge, _) => {
            (normals.edges_pseudo_normal[index as usize][edge as usize].as_dvec3(), is_rim(topology, 3 * index + edge))
        }
        TrianglePointLocation::OnVertex(corner) => {
            let vertex = mesh.indices()[index as usize][corner as usize];
            (normals.vertices_pseudo_normal[vertex as usize].as_dvec3(), is_at_rim(topology, 3 * index + corner))
        }
        // In f64 all over a triangle: it is where cloth lies.
        _ => return Nearest { distance: of_face.dot(p - a), normal: of_face },
    };
    let away = p - on.point.as_dvec3();
    let distance = away.length();
    if distance < ROUNDING {
        return Nearest { distance: 0.0, normal: up.try_normalize().unwrap_or(of_face) };
    }
    let side = if !rim && away.dot(up) < 0.0 { -1.0 } else { 1.0 };
    Nearest { distance: side * distance, normal: side / distance * away }
}

/// Whether a half edge has a triangle on one side only.
fn is_rim(topology: &TriMeshTopology, half_edge: u32) -> bool {
    topology.half_edges[half_edge as usize].twin == u32::MAX
}

/// Whether the rim goes through the vertex that a half edge begins at.
fn is_at_rim(topology: &TriMeshTopology, first: u32) -> bool {
    let next = |half_edge: u32| topology.half_edges[half_edge as usize].next;
    let mut half_edge = first;
    loop {
        let into = next(next(half_edge));
        if is_rim(topology, into) {
            return true;
        }
        half_edge = topology.half_edges[into as usize].twin;
        if half_edge == first {
            return false;
        }
    }
}

#[cfg(test)]
mod tests {
    use parry3d::math::Vector;
    use parry3d::shape::TriMeshFlags;

    use super::*;

    /// A roof along x, its ridge at a height of 0.5 m, open below.
    fn roof() -> TriMesh {
        let at = |x: f32, y: f32, z: f32| Vector::new(x, y, z);
        let vertices = vec![
            at(-1.0, 0.0, 1.0),
            at(1.0, 0.0, 1.0),
            at(-1.0, 0.5, 0.0),
            at(1.0, 0.5, 0.0),
            at(-1.0, 0.0, -1.0),
            at(1.0, 0.0, -1.0),
        ];
        let triangles = vec![[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]];
        TriMesh::with_flags(vertices, triangles, TriMeshFlags::ORIENTED | TriMeshFlags::HALF_EDGE_TOPOLOGY).unwrap()
    }

    #[test]
    fn it_has_an_inside_behind_it_but_not_beside_its_rim() {
        let roof = roof();
        assert!(is_sheet(&roof));
        let ridge = DVec3::new(0.0, 0.5, 0.0);
        for (off, distance) in [(0.1, 0.1), (-0.1, -0.1 * (1.0 / 1.25_f64.sqrt()))] {
            let found = nearest(&roof, ridge + off * DVec3::Y, 9.0);
            assert!((found.distance - distance).abs() < 1e-6 && found.normal.y > 0.8, "{found:?}");
        }
        // Beside the rim, higher and lower than the plane that ends there.
        for y in [0.1, -0.1] {
            let found = nearest(&roof, DVec3::new(1.2, y, 0.9), 9.0);
            assert!(found.distance > 0.2 && found.normal.x > 0.8, "{found:?}");
        }
        assert_eq!(nearest(&roof, DVec3::Y * 5.0, 0.5).distance, 0.5 + LEAST);
    }
}
