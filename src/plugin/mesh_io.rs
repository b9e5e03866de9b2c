//! Reading and copying Bevy meshes.

use bevy::mesh::{
    Indices, MeshAccessError, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues, VertexFormat,
};
use bevy::prelude::*;

use super::error::ClothError;
use super::state::usable;
use crate::physics::MeshError;

/// What binds a mesh to bones.
pub(super) const JOINTS: [MeshVertexAttribute; 2] = [Mesh::ATTRIBUTE_JOINT_INDEX, Mesh::ATTRIBUTE_JOINT_WEIGHT];

/// What cloth takes from mesh assets, in the space of its entity.
pub(super) struct SourceMesh {
    pub positions: Vec<Vec3>,
    /// A triangle strip is unrolled.
    pub triangles: Vec<[u32; 3]>,
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Unit normals as authored; `None` without (or with too few).
    pub normals: Option<Vec<Vec3>>,
    /// Tangents as authored, handedness in w.
    pub tangents: Option<Vec<Vec4>>,
}

impl SourceMesh {
    /// Reads a mesh. Indices may still be out of range and positions not finite: the rest shape checks them.
    pub fn read(mesh: &Mesh) -> Result<Self, ClothError> {
        let positions: Vec<Vec3> = match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) {
            Ok(VertexAttributeValues::Float32x3(positions)) => positions.iter().map(|&p| p.into()).collect(),
            Ok(other) => return Err(ClothError::Positions { found: format!("{:?}", VertexFormat::from(other)) }),
            Err(MeshAccessError::ExtractedToRenderWorld) => return Err(ClothError::MeshExtracted),
            Err(_) => return Err(ClothError::Positions { found: "missing".into() }),
        };
        let count = positions.len();
        let indices = mesh.try_indices_option().map_err(|_| ClothError::MeshExtracted)?;
        Ok(Self {
            triangles: triangles(mesh.primitive_topology(), indices, count)?,
            uvs: match mesh.try_attribute(Mesh::ATTRIBUTE_UV_0) {
                Ok(VertexAttributeValues::Float32x2(uvs)) => Some(uvs.clone()),
                _ => None,
            },
            normals: match mesh.try_attribute(Mesh::ATTRIBUTE_NORMAL) {
                Ok(VertexAttributeValues::Float32x3(normals)) if normals.len() == count => {
                    Some(normals.iter().map(|&n| Vec3::from(n).normalize_or_zero()).collect())
                }
                _ => None,
            },
            tangents: match mesh.try_attribute(Mesh::ATTRIBUTE_TANGENT) {
                Ok(VertexAttributeValues::Float32x4(tangents)) if tangents.len() == count => {
                    Some(tangents.iter().map(|&t| t.into()).collect())
                }
                _ => None,
            },
            positions,
        })
    }

    /// Reads the meshes of a cloth as one, the vertices of one after those of the other. Each has its place in the space of the cloth.
    pub fn read_parts<'a>(parts: impl IntoIterator<Item = (&'a Mesh, Transform)>) -> Result<Self, ClothError> {
        let mut whole: Option<Self> = None;
        for (mesh, place) in parts {
            let part = Self::read(mesh)?.placed(place)?;
            whole = Some(match whole {
                Some(whole) => whole.and(part)?,
                None => part,
            });
        }
        whole.ok_or(ClothError::NoMesh)
    }

    fn placed(mut self, place: Transform) -> Result<Self, ClothError> {
        if place == Transform::IDENTITY {
            return Ok(self);
        }
        let outward = usable(&place.into())?;
        let covariant = outward.matrix3.inverse().transpose();
        for position in &mut self.positions {
            *position = outward.transform_point3(position.as_dvec3()).as_vec3();
        }
        for normal in self.normals.iter_mut().flatten() {
            *normal = (covariant * normal.as_dvec3()).normalize_or_zero().as_vec3();
        }
        for tangent in self.tangents.iter_mut().flatten() {
            let along = outward.transform_vector3(tangent.truncate().as_dvec3()).normalize_or_zero();
            *tangent = along.as_vec3().extend(tangent.w);
        }
        if outward.matrix3.determinant() < 0.0 {
            // A mirror turns triangles over.
            self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Ok(self)
    }

    /// Both as one mesh.
    fn and(mut self, other: Self) -> Result<Self, ClothError> {
        self.check_indices()?;
        other.check_indices()?;
        let counts = [self.positions.len(), other.positions.len()];
        let first = counts[0] as u32;
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
        let whole = |uvs: Option<Vec<[f32; 2]>>, count| uvs.filter(|uvs| uvs.len() == count);
        self.uvs = joined([whole(self.uvs, counts[0]), whole(other.uvs, counts[1])], counts, [0.0; 2]);
        self.normals = joined([self.normals, other.normals], counts, Vec3::ZERO);
        self.tangents = joined([self.tangents, other.tangents], counts, Vec4::ZERO);
        self.positions.extend(other.positions);
        Ok(self)
    }

    /// In a whole, an index that is out of range would name a vertex of another part.
    fn check_indices(&self) -> Result<(), MeshError> {
        let count = self.positions.len();
        let out_of_range = |(triangle, vertices): (usize, &[u32; 3])| {
            let &vertex = vertices.iter().find(|&&vertex| vertex as usize >= count)?;
            Some(MeshError::IndexOutOfRange { triangle, vertex, count })
        };
        self.triangles.iter().enumerate().find_map(out_of_range).map_or(Ok(()), Err)
    }

    /// Whether both are the same cloth: the same positions, triangles and texture coordinates.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        // Not as numbers: what is NaN in both is the same.
        let bits =
            |uvs: &'_ Option<Vec<[f32; 2]>>| uvs.iter().flatten().map(|uv| uv.map(f32::to_bits)).collect::<Vec<_>>();
        self.positions == other.positions && self.triangles == other.triangles && bits(&self.uvs) == bits(&other.uvs)
    }
}

/// Values for each vertex of two meshes, if either has them.
fn joined<T: Copy>(values: [Option<Vec<T>>; 2], counts: [usize; 2], missing: T) -> Option<Vec<T>> {
    if values.iter().all(Option::is_none) {
        return None;
    }
    let of_each = values.into_iter().zip(counts);
    Some(of_each.flat_map(|(values, count)| values.unwrap_or_else(|| vec![missing; count])).collect())
}

fn triangles(
    topology: PrimitiveTopology,
    indices: Option<&Indices>,
    count: usize,
) -> Result<Vec<[u32; 3]>, ClothError> {
    let (indices, restart): (Vec<u32>, u32) = match indices {
        Some(Indices::U16(indices)) => (indices.iter().map(|&i| i.into()).collect(), u16::MAX.into()),
        Some(Indices::U32(indices)) => (indices.clone(), u32::MAX),
        None => ((0..count as u32).collect(), u32::MAX),
    };
    match topology {
        PrimitiveTopology::TriangleList => Ok(indices.as_chunks().0.to_vec()),
        PrimitiveTopology::TriangleStrip => Ok(indices
            .split(|&index| index == restart)
            .flat_map(|strip| {
                // Every other triangle of a strip runs the other way round.
                let windows = strip.windows(3).enumerate();
                windows.map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] })
            })
            .collect()),
        other => Err(ClothError::Topology { topology: format!("{other:?}") }),
    }
}

/// The copy that a cloth deforms: all that the user put in, with the normals given, and without what would deform it a
/// second time (joints, morph targets).
pub(super) fn own_copy(mesh: &Mesh, normals: &[[f32; 3]]) -> Mesh {
    let mut copy = Mesh::new(mesh.primitive_topology(), default());
    copy.enable_raytracing = mesh.enable_raytracing;
    for (attribute, values) in mesh.try_attributes().into_iter().flatten() {
        if !JOINTS.iter().any(|joints| joints.id == attribute.id) {
            copy.insert_attribute(*attribute, values.clone());
        }
    }
    copy.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals.to_vec());
    if let Ok(indices) = mesh.try_indices() {
        copy.insert_indices(indices.clone());
    }
    copy
}

/// Overwrites positions, normals and tangents, in place.
pub(super) fn write(mesh: &mut Mesh, positions: &[[f32; 3]], normals: &[[f32; 3]], tangents: &[[f32; 4]]) {
    if let Ok(VertexAttributeValues::Float32x3(values)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION) {
        values.clear();
        values.extend_from_slice(positions);
    }
    if let Ok(VertexAttributeValues::Float32x3(values)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_NORMAL) {
        values.clear();
        values.extend_from_slice(normals);
    }
    if !tangents.is_empty()
        && let Ok(VertexAttributeValues::Float32x4(values)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_TANGENT)
    {
        values.clear();
        values.extend_from_slice(tangents);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_keep_their_winding_and_end_at_a_restart() {
        let strip = Indices::U16(vec![0, 1, 2, 3, u16::MAX, 4, 5, 6]);
        let unrolled = triangles(PrimitiveTopology::TriangleStrip, Some(&strip), 7).unwrap();
        assert_eq!(unrolled, [[0, 1, 2], [2, 1, 3], [4, 5, 6]]);
        let list = triangles(PrimitiveTopology::TriangleList, None, 7).unwrap();
        assert_eq!(list, [[0, 1, 2], [3, 4, 5]]);
    }
}
