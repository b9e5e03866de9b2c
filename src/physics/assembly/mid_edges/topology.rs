//! Which edges there are, and which triangles and other edges are beside each.

use super::super::batch::FILLER;
use super::super::hinges;
use crate::physics::energy::mid_edge;
use crate::physics::material::Fabric;
use crate::physics::math::ROWS;
use crate::physics::mesh::{Hinge, RestShape};

/// Edges in the order they are numbered.
pub(super) struct Edges {
    /// The hinge at each; those without come last.
    hinges: Vec<Option<u32>>,
    /// The triangles at each, the first of its hinge first.
    corners: Vec<[Option<Corner>; 2]>,
    /// By triangle and corner: the edge opposite.
    sides: Vec<[Side; 3]>,
    /// Number of edges with hinges or, to fill a pack, without anything.
    pub hinge_count: usize,
}

/// A corner of a triangle: the edge meant is opposite.
#[derive(Clone, Copy, Debug)]
struct Corner {
    triangle: u32,
    vertex: u8,
    /// Whether the angle of the hinge has the sign that the winding of the triangle gives it.
    aligned: bool,
}

/// An edge as one of its triangles sees it: where its φ stands if packs have [`ROWS`] of first and [`ROWS`] of second triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Side(u32);

impl Side {
    fn new(edge: usize, second: bool) -> Self {
        Self((edge / ROWS * 2 * ROWS + edge % ROWS + if second { ROWS } else { 0 }) as u32)
    }

    /// Where φ stands.
    #[inline(always)]
    pub fn place(self) -> usize {
        self.0 as usize
    }

    /// The number of the edge.
    pub fn edge(self) -> usize {
        self.place() / (2 * ROWS) * ROWS + self.place() % ROWS
    }

    /// Whether the triangle is its second.
    pub fn is_second(self) -> bool {
        self.place() % (2 * ROWS) >= ROWS
    }
}

impl Edges {
    /// The edges of a shape. `places` are the hinges in the order that their edges are to be numbered in, with fillers.
    pub fn new(shape: &RestShape, places: &[u32]) -> Self {
        let mut number = vec![0; shape.hinges.len()];
        for (edge, &hinge) in places.iter().enumerate().filter(|(_, hinge)| **hinge != FILLER) {
            number[hinge as usize] = edge;
        }
        let mut hinges: Vec<_> = places.iter().map(|&hinge| (hinge != FILLER).then_some(hinge)).collect();
        let mut corners = vec![[None; 2]; places.len()];
        let mut sides = vec![[None; 3]; shape.triangles.len()];
        // Hinges of one edge follow each other. Where there are several, more than two sheets meet: each of these ends there.
        let mut first = 0;
        for hinges in shape.hinges.chunk_by(|a, b| a.vertices[..2] == b.vertices[..2]) {
            if let [hinge] = hinges {
                let edge = number[first];
                for second in [false, true] {
                    let corner = corner(shape, hinge, second);
                    corners[edge][usize::from(second)] = Some(corner);
                    sides[corner.triangle as usize][usize::from(corner.vertex)] = Some(Side::new(edge, second));
                }
            }
            first += hinges.len();
        }
        for (triangle, sides) in sides.iter_mut().enumerate() {
            for (vertex, side) in sides.iter_mut().enumerate().filter(|(_, side)| side.is_none()) {
                *side = Some(Side::new(corners.len(), false));
                let corner = Corner { triangle: triangle as u32, vertex: vertex as u8, aligned: true };
                corners.push([Some(corner), None]);
                hinges.push(None);
            }
        }
        // One more: the last is no edge, and has no moment.
        let count = (corners.len() + 1).next_multiple_of(ROWS);
        corners.resize(count, [None; 2]);
        hinges.resize(count, None);
        Self {
            hinges,
            corners,
            sides: sides.into_iter().map(|sides| sides.map(Option::unwrap_or_default)).collect(),
            hinge_count: places.len(),
        }
    }

    /// How many there are: a whole number of packs. The last is none.
    pub fn count(&self) -> usize {
        self.corners.len()
    }

    /// The hinge of an edge.
    pub fn hinge(&self, edge: usize) -> Option<u32> {
        self.hinges[edge]
    }

    /// The triangles whose normals the turn of an edge is relative to: none if it has no turn.
    pub fn triangles(&self, edge: usize) -> [Option<u32>; 2] {
        self.corners[edge].map(|corner| corner.map(|corner| corner.triangle))
    }

    /// The two other edges of the first triangle of an edge, then of the second; itself where there is no triangle.
    pub fn others(&self, edge: usize) -> [Side; 4] {
        let of = |corner: Option<Corner>| {
            corner.map_or([Side::new(edge, false); 2], |Corner { triangle, vertex, .. }| {
                [1, 2].map(|next| self.sides[triangle as usize][(usize::from(vertex) + next) % 3])
            })
        };
        let [[a, b], [c, d]] = self.corners[edge].map(of);
        [a, b, c, d]
    }

    /// Gives each edge its row of P, in the sign of its hinge, of its first triangle or its second. Where there is no triangle,
    /// nothing is given.
    pub fn for_rows(&self, shape: &RestShape, fabric: &Fabric, mut give: impl FnMut(usize, bool, [f64; 3])) {
        let rigidity = fabric.flexural_rigidity();
        for (triangle, sides) in shape.triangles.iter().zip(&self.sides) {
            let sign = sides.map(|side| self.sign(side));
            let p = mid_edge::stiffness(&rigidity, triangle.dm_inverse, triangle.area);
            for (vertex, side) in sides.iter().enumerate() {
                let row = [vertex, (vertex + 1) % 3, (vertex + 2) % 3].map(|j| sign[vertex] * sign[j] * p[vertex][j]);
                give(side.edge(), side.is_second(), row);
            }
        }
        for (edge, (corners, hinge)) in self.corners.iter().zip(&self.hinges).enumerate() {
            // More than two sheets meet: they bend against each other as hinges, of moment 2k Θ.
            if let ([None, None], &Some(hinge)) = (corners, hinge) {
                let rest = hinges::rest(&shape.hinges[hinge as usize], fabric);
                let own = [4.0 * rest.stiffness, 0.0, 0.0];
                give(edge, false, own);
                give(edge, true, own);
            }
        }
    }

    fn sign(&self, side: Side) -> f64 {
        let corner = self.corners[side.edge()][usize::from(side.is_second())];
        if corner.is_none_or(|corner| corner.aligned) { 1.0 } else { -1.0 }
    }
}

/// The corner opposite a hinge in its first or second triangle.
fn corner(shape: &RestShape, hinge: &Hinge, second: bool) -> Corner {
    let triangle = hinge.triangles[usize::from(second)];
    let vertices = shape.triangles[triangle as usize].vertices;
    let opposite = hinge.vertices[2 + usize::from(second)];
    let vertex =
        vertices.iter().position(|&v| v == opposite).expect("a hinge is made of the vertices of its triangles");
    // Seen from the first triangle, the edge runs the way the triangle is wound; from the second, the other way.
    let along = vertices[(vertex + 1) % 3] == hinge.vertices[0];
    Corner { triangle, vertex: vertex as u8, aligned: along != second }
}
