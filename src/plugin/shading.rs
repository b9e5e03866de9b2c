//! Normals and tangents of the deformed mesh.
//!
//! Our own, because Bevy's `compute_smooth_normals` drops the corners of edges under about 2 cm, which is ordinary cloth.
//! Vertices that are one in the simulation share a normal where their rest normals are alike: seams of texture
//! coordinates stay smooth, hard edges and the two sides of a double mesh stay apart.

use bevy::prelude::*;

use super::mesh_io::SourceMesh;
use super::winding;

/// Cosine of 30°: rest normals (and tangents) nearer than this are smoothed together.
const COS_SMOOTH: f32 = 0.866;

/// What is fixed about the shading of a cloth.
pub(super) struct Shading {
    /// Unit normals at rest.
    pub rest_normals: Vec<Vec3>,
    winding: Winding,
    normals: Groups,
    /// −1 for the groups of `normals` whose authored normals point against the winding of their triangles.
    signs: Vec<f32>,
    tangents: Option<TangentShading>,
}

struct TangentShading {
    uvs: Vec<[f32; 2]>,
    rest: Vec<Vec4>,
    groups: Groups,
}

/// Vertices that share a vector.
struct Groups {
    of: Vec<u32>,
    count: usize,
}

impl Groups {
    /// Groups vertices of the same simulated vertex that are alike. Vertices that are not simulated stay alone.
    fn new(simulated: &[Option<u32>], alike: impl Fn(usize, usize) -> bool) -> Self {
        let mut firsts: Vec<Vec<usize>> = vec![Vec::new(); simulated.len()];
        let mut of = Vec::with_capacity(simulated.len());
        let mut count = 0;
        for (vertex, simulated) in simulated.iter().enumerate() {
            let known = simulated.and_then(|s| firsts[s as usize].iter().find(|&&first| alike(first, vertex)));
            if let Some(&first) = known {
                of.push(of[first]);
                continue;
            }
            of.push(count);
            count += 1;
            if let Some(simulated) = simulated {
                firsts[*simulated as usize].push(vertex);
            }
        }
        Self { of, count: count as usize }
    }

    /// Sum over the corners of the triangles.
    fn sum(&self, triangles: &[[u32; 3]], of_triangle: impl Fn(usize, [usize; 3]) -> Vec3) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; self.count];
        for (index, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|v| v as usize);
            let vector = of_triangle(index, corners);
            for corner in corners {
                sums[self.of[corner] as usize] += vector;
            }
        }
        sums
    }
}

/// Signs of triangles, if any is wound against the others: two sides of a mesh on the same vertices would cancel out.
struct Winding(Option<Vec<f32>>);

impl Winding {
    /// Twice the area of a triangle along its normal.
    fn area_vector(&self, positions: &[Vec3], index: usize, [a, b, c]: [usize; 3]) -> Vec3 {
        let vector = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
        self.0.as_ref().map_or(vector, |signs| vector * signs[index])
    }
}

impl Shading {
    /// From the rest state. Every index of `mesh` must be in range.
    pub fn new(mesh: &SourceMesh, simulated: &[Option<u32>]) -> Self {
        let alone = Groups { of: (0..simulated.len() as u32).collect(), count: simulated.len() };
        let winding = Winding(winding::signs(&mesh.triangles));
        let area_vector = |index, corners| winding.area_vector(&mesh.positions, index, corners);
        let computed = alone.sum(&mesh.triangles, area_vector);
        let rest_normals: Vec<Vec3> = computed
            .into_iter()
            .enumerate()
            .map(|(vertex, computed)| {
                let authored = mesh.normals.as_ref().and_then(|normals| normals[vertex].try_normalize());
                authored.or(computed.try_normalize()).unwrap_or(Vec3::Y)
            })
            .collect();
        let smooth = |a: usize, b: usize| rest_normals[a].dot(rest_normals[b]) > COS_SMOOTH;
        let normals = Groups::new(simulated, smooth);
        let mut signs = vec![1.0; normals.count];
        let sums = normals.sum(&mesh.triangles, area_vector);
        for (&group, rest) in normals.of.iter().zip(&rest_normals) {
            if sums[group as usize].dot(*rest) < 0.0 {
                signs[group as usize] = -1.0;
            }
        }
        let tangents = mesh.uvs.clone().zip(mesh.tangents.clone()).filter(|(uvs, _)| uvs.len() == simulated.len());
        let tangents = tangents.map(|(uvs, rest)| {
            let alike = |a: usize, b: usize| {
                let (t, u) = (rest[a], rest[b]);
                smooth(a, b) && t.w == u.w && t.truncate().dot(u.truncate()) > COS_SMOOTH
            };
            TangentShading { groups: Groups::new(simulated, alike), uvs, rest }
        });
        Self { rest_normals, winding, normals, signs, tangents }
    }

    /// Area-weighted unit normals. Where the cloth is folded to nothing, those of the rest state.
    pub fn normals(&self, triangles: &[[u32; 3]], positions: &[Vec3]) -> Vec<[f32; 3]> {
        let sums = self.normals.sum(triangles, |index, corners| self.winding.area_vector(positions, index, corners));
        let normals = self.normals.of.iter().zip(&self.rest_normals);
        let normal = |group: usize| (sums[group] * self.signs[group]).try_normalize();
        normals.map(|(&group, rest)| normal(group as usize).unwrap_or(*rest).into()).collect()
    }

    /// Unit tangents along growing u, orthogonal to the normals, with the handedness of the rest state; empty if the
    /// mesh has none.
    pub fn tangents(&self, triangles: &[[u32; 3]], positions: &[Vec3], normals: &[[f32; 3]]) -> Vec<[f32; 4]> {
        let Some(shading) = &self.tangents else { return Vec::new() };
        let sums = shading.groups.sum(triangles, |_, corners| along_u(positions, &shading.uvs, corners));
        (0..positions.len())
            .map(|vertex| {
                let (normal, rest) = (Vec3::from(normals[vertex]), shading.rest[vertex]);
                let along = |tangent: Vec3| tangent.reject_from_normalized(normal).try_normalize();
                let tangent = along(sums[shading.groups.of[vertex] as usize])
                    .or(along(rest.truncate()))
                    .unwrap_or_else(|| normal.any_orthonormal_vector());
                tangent.extend(rest.w).into()
            })
            .collect()
    }
}

/// ∂p/∂u of a triangle times its area in u and v, so that thin triangles count little.
fn along_u(positions: &[Vec3], uvs: &[[f32; 2]], [a, b, c]: [usize; 3]) -> Vec3 {
    let [p, q] = [positions[b] - positions[a], positions[c] - positions[a]];
    let [ua, ub, uc] = [a, b, c].map(|v| Vec2::from(uvs[v]));
    let [s, t] = [ub - ua, uc - ua];
    (p * t.y - q * s.y) * s.perp_dot(t).signum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares of 1 mm in the plane z = 0 that meet along a seam at x = 0: vertices 2, 3 and 4, 5 are split there.
    fn seam(normal_right: Vec3) -> SourceMesh {
        let positions = [(-1, 0), (-1, 1), (0, 0), (0, 1), (0, 0), (0, 1), (1, 0), (1, 1)];
        let positions: Vec<Vec3> = positions.map(|(x, y)| Vec3::new(x as f32, y as f32, 0.0) * 1e-3).into();
        SourceMesh {
            uvs: Some(positions.iter().map(|p| [p.x * 1e3, -p.y * 1e3]).collect()),
            normals: Some([[Vec3::Z; 4], [normal_right; 4]].concat()),
            tangents: Some(vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 8]),
            triangles: vec![[0, 2, 1], [2, 3, 1], [4, 6, 5], [6, 7, 5]],
            positions,
        }
    }

    const SEAM: [Option<u32>; 8] = [Some(0), Some(1), Some(2), Some(3), Some(2), Some(3), Some(6), Some(7)];

    /// The right half bent down by 90° about the seam.
    fn bent(mesh: &SourceMesh) -> Vec<Vec3> {
        mesh.positions.iter().map(|p| if p.x > 0.0 { Vec3::new(0.0, p.y, -p.x) } else { *p }).collect()
    }

    #[test]
    fn seams_are_smooth_and_hard_edges_hard() {
        let half = Vec3::new(1.0, 0.0, 1.0).normalize();
        for (normal_right, expected) in [(Vec3::Z, [half, half]), (Vec3::X, [Vec3::Z, Vec3::X])] {
            let mesh = seam(normal_right);
            let normals = Shading::new(&mesh, &SEAM).normals(&mesh.triangles, &bent(&mesh));
            let [left, right] = [2, 4].map(|v: usize| Vec3::from(normals[v]));
            // Vertex 2 is in two triangles on the left, vertex 4 in one on the right: equal weights only when hard.
            if normal_right == Vec3::Z {
                assert_eq!(left, right);
                assert!(left.x > 0.3 && left.z > 0.3, "{left}");
            } else {
                assert!(left.abs_diff_eq(expected[0], 1e-6) && right.abs_diff_eq(expected[1], 1e-6), "{left} {right}");
            }
        }
    }

    #[test]
    fn tangents_follow_u_and_keep_their_handedness() {
        let mesh = seam(Vec3::X);
        let shading = Shading::new(&mesh, &SEAM);
        let positions = bent(&mesh);
        let normals = shading.normals(&mesh.triangles, &positions);
        let tangents = shading.tangents(&mesh.triangles, &positions, &normals);
        assert!(Vec4::from(tangents[0]).abs_diff_eq(Vec4::new(1.0, 0.0, 0.0, -1.0), 1e-6), "{:?}", tangents[0]);
        assert!(Vec4::from(tangents[6]).abs_diff_eq(Vec4::new(0.0, 0.0, -1.0, -1.0), 1e-6), "{:?}", tangents[6]);
    }

    #[test]
    fn a_collapsed_cloth_keeps_its_rest_normals() {
        let mesh = seam(Vec3::Z);
        let shading = Shading::new(&mesh, &SEAM);
        let point = vec![Vec3::ONE; 8];
        let normals = shading.normals(&mesh.triangles, &point);
        assert_eq!(normals, [[0.0, 0.0, 1.0]; 8]);
        let tangents = shading.tangents(&mesh.triangles, &point, &normals);
        assert_eq!(tangents, [[1.0, 0.0, 0.0, -1.0]; 8]);
    }
}
