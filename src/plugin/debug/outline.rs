//! Shapes of colliders as lines.

use bevy::math::Vec3;
use parry3d::shape::{ConvexPolyhedron, TypedShape};

/// Segments of a circle.
const SEGMENTS: u32 = 24;
/// Segments of a rounded corner.
const CORNER: u32 = 4;

/// Points, and lines between them. Nothing for shapes without end, for those made of others, and for those of users.
pub(super) fn outline(shape: &TypedShape) -> (Vec<Vec3>, Vec<[u32; 2]>) {
    match shape {
        TypedShape::Ball(ball) => ball.to_outline(SEGMENTS),
        TypedShape::Cuboid(cuboid) => cuboid.to_outline(),
        TypedShape::Capsule(capsule) => capsule.to_outline(SEGMENTS),
        TypedShape::Cylinder(cylinder) => cylinder.to_outline(SEGMENTS),
        TypedShape::Cone(cone) => cone.to_outline(SEGMENTS),
        TypedShape::Segment(segment) => (vec![segment.a, segment.b], vec![[0, 1]]),
        TypedShape::Triangle(t) => edges(vec![t.a, t.b, t.c], &[[0, 1, 2]]),
        TypedShape::Polyline(line) => (line.vertices().to_vec(), line.indices().to_vec()),
        TypedShape::TriMesh(mesh) => edges(mesh.vertices().to_vec(), mesh.indices()),
        TypedShape::HeightField(field) => {
            let (points, triangles) = field.to_trimesh();
            edges(points, &triangles)
        }
        TypedShape::ConvexPolyhedron(body) => body_edges(body),
        TypedShape::RoundCuboid(round) => round.to_outline(CORNER),
        TypedShape::RoundTriangle(round) => {
            let t = round.inner_shape;
            edges(vec![t.a, t.b, t.c], &[[0, 1, 2]])
        }
        TypedShape::RoundCylinder(round) => round.to_outline(SEGMENTS, CORNER),
        TypedShape::RoundCone(round) => round.to_outline(SEGMENTS, CORNER),
        TypedShape::RoundConvexPolyhedron(round) => round.to_outline(CORNER),
        TypedShape::Voxels(voxels) => voxels.to_outline(),
        TypedShape::HalfSpace(_) | TypedShape::Compound(_) | TypedShape::Custom(_) => Default::default(),
    }
}

fn edges(points: Vec<Vec3>, triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 2]>) {
    (points, triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect())
}

fn body_edges(body: &ConvexPolyhedron) -> (Vec<Vec3>, Vec<[u32; 2]>) {
    (body.points().to_vec(), body.edges().iter().map(|edge| edge.vertices).collect())
}
