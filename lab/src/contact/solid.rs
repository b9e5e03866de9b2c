//! Shapes whose distance is known without what the physics knows it by: in closed form, or as parry has it.

use bevy::math::DVec3;
use bevy_cloth::parry3d::math::{Pose, Vector};
use bevy_cloth::parry3d::query::PointQuery;
use bevy_cloth::parry3d::shape::{Ball, HeightField, SharedShape, TriMeshFlags};
use bevy_cloth::parry3d::utils::Array2;

/// From here on the distance of a mesh is that of its box, m.
const FAR: f64 = 0.1;

/// A shape in its own frame, m.
#[derive(Clone)]
pub enum Solid {
    /// Around the origin.
    Ball {
        /// m.
        radius: f64,
    },
    /// Around the origin.
    Cuboid {
        /// Half of each side.
        half: DVec3,
    },
    /// Around a part of the axis z.
    Capsule {
        /// Half of that part.
        half_length: f64,
        /// m.
        radius: f64,
    },
    /// All that is below y = 0.
    HalfSpace,
    /// Several, each at its place.
    Compound(Vec<(DVec3, Solid)>),
    /// A closed mesh whose triangles face outwards.
    Mesh(SharedShape),
    /// An open surface, with ground below it: a heightfield, and its triangles to measure with, which are found sooner.
    Ground {
        /// As the physics takes it.
        heights: SharedShape,
        /// The same surface.
        triangles: SharedShape,
    },
}

impl Solid {
    /// A ball of so many triangles around its waist, as a mesh.
    pub fn faceted_ball(radius: f64, facets: u32) -> Self {
        let (vertices, mut triangles) = Ball::new(radius as f32).to_trimesh(facets, facets / 2);
        for triangle in &mut triangles {
            let [a, b, c] = triangle.map(|v| vertices[v as usize]);
            if (b - a).cross(c - a).dot(a + b + c) < 0.0 {
                triangle.swap(1, 2);
            }
        }
        let flags =
            TriMeshFlags::ORIENTED | TriMeshFlags::MERGE_DUPLICATE_VERTICES | TriMeshFlags::DELETE_DEGENERATE_TRIANGLES;
        Self::Mesh(SharedShape::trimesh_with_flags(vertices, triangles, flags).expect("a ball is a valid mesh"))
    }

    /// A square of waves, of this side and with so many cells along it.
    pub fn waves(side: f64, cells: usize, height: impl Fn(f64, f64) -> f64) -> Self {
        let place = |i: usize| (i as f64 / cells as f64 - 0.5) * side;
        let mut heights = Array2::zeros(cells + 1, cells + 1);
        for (row, column) in (0..=cells).flat_map(|row| (0..=cells).map(move |column| (row, column))) {
            heights[(row, column)] = height(place(column), place(row)) as f32;
        }
        let heights = HeightField::new(heights, Vector::new(side as f32, 1.0, side as f32));
        let (vertices, triangles) = heights.to_trimesh();
        let triangles = SharedShape::trimesh(vertices, triangles).expect("a heightfield is a valid mesh");
        Self::Ground { heights: SharedShape::new(heights), triangles }
    }

    /// As the physics takes it.
    pub fn shape(&self) -> SharedShape {
        match self {
            Self::Ball { radius } => SharedShape::ball(*radius as f32),
            Self::Cuboid { half } => {
                let [x, y, z] = half.as_vec3().to_array();
                SharedShape::cuboid(x, y, z)
            }
            Self::Capsule { half_length, radius } => SharedShape::capsule_z(*half_length as f32, *radius as f32),
            Self::HalfSpace => SharedShape::halfspace(Vector::Y),
            Self::Compound(parts) => SharedShape::compound(
                parts.iter().map(|(place, part)| (Pose::from_translation(vector(*place)), part.shape())).collect(),
            ),
            Self::Mesh(shape) | Self::Ground { heights: shape, .. } => shape.clone(),
        }
    }

    /// Distance of a point of its frame from the surface, m: negative inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        match self {
            Self::Ball { radius } => point.length() - radius,
            Self::Cuboid { half } => {
                let beyond = point.abs() - *half;
                beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
            }
            Self::Capsule { half_length, radius } => {
                let axis = DVec3::Z * point.z.clamp(-half_length, *half_length);
                point.distance(axis) - radius
            }
            Self::HalfSpace => point.y,
            Self::Compound(parts) => {
                let distances = parts.iter().map(|(place, part)| part.distance(point - *place));
                distances.fold(f64::INFINITY, f64::min)
            }
            Self::Mesh(shape) => {
                // Outside of all of it, the distance of its box is no more than its own, and soon known.
                let to_box = f64::from(shape.compute_local_aabb().distance_to_local_point(vector(point), true));
                if to_box > FAR {
                    return to_box;
                }
                // Only with the feature asked for, it has an inside.
                let (projection, _) = shape.project_local_point_and_get_feature(vector(point));
                let distance = f64::from((projection.point - vector(point)).length());
                if projection.is_inside { -distance } else { distance }
            }
            Self::Ground { triangles, .. } => {
                let offset = vector(point) - triangles.project_local_point(vector(point), false).point;
                f64::from(offset.length()).copysign(f64::from(offset.y))
            }
        }
    }

    /// Half of the half of its least thickness, m: on what has been as deep as that, the far side has a claim.
    pub fn core(&self) -> f64 {
        match self {
            Self::Ball { radius } | Self::Capsule { radius, .. } => 0.5 * radius,
            Self::Cuboid { half } => 0.5 * half.min_element(),
            Self::HalfSpace => 0.05,
            Self::Compound(parts) => parts.iter().map(|(_, part)| part.core()).fold(f64::INFINITY, f64::min),
            Self::Mesh(shape) | Self::Ground { heights: shape, .. } => {
                0.25 * f64::from(shape.compute_local_aabb().half_extents().min_element())
            }
        }
    }

    /// The corners, if it is a cuboid.
    pub fn corners(&self) -> Vec<DVec3> {
        let Self::Cuboid { half } = self else { return Vec::new() };
        let signs = [-1.0, 1.0];
        let of = |x: f64, y: f64| signs.map(|z| *half * DVec3::new(x, y, z));
        signs.into_iter().flat_map(|x| signs.into_iter().flat_map(move |y| of(x, y))).collect()
    }
}

fn vector(point: DVec3) -> Vector {
    Vector::new(point.x as f32, point.y as f32, point.z as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solids() -> Vec<Solid> {
        let step = Solid::Cuboid { half: DVec3::new(0.5, 0.1, 0.2) };
        vec![
            Solid::Ball { radius: 0.3 },
            Solid::Cuboid { half: DVec3::new(0.3, 0.2, 0.1) },
            Solid::Capsule { half_length: 0.2, radius: 0.1 },
            Solid::HalfSpace,
            Solid::Compound(vec![(DVec3::ZERO, step.clone()), (DVec3::new(0.0, 0.6, 0.6), step)]),
        ]
    }

    #[test]
    fn closed_forms_agree_with_parry() {
        for solid in solids() {
            let shape = solid.shape();
            for i in 0..400 {
                let [a, b, c] = [0.618, 0.414, 0.732].map(|step: f64| (f64::from(i) * step).fract() - 0.5);
                let point = DVec3::new(a, b, c);
                let projection = shape.project_local_point(vector(point), false);
                let off = f64::from((projection.point - vector(point)).length());
                let known = if projection.is_inside { -off } else { off };
                assert!((solid.distance(point) - known).abs() < 1e-5, "{:?} {point}", shape.shape_type());
            }
        }
    }

    #[test]
    fn meshes_have_an_inside() {
        let ball = Solid::faceted_ball(0.3, 48);
        for (radius, known) in [(0.2, -0.1), (0.4, 0.1)] {
            for direction in [DVec3::X, DVec3::Y, DVec3::new(0.5, -0.6, 0.7).normalize()] {
                let distance = ball.distance(radius * direction);
                assert!((distance - known).abs() < 2e-3, "{distance} at {radius} along {direction}");
            }
        }
        let ground = Solid::waves(2.0, 40, |x, z| 0.1 * (3.0 * x).sin() + 0.05 * z);
        for (x, z) in [(0.1, 0.2), (-0.4, 0.3)] {
            let height = 0.1 * (3.0_f64 * x).sin() + 0.05 * z;
            let at = |y| ground.distance(DVec3::new(x, height + y, z));
            assert!((0.015..0.0205).contains(&at(0.02)) && (-0.0205..-0.015).contains(&at(-0.02)), "{x} {z}");
        }
    }

    #[test]
    fn corners_are_on_the_surface() {
        let cuboid = Solid::Cuboid { half: DVec3::new(0.3, 0.2, 0.1) };
        let corners = cuboid.corners();
        assert!(corners.len() == 8 && corners.iter().all(|&corner| cuboid.distance(corner).abs() < 1e-12));
        assert!(corners.iter().sum::<DVec3>().length() < 1e-12);
    }
}
