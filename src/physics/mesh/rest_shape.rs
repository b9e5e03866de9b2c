//! The undeformed cloth: what its elements are, free of any material.

use bevy::math::{DVec2, DVec3};
use bevy::reflect::Reflect;
use bevy::reflect::std_traits::ReflectDefault;
use thiserror::Error;

use super::topology::{Edges, HingeTopology, clean_triangles, has_area};
use super::warp_weft;
use super::weld::weld;
use crate::physics::energy::hinge::dihedral_angle;
use crate::physics::energy::membrane::Gram;

/// A triangle mesh as it comes from an asset: vertices may be split along seams.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceMesh<'a> {
    /// Rest positions, m.
    pub positions: &'a [DVec3],
    /// Vertex indices of each triangle.
    pub triangles: &'a [[u32; 3]],
    /// Texture coordinates, used for the warp direction only.
    pub uvs: Option<&'a [[f32; 2]]>,
}

/// How a [`SurfaceMesh`] becomes a [`RestShape`].
#[derive(Clone, Debug, PartialEq, Reflect)]
pub struct RestShapeOptions {
    /// Vertices nearer than this are one, m. `None`: 1e-5 of the diagonal of the bounding box of all vertices that triangles
    /// use.
    pub weld_distance: Option<f64>,
    /// Take the warp direction from the texture coordinates where they are sane.
    pub warp_from_uvs: bool,
    /// Angle from the direction of growing u (or its stand-in) to the warp, rad, counter-clockwise about the normal.
    pub warp_angle: f64,
    /// The rest shape is flat, whatever the mesh: folds modelled into it try to open.
    pub rest_flat: bool,
    /// How it bends.
    pub bending: BendingModel,
}

/// How a cloth bends: what the edges between its triangles make of the fabric's flexural rigidity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
pub enum BendingModel {
    /// Mid-edge normals ([`energy::mid_edge`](crate::physics::energy::mid_edge)): the rigidity of the fabric in every direction
    /// on every mesh.
    #[default]
    MidEdge,
    /// Hinges ([`energy::hinge`](crate::physics::energy::hinge)): cheaper, and up to three times as stiff as the fabric,
    /// depending on the mesh and the direction.
    Hinge,
    /// Not at all, whatever the fabric: folds are as sharp as the mesh can show. The cheapest.
    None,
}

impl Default for RestShapeOptions {
    fn default() -> Self {
        Self {
            weld_distance: None,
            warp_from_uvs: true,
            warp_angle: 0.0,
            rest_flat: false,
            bending: BendingModel::default(),
        }
    }
}

/// A mesh that cannot be cloth. Indices are those of the mesh given.
#[derive(Clone, Debug, Error, PartialEq, Reflect)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangles, or none left after the degenerate ones.
    #[error("the mesh has no triangle with an area ({given} given)")]
    Empty {
        /// Number of triangles given.
        given: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are only {count} vertices")]
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A position is NaN or infinite.
    #[error("the position of vertex {vertex} is not finite")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// Another mesh than the rest shape was made of, see [`RestShape::remeasure`].
    #[error("the mesh has other triangles than the rest shape was made of, or is welded to other vertices")]
    OtherMesh,
    /// Fewer texture coordinates than positions, or more.
    #[error("there are {uvs} texture coordinates for {positions} positions")]
    UvCount {
        /// Number of texture coordinates.
        uvs: usize,
        /// Number of positions.
        positions: usize,
    },
}

/// A triangle of the rest shape.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Its (welded) vertices.
    pub vertices: [u32; 3],
    /// Rows of the material edge matrix D_m⁻¹ (1/m): `F = [x1−x0, x2−x0] D_m⁻¹`, columns along warp and weft.
    pub dm_inverse: [[f64; 2]; 2],
    /// Gram matrix of the rest edges, m².
    pub rest_gram: Gram<f64>,
    /// Rest area, m².
    pub area: f64,
    /// Index of the triangle in the mesh it came from.
    pub source: u32,
}

/// Two triangles that share an edge, and so bend against each other.
#[derive(Clone, Copy, Debug)]
pub struct Hinge {
    /// The ends of the edge, then the vertex opposite in either triangle.
    pub vertices: [u32; 4],
    /// Rest length of the edge ‖ē‖, m.
    pub length: f64,
    /// h̄ = ⅓(h̄1 + h̄2): a third of the sum of the rest heights of the opposite vertices, m.
    pub height: f64,
    /// The two triangles.
    pub triangles: [u32; 2],
    /// Twice the rest area of either triangle, m².
    pub double_areas: [f64; 2],
    /// Rest angle θ̄, rad; 0 is flat.
    pub rest_angle: f64,
    /// Angle from the warp to the direction that this hinge bends (across the edge), rad.
    pub direction: f64,
}

/// The undeformed cloth.
#[derive(Clone, Debug)]
pub struct RestShape {
    /// Rest position of each simulated vertex, m.
    pub positions: Vec<DVec3>,
    /// Simulated vertex of each vertex of the mesh; `None` where no triangle uses it.
    pub simulated: Vec<Option<u32>>,
    /// The membrane elements.
    pub triangles: Vec<Triangle>,
    /// The pairs of triangles that bend against each other.
    pub hinges: Vec<Hinge>,
    /// Edges with a triangle on one side only.
    pub boundary: Vec<[u32; 2]>,
    /// All edges.
    pub edges: Vec<[u32; 2]>,
    /// Edges with three or more triangles: they get a hinge between each pair.
    pub non_manifold: Vec<[u32; 2]>,
    /// Triangles of the mesh that are no elements, having no area once welded, or the same three vertices as another.
    pub dropped: Vec<u32>,
    /// A third of the rest area of the triangles around each vertex, m²: its share of the mass.
    pub vertex_areas: Vec<f64>,
    /// How it bends.
    pub bending: BendingModel,
}

impl RestShape {
    /// Builds the rest shape of a mesh.
    ///
    /// Triangles without area and duplicates are left out (and listed in [`RestShape::dropped`]), vertices without
    /// triangle are not simulated, edges of three or more triangles bend between each pair.
    ///
    /// # Errors
    /// See [`MeshError`].
    pub fn new(mesh: &SurfaceMesh, options: &RestShapeOptions) -> Result<Self, MeshError> {
        check(mesh)?;
        let welded = weld(mesh, options.weld_distance);
        let (triangles, dropped) = clean_triangles(mesh.triangles, mesh.positions, &welded);
        if triangles.is_empty() {
            return Err(MeshError::Empty { given: mesh.triangles.len() });
        }

        // Number the welded vertices that triangles use, in the order of the mesh.
        let mut simulated = vec![None; mesh.positions.len()];
        let mut positions = Vec::with_capacity(mesh.positions.len());
        for triangle in &triangles {
            for &representative in &triangle.welded {
                simulated[representative as usize] = Some(0);
            }
        }
        for vertex in 0..mesh.positions.len() {
            let representative = welded[vertex] as usize;
            if representative == vertex && simulated[vertex].is_some() {
                simulated[vertex] = Some(positions.len() as u32);
                positions.push(mesh.positions[vertex]);
            } else {
                simulated[vertex] = simulated[representative];
            }
        }

        let elements: Vec<_> = triangles
            .iter()
            .map(|triangle| Triangle {
                vertices: triangle.welded.map(|w| simulated[w as usize].expect("numbered above")),
                dm_inverse: [[0.0; 2]; 2],
                rest_gram: [0.0; 3],
                area: 0.0,
                source: triangle.source,
            })
            .collect();
        let edges = Edges::new(elements.iter().map(|t| t.vertices));
        let hinge = |hinge: HingeTopology| Hinge {
            vertices: hinge.vertices,
            triangles: hinge.triangles.map(|triangle| triangle as u32),
            length: 0.0,
            height: 0.0,
            double_areas: [0.0; 2],
            rest_angle: 0.0,
            direction: 0.0,
        };
        let mut shape = Self {
            boundary: edges.boundary(),
            non_manifold: edges.non_manifold(),
            edges: edges.all(),
            hinges: edges.hinges().map(hinge).collect(),
            vertex_areas: vec![0.0; positions.len()],
            positions,
            simulated,
            triangles: elements,
            dropped,
            bending: options.bending,
        };
        shape.measure(mesh, options);
        Ok(shape)
    }

    /// Measures the same mesh again, with its vertices elsewhere: stretched, squashed or mirrored. What is made of which vertex
    /// stays; all lengths, areas, angles and directions are new. Takes a pass over the vertices, triangles and hinges.
    ///
    /// # Errors
    /// If the mesh is none of the same triangles, [`MeshError::OtherMesh`]; likewise where [`RestShapeOptions::weld_distance`]
    /// now makes other vertices one, the options bend another way, or a triangle has lost its area. For what else, see
    /// [`RestShape::new`]. The shape then stays as it was.
    pub fn remeasure(&mut self, mesh: &SurfaceMesh, options: &RestShapeOptions) -> Result<(), MeshError> {
        let counts = [mesh.positions.len(), mesh.triangles.len()];
        let own_counts = [self.simulated.len(), self.triangles.len() + self.dropped.len()];
        if counts != own_counts || options.bending != self.bending {
            return Err(MeshError::OtherMesh);
        }
        check(mesh)?;
        let same = |triangle: &Triangle| {
            let corners = mesh.triangles[triangle.source as usize];
            let vertices = corners.map(|v| self.simulated[v as usize]) == triangle.vertices.map(Some);
            vertices && has_area(corners.map(|v| mesh.positions[v as usize]))
        };
        // What is relative to the extent of the mesh, or asks for the same place, stays as it is.
        let stays_welded = options.weld_distance.is_none_or(|distance| distance == 0.0);
        if !self.triangles.iter().all(same) || !(stays_welded || self.is_welded_in(mesh, options)) {
            return Err(MeshError::OtherMesh);
        }
        // The first vertex of the mesh that it is made of is where a simulated one is.
        for (simulated, &position) in self.simulated.iter().zip(mesh.positions).rev() {
            if let Some(simulated) = simulated {
                self.positions[*simulated as usize] = position;
            }
        }
        self.measure(mesh, options);
        Ok(())
    }

    /// Whether the mesh as it is now would be welded to the same vertices.
    fn is_welded_in(&self, mesh: &SurfaceMesh, options: &RestShapeOptions) -> bool {
        let welded = weld(mesh, options.weld_distance);
        let mut first = vec![None; self.vertex_count()];
        self.simulated.iter().zip(welded).all(|(simulated, welded)| {
            simulated.is_none_or(|vertex| *first[vertex as usize].get_or_insert(welded) == welded)
                && self.simulated[welded as usize] == *simulated
        })
    }

    /// Finds all that depends on where the vertices are.
    fn measure(&mut self, mesh: &SurfaceMesh, options: &RestShapeOptions) {
        let Self { positions, triangles, hinges, vertex_areas, .. } = self;
        vertex_areas.fill(0.0);
        let turn = DVec2::new(options.warp_angle.cos(), options.warp_angle.sin());
        let mut frames = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            let corners = triangle.vertices.map(|v| positions[v as usize]);
            let uvs = mesh.uvs.filter(|_| options.warp_from_uvs);
            let uvs = uvs.map(|uvs| mesh.triangles[triangle.source as usize].map(|v| uvs[v as usize]));
            let frame = warp_weft::frame(corners, uvs, turn);
            let [d1, d2] = [corners[1] - corners[0], corners[2] - corners[0]];
            let [e1, e2] = [d1, d2].map(|e| frame.to_material(e));
            let area = 0.5 * e1.perp_dot(e2);
            for v in triangle.vertices {
                vertex_areas[v as usize] += area / 3.0;
            }
            triangle.dm_inverse = inverse_of_columns(e1, e2);
            triangle.rest_gram = [d1.length_squared(), d2.length_squared(), d1.dot(d2)];
            triangle.area = area;
            frames.push(frame);
        }
        for hinge in hinges {
            hinge.measure(positions, &frames[hinge.triangles[0] as usize], options.rest_flat);
        }
    }

    /// The hinges that resist bending.
    pub fn bending_hinges(&self) -> &[Hinge] {
        match self.bending {
            BendingModel::MidEdge | BendingModel::Hinge => &self.hinges,
            BendingModel::None => &[],
        }
    }

    /// Number of simulated vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }
}

fn check(mesh: &SurfaceMesh) -> Result<(), MeshError> {
    let count = mesh.positions.len();
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NotFinite { vertex });
    }
    if let Some(uvs) = mesh.uvs.filter(|uvs| uvs.len() != count) {
        return Err(MeshError::UvCount { uvs: uvs.len(), positions: count });
    }
    for (triangle, vertices) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = vertices.iter().find(|&&v| v as usize >= count) {
            return Err(MeshError::IndexOutOfRange { triangle, vertex, count });
        }
    }
    Ok(())
}

/// Inverse of the 2×2 matrix with these columns.
fn inverse_of_columns(a: DVec2, b: DVec2) -> [[f64; 2]; 2] {
    let scale = 1.0 / a.perp_dot(b);
    [[b.y * scale, -b.x * scale], [-a.y * scale, a.x * scale]]
}

impl Hinge {
    fn measure(&mut self, positions: &[DVec3], warp: &warp_weft::Frame, flat: bool) {
        let x = self.vertices.map(|v| positions[v as usize]);
        let edge = x[1] - x[0];
        self.length = edge.length();
        self.double_areas = [edge.cross(x[2] - x[0]).length(), edge.cross(x[3] - x[0]).length()];
        self.height = (self.double_areas[0] + self.double_areas[1]) / (3.0 * self.length);
        self.rest_angle = if flat { 0.0 } else { dihedral_angle(x) };
        let along = warp.to_material(edge);
        self.direction = along.y.atan2(along.x) + core::f64::consts::FRAC_PI_2;
    }
}
