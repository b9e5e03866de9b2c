//! What of a shape can be between the vertices of a cloth: its corners and edges, each with a radius.
//!
//! A ball is a corner of its radius, a capsule an edge of its radius. Flat and hollow edges are none: there, vertices meet the
//! surface before anything else does.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::math::DVec3;
use parry3d::bounding_volume::Aabb;
use parry3d::math::{Pose, Vector};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::shape::{SharedShape, TypedShape};

use super::sheet;

/// Sides of the polygon that stands for a round rim.
const SIDES: u32 = 64;
/// Angle between the normals of both faces, rad, below which there is no edge.
const FLAT: f64 = 0.02;
/// Edges that meet where there is no corner, but a line of edges.
const LINE: usize = 2;
/// Cosine of the angle that a normal may be out of its cone by: rather a touch twice than none.
const SLACK: f64 = 0.02;

/// A corner or an edge, in the frame of the shape.
#[derive(Clone, Debug)]
pub(super) struct Feature {
    /// Both ends, m; the same twice for a corner.
    pub ends: [DVec3; 2],
    /// Which ends are corners: what touches there, touches those.
    pub at_corners: [bool; 2],
    /// Distance from there to the surface, m.
    pub radius: f64,
    /// Angle between the normals of the faces beside it, rad; of a corner that of its sharpest edge.
    pub angle: f64,
    /// Unit vectors along the faces or edges that meet there, away from it: no normal of the surface goes along any.
    away: Vec<DVec3>,
    /// Outwards, if that is known.
    outwards: Option<DVec3>,
}

impl Feature {
    /// Whether it is a single point.
    pub fn is_corner(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// The one of `normal` and its opposite that is a normal of the surface there; of two, that which points along `towards`.
    pub fn normal(&self, normal: DVec3, towards: DVec3) -> Option<DVec3> {
        let fits = |normal: DVec3| {
            self.away.iter().all(|away| away.dot(normal) <= SLACK) && self.outwards.is_none_or(|o| o.dot(normal) > 0.0)
        };
        let first = if normal.dot(towards) < 0.0 { -normal } else { normal };
        [first, -first].into_iter().find(|&normal| fits(normal))
    }

    fn bounds(&self) -> Aabb {
        let [a, b] = self.ends;
        let radius = DVec3::splat(self.radius);
        Aabb::new((a.min(b) - radius).as_vec3(), (a.max(b) + radius).as_vec3())
    }
}

/// All features of a shape.
pub(super) struct Features {
    all: Vec<Feature>,
    tree: Bvh,
    /// Half of the least thickness of any part, m: what is deeper inside came from another side.
    pub core: f64,
}

impl Features {
    pub fn new(shape: &SharedShape) -> Self {
        let (mut all, mut core) = (Vec::new(), f64::INFINITY);
        collect(shape, Pose::IDENTITY, &mut all, &mut core);
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, all.iter().map(Feature::bounds).enumerate());
        Self { all, tree, core }
    }

    /// Whether the shape is smooth all over.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Those whose boxes meet the box from `low` to `high`, with their numbers.
    pub fn near(&self, low: DVec3, high: DVec3, mut then: impl FnMut(u32, &Feature)) {
        let bounds = Aabb::new(low.as_vec3(), high.as_vec3());
        for index in self.tree.intersect_aabb(&bounds) {
            then(index, &self.all[index as usize]);
        }
    }

    #[cfg(test)]
    pub fn all(&self) -> &[Feature] {
        &self.all
    }
}

/// The features of a shape that has any, among those that are known.
pub(super) fn of_shape<'a>(known: &'a [(SharedShape, Arc<Features>)], shape: &SharedShape) -> Option<&'a Features> {
    let this = known.iter().find(|(known, _)| Arc::ptr_eq(&known.0, &shape.0));
    this.map(|(_, features)| &**features).filter(|features| !features.is_empty())
}

fn collect(shape: &SharedShape, pose: Pose, all: &mut Vec<Feature>, core: &mut f64) {
    let sheet = matches!(shape.as_typed_shape(), TypedShape::TriMesh(mesh) if sheet::is_sheet(mesh));
    let mut soup = |(vertices, triangles): (Vec<Vector>, Vec<[u32; 3]>), radius: f32, solid: bool| {
        if solid && !sheet && !matches!(shape.as_typed_shape(), TypedShape::HeightField(_)) {
            let thinnest = shape.compute_local_aabb().half_extents().min_element();
            *core = core.min(thinnest.into());
        }
        let vertices: Vec<_> = vertices.into_iter().map(|v| (pose * v).as_dvec3()).collect();
        let faces = if sheet {
            Faces::Sheet
        } else if solid {
            Faces::Solid
        } else {
            Faces::Shell
        };
        of_triangles(&vertices, &triangles, radius.into(), faces, all);
    };
    match shape.as_typed_shape() {
        TypedShape::Ball(ball) => {
            *core = core.min(ball.radius.into());
            all.push(round([pose.translation.as_dvec3(); 2], ball.radius.into()));
        }
        TypedShape::Capsule(capsule) => {
            *core = core.min(capsule.radius.into());
            let ends = [capsule.segment.a, capsule.segment.b].map(|end| (pose * end).as_dvec3());
            all.push(round(ends, capsule.radius.into()));
            all.extend(ends.map(|end| round([end; 2], capsule.radius.into())));
        }
        TypedShape::Segment(segment) => {
            let ends = [segment.a, segment.b].map(|end| (pose * end).as_dvec3());
            all.push(round(ends, 0.0));
        }
        TypedShape::Cuboid(cuboid) => soup(cuboid.to_trimesh(), 0.0, true),
        TypedShape::Cylinder(cylinder) => soup(cylinder.to_trimesh(SIDES), 0.0, true),
        TypedShape::Cone(cone) => soup(cone.to_trimesh(SIDES), 0.0, true),
        TypedShape::ConvexPolyhedron(hull) => soup(hull.to_trimesh(), 0.0, true),
        TypedShape::RoundCuboid(round) => soup(round.inner_shape.to_trimesh(), round.border_radius, true),
        TypedShape::RoundCylinder(round) => soup(round.inner_shape.to_trimesh(SIDES), round.border_radius, true),
        TypedShape::RoundCone(round) => soup(round.inner_shape.to_trimesh(SIDES), round.border_radius, true),
        TypedShape::RoundConvexPolyhedron(round) => soup(round.inner_shape.to_trimesh(), round.border_radius, true),
        TypedShape::Triangle(triangle) => {
            soup((vec![triangle.a, triangle.b, triangle.c], vec![[0, 1, 2]]), 0.0, false);
        }
        TypedShape::TriMesh(mesh) => {
            let solid = mesh.pseudo_normals_if_oriented().is_some();
            soup((mesh.vertices().to_vec(), mesh.indices().to_vec()), 0.0, solid);
        }
        TypedShape::HeightField(field) => {
            let (vertices, mut triangles) = field.to_trimesh();
            for triangle in &mut triangles {
                let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
                if (b - a).cross(c - a).y < 0.0 {
                    triangle.swap(1, 2);
                }
            }
            soup((vertices, triangles), 0.0, true);
        }
        TypedShape::Compound(compound) => {
            for (place, part) in compound.shapes() {
                collect(part, pose * *place, all, core);
            }
        }
        _ => {}
    }
}

fn round(ends: [DVec3; 2], radius: f64) -> Feature {
    let angle = core::f64::consts::PI;
    Feature { ends, at_corners: [false; 2], radius, angle, away: Vec::new(), outwards: None }
}

/// What triangles are the faces of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Faces {
    /// They face outwards.
    Solid,
    /// They face outwards, but for its rim.
    Sheet,
    /// Outside is on both sides.
    Shell,
}

/// What lies beside an edge of a mesh: along each face, away from the edge, and the face's normal.
#[derive(Default)]
struct Sides(Vec<[DVec3; 2]>);

/// The edges that meet at a vertex.
#[derive(Default)]
struct Spokes {
    /// Unit vectors along them, away from it.
    along: Vec<DVec3>,
    /// The largest of their angles, rad.
    sharpest: f64,
    /// Whether one of them is the rim of a sheet.
    rim: bool,
}

/// Edges and corners of triangles.
fn of_triangles(places: &[DVec3], triangles: &[[u32; 3]], radius: f64, faces: Faces, all: &mut Vec<Feature>) {
    let solid = faces != Faces::Shell;
    // A mesh may have a vertex of its own for every face.
    let mut numbers = HashMap::new();
    let welded: Vec<u32> = (0..)
        .zip(places)
        .map(|(index, place)| *numbers.entry((*place + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert(index))
        .collect();
    let mut edges: HashMap<[u32; 2], Sides> = HashMap::new();
    for triangle in triangles {
        let corners = triangle.map(|vertex| welded[vertex as usize]);
        for i in 0..3 {
            let [a, b, opposite] = [0, 1, 2].map(|j| corners[(i + j) % 3]);
            let [from, to, third] = [a, b, opposite].map(|v| places[v as usize]);
            let Some(along) = (to - from).try_normalize() else { continue };
            let inwards = (third - from) - (third - from).dot(along) * along;
            if let Some(inwards) = inwards.try_normalize() {
                edges.entry([a.min(b), a.max(b)]).or_default().0.push([inwards, along.cross(inwards)]);
            }
        }
    }
    let mut sharp: Vec<_> =
        edges.into_iter().filter_map(|(edge, sides)| Some((edge, angle(&sides, solid)?, sides))).collect();
    sharp.sort_unstable_by_key(|&(edge, ..)| edge);
    let mut spokes: HashMap<u32, Spokes> = HashMap::new();
    let first = all.len();
    let mut numbers = Vec::new();
    for (edge, angle, Sides(sides)) in sharp {
        numbers.push(edge);
        let ends = edge.map(|vertex| places[vertex as usize]);
        let along = (ends[1] - ends[0]).normalize();
        let rim = faces == Faces::Sheet && sides.len() == 1;
        for (end, spoke) in edge.into_iter().zip([along, -along]) {
            let at = spokes.entry(end).or_default();
            at.along.push(spoke);
            at.sharpest = at.sharpest.max(angle);
            at.rim |= rim;
        }
        let outwards = (solid && !rim).then(|| sides.iter().map(|side| side[1]).sum());
        let away = sides.iter().map(|side| side[0]).collect();
        all.push(Feature { ends, at_corners: [false; 2], radius, angle, away, outwards });
    }
    for (feature, edge) in all[first..].iter_mut().zip(numbers) {
        feature.at_corners = edge.map(|end| spokes[&end].along.len() > LINE);
    }
    let mut corners: Vec<_> = spokes.into_iter().filter(|(_, spokes)| spokes.along.len() > LINE).collect();
    corners.sort_unstable_by_key(|&(vertex, _)| vertex);
    for (vertex, Spokes { along: away, sharpest: angle, rim }) in corners {
        let ends = [places[vertex as usize]; 2];
        let outwards = (solid && !rim).then(|| -away.iter().sum::<DVec3>());
        all.push(Feature { ends, at_corners: [true; 2], radius, angle, away, outwards });
    }
}

/// How sharp an edge is, rad; `None` if it is flat, or hollow where only one side is outside.
fn angle(sides: &Sides, solid: bool) -> Option<f64> {
    let [[_, first], [inwards, second]] = sides.0[..] else {
        // The rim of a shell, or where several surfaces meet.
        return Some(core::f64::consts::PI);
    };
    let angle = first.angle_between(second);
    (angle > FLAT && !(solid && first.dot(inwards) > 0.0)).then_some(angle)
}

#[cfg(test)]
mod tests {
    use parry3d::shape::TriMeshFlags;

    use super::*;

    fn count(features: &Features) -> [usize; 2] {
        let corners = features.all().iter().filter(|feature| feature.is_corner()).count();
        [corners, features.all().len() - corners]
    }

    #[test]
    fn a_cuboid_has_eight_corners_and_twelve_edges() {
        let cuboid = parry3d::shape::Cuboid::new(Vector::new(0.1, 0.2, 0.3));
        let flags = TriMeshFlags::ORIENTED;
        let (vertices, triangles) = cuboid.to_trimesh();
        let mesh = SharedShape::trimesh_with_flags(vertices, triangles, flags).unwrap();
        let turned = SharedShape::compound(vec![(Pose::from_translation(Vector::X), SharedShape::new(cuboid))]);
        for shape in [SharedShape::new(cuboid), mesh, turned] {
            let features = Features::new(&shape);
            assert_eq!(count(&features), [8, 12]);
            assert!((features.core - 0.1).abs() < 1e-6);
            assert!(
                features.all().iter().all(|f| f.is_corner() || (f.angle - core::f64::consts::FRAC_PI_2).abs() < 1e-6)
            );
        }
    }

    #[test]
    fn only_normals_of_the_surface_count() {
        let features = Features::new(&SharedShape::cuboid(0.1, 0.1, 0.1));
        let edge = features
            .all()
            .iter()
            .find(|f| !f.is_corner() && (f.ends[0] + f.ends[1]).distance(DVec3::new(0.2, 0.2, 0.0)) < 1e-6);
        let edge = edge.expect("the edge along z at +x, +y");
        let between = DVec3::new(1.0, 2.0, 0.0).normalize();
        assert_eq!(edge.normal(-between, DVec3::ZERO), Some(between));
        assert_eq!(edge.normal(DVec3::new(1.0, -2.0, 0.0).normalize(), DVec3::X), None);
        let corner = features.all().iter().find(|f| f.is_corner() && f.ends[0].min_element() > 0.0).unwrap();
        assert_eq!(corner.normal(-DVec3::ONE.normalize(), DVec3::ZERO), Some(DVec3::ONE.normalize()));
        assert_eq!(corner.normal(DVec3::new(1.0, 1.0, -1.0).normalize(), DVec3::X), None);
    }

    #[test]
    fn round_shapes_have_radii_and_rims_edges() {
        assert_eq!(count(&Features::new(&SharedShape::ball(0.2))), [1, 0]);
        assert_eq!(count(&Features::new(&SharedShape::capsule_y(0.2, 0.1))), [2, 1]);
        let cylinder = Features::new(&SharedShape::cylinder(0.2, 0.1));
        let rims = cylinder.all().iter().filter(|f| !f.is_corner() && f.angle > 1.0).count();
        assert_eq!(rims, 2 * SIDES as usize);
        assert_eq!(count(&Features::new(&SharedShape::halfspace(Vector::Y))), [0, 0]);
    }

    #[test]
    fn hollow_edges_count_for_shells_only() {
        let corners = [Vector::ZERO, Vector::Z, Vector::new(1.0, 0.5, 0.0), Vector::new(-1.0, 0.5, 0.0)];
        let valley = SharedShape::trimesh(corners.to_vec(), vec![[0, 1, 2], [1, 0, 3]]).unwrap();
        assert_eq!(count(&Features::new(&valley))[1], 5);
        let mut near = 0;
        Features::new(&valley).near(DVec3::new(-0.1, -0.1, 0.4), DVec3::new(0.1, 0.1, 0.5), |_, _| near += 1);
        assert!(near >= 1);
    }
}
