//! Surfaces of triangles.

use bevy::math::{IVec3, Vec3};
use bevy::platform::collections::{HashMap, HashSet};
use parry3d::shape::{SharedShape, TriMeshFlags};

use super::error::ClothShapeError;
use super::hull::finite;
use super::winding::{Distinct, agree, distinct, is_closed, is_consistent, turn, volume};

/// Vertices nearer than this share of the diagonal are one: they are split along seams of normals and texture coordinates.
const WELD: f32 = 1e-5;

/// A mesh of triangles: solid if it is closed, one-sided if it is open but wound one way, else a shell with two sides.
///
/// Says in the log what it had to do to them.
pub(super) fn surface(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<SharedShape, ClothShapeError> {
    finite(vertices)?;
    let count = vertices.len();
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= count) {
            return Err(ClothShapeError::IndexOutOfRange { triangle, vertex, count });
        }
    }
    let (places, place_of) = weld(vertices);
    let welded = triangles.iter().map(|corners| corners.map(|vertex| place_of[vertex as usize]));
    let triangles: Vec<_> = welded.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let (triangles, flags) = wound(triangles, &places);
    SharedShape::trimesh_with_flags(places, triangles, flags).map_err(|_| ClothShapeError::Empty("triangles".into()))
}

/// The triangles of a field of heights, all counter-clockwise seen from above.
pub(super) fn ground((vertices, mut triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    for triangle in &mut triangles {
        let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
        *triangle = turn(*triangle, (b - a).cross(c - a).y < 0.0);
    }
    (vertices, triangles)
}

/// Decides what triangles are the surface of, and brings them into the order and the direction that this needs.
fn wound(mut triangles: Vec<[u32; 3]>, places: &[Vec3]) -> (Vec<[u32; 3]>, TriMeshFlags) {
    let Distinct { triangles: single, doubled } = distinct(&triangles);
    // A few doubled ones are the common faces of solids that were put together: they are inside, and nothing touches them.
    let is_doubled = 2 * doubled > single.len();
    if is_doubled || doubled == 0 {
        triangles = single;
    }
    if !is_closed(&triangles)
        && !is_consistent(&triangles)
        && let Some(turned) = agree(&mut triangles, places)
        && !is_doubled
    {
        tracing::warn!(
            "{turned} of {} triangles of a collider mesh were wound the other way round than their neighbors, and are taken as \
             turned: recalculate its normals where it was made",
            triangles.len(),
        );
    }
    if is_closed(&triangles) {
        if volume(triangles.iter().copied(), places) < 0.0 {
            if is_doubled {
                triangles.iter_mut().for_each(|triangle| *triangle = turn(*triangle, true));
            } else {
                tracing::warn!(
                    "the {} triangles of a closed collider mesh face inwards: it keeps cloth inside, as a room does. If it is meant \
                     to be solid, flip its normals where it was made, or look for a mirrored scale that was applied to it",
                    triangles.len(),
                );
            }
        }
        (triangles, TriMeshFlags::ORIENTED)
    } else if is_doubled || !is_consistent(&triangles) {
        (triangles, TriMeshFlags::empty())
    } else {
        // The physics tells a surface that is open by its first triangle.
        if let Some(open) = open_triangle(&triangles) {
            triangles.swap(0, open);
        }
        (triangles, TriMeshFlags::ORIENTED | TriMeshFlags::HALF_EDGE_TOPOLOGY)
    }
}

/// A triangle that has no neighbor at one of its edges.
fn open_triangle(triangles: &[[u32; 3]]) -> Option<usize> {
    let edges = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let passed: HashSet<[u32; 2]> = triangles.iter().flat_map(edges).collect();
    triangles.iter().position(|triangle| edges(triangle).iter().any(|&[from, to]| !passed.contains(&[to, from])))
}

/// The different places of vertices, and which of them each has.
fn weld(vertices: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    let min = vertices.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let max = vertices.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let distance = (WELD * (max - min).length()).max(f32::MIN_POSITIVE);
    let mut cells: HashMap<IVec3, Vec<u32>> = HashMap::with_capacity(vertices.len());
    let mut places: Vec<Vec3> = Vec::new();
    let place_of = vertices.iter().map(|&vertex| {
        // What is near is in this cell of twice the distance or in those on the nearer side of it.
        let corner = ((vertex - min) / (2.0 * distance) - 0.5).floor().as_ivec3();
        let around = (0..8).map(|i| corner + IVec3::new(i & 1, i >> 1 & 1, i >> 2));
        let mut near = around.filter_map(|cell| cells.get(&cell)).flatten().copied();
        near.find(|&place| places[place as usize].distance(vertex) <= distance).unwrap_or_else(|| {
            let place = places.len() as u32;
            places.push(vertex);
            cells.entry(((vertex - min) / (2.0 * distance)).floor().as_ivec3()).or_default().push(place);
            place
        })
    });
    let place_of = place_of.collect();
    (places, place_of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::{Cuboid, Mesh, MeshBuilder, Meshable, Plane3d, Sphere};

    use crate::plugin::contact::{ClothCollider, ClothColliderKind};

    #[test]
    fn a_closed_mesh_is_solid_and_an_open_one_is_not() {
        let is_inside = |mesh: Mesh, point: Vec3| {
            let collider = ClothCollider::from_mesh(&mesh).expect("a shape");
            collider.shape().contains_local_point(point)
        };
        let inside = Vec3::new(0.1, 0.05, 0.02);
        assert!(is_inside(Sphere::new(0.5).mesh().uv(24, 12), inside), "with a seam and poles");
        assert!(is_inside(Cuboid::from_length(0.5).into(), inside), "with normals of its own on each side");
        assert!(!is_inside(Cuboid::from_length(0.5).into(), Vec3::new(0.3, 0.3, 0.3)), "off a corner");
        let plane = ClothCollider::from_mesh(&Plane3d::default().mesh().size(2.0, 2.0).build()).expect("a shape");
        assert_eq!(plane.kind(), ClothColliderKind::OneSided);
    }

    #[test]
    fn vertices_at_a_place_are_one() {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::splat(-4e-6), Vec3::X + 4e-6, Vec3::X + 1e-3];
        let (places, place_of) = weld(&vertices);
        assert_eq!((places.len(), place_of), (3, vec![0, 1, 0, 1, 2]));
    }
}
