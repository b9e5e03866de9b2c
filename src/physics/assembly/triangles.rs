//! The membrane elements of a cloth.

use bevy::math::DVec3;

use super::BlockPattern;
use super::batch::{Batches, Elements, Output, PartBatches, pack};
use super::implicit_step::{Linearisation, Projection};
use crate::physics::energy::membrane::{self, Gram, Orthotropic, Rest, Strain};
use crate::physics::material::Fabric;
use crate::physics::math::{Flat, Padded, Real, Scalar, V3};
use crate::physics::mesh::{RestShape, Triangle};

fn constants<L: Real>(fabric: &Fabric) -> Orthotropic<L> {
    Orthotropic {
        k0: L::splat(fabric.warp_stiffness.into()),
        k1: L::splat(fabric.coupling.into()),
        k2: L::splat(fabric.weft_stiffness.into()),
        k3: L::splat(fabric.shear_stiffness.into()),
    }
}

/// All triangles, in batches, the vertices of each in ascending order.
pub(super) struct Triangles<L> {
    batches: Batches<3, 3>,
    rest: Vec<Rest<L>>,
    /// Gram matrices of the rest edges, by element: in f64, see [`membrane`].
    rest_grams: Vec<Gram<f64>>,
    constants: Orthotropic<L>,
}

impl<L: Real> Triangles<L> {
    pub fn new(shape: &RestShape, fabric: &Fabric, inner: &[u32], rank: &[u32], pattern: &BlockPattern) -> Self {
        let sorted: Vec<Triangle> = shape.triangles.iter().map(|t| ascending(t, inner)).collect();
        let vertices: Vec<_> = sorted.iter().map(|t| t.vertices).collect();
        let (batches, sources) = Batches::new(&vertices, L::LANES, pattern, rank);
        let column = |r: usize, c: usize| pack::<L>(&sources, 0.0, |i| sorted[i].dm_inverse[r][c]);
        let dm = [[column(0, 0), column(0, 1)], [column(1, 0), column(1, 1)]];
        // A filler has no area, so no energy, force or Hessian.
        let areas = pack::<L>(&sources, 0.0, |i| sorted[i].area);
        let rest = areas.iter().enumerate().map(|(batch, &area)| Rest {
            dm_inverse: core::array::from_fn(|r| core::array::from_fn(|c| dm[r][c][batch])),
            area,
        });
        Self {
            batches,
            rest: rest.collect(),
            rest_grams: sources.iter().map(|&i| sorted.get(i as usize).map_or([0.0; 3], |t| t.rest_gram)).collect(),
            constants: constants(fabric),
        }
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, fabric: &Fabric) {
        self.constants = constants(fabric);
    }

    /// The edges, and the Green strain.
    #[inline(always)]
    fn edges(&self, batch: usize, x: &[DVec3]) -> ([V3<L>; 2], Strain<L>) {
        let vertices = self.batches.vertices::<L>(batch);
        let grams = &self.rest_grams[batch * L::LANES..][..L::LANES];
        let [ax, ay, az, bx, by, bz, g11, g22, g12] = L::from_rows(
            #[inline(always)]
            |lane| {
                let [a, b, c] = vertices[lane];
                let (a, b, c) = (x[a as usize], x[b as usize], x[c as usize]);
                let (e1, e2) = (b - a, c - a);
                let [g11, g22, g12] = membrane::half_gram_change([V3(e1.to_array()), V3(e2.to_array())], grams[lane]);
                let r = L::Scalar::from_f64;
                [r(e1.x), r(e1.y), r(e1.z), r(e2.x), r(e2.y), r(e2.z), r(g11), r(g22), r(g12)]
            },
        );
        ([V3([ax, ay, az]), V3([bx, by, bz])], self.rest[batch].green_strain([g11, g22, g12]))
    }
}

impl<L: Real> Elements for Triangles<L> {
    type Lanes = L;

    fn batches(&self) -> &[PartBatches] {
        self.batches.parts()
    }

    #[inline(always)]
    fn energy(&self, batch: usize, x: &[DVec3]) -> L {
        membrane::energy(&self.rest[batch], &self.constants, &self.edges(batch, x).1)
    }

    #[inline(always)]
    fn assemble(&self, batch: usize, at: &Linearisation<L::Scalar>, out: &mut Output<L::Scalar>) {
        let (material, geometric, rate) = (L::splat(at.material), L::splat(at.geometric), L::splat(at.rate));
        let (k, rest) = (&self.constants, &self.rest[batch]);
        let (edges, strain) = self.edges(batch, at.x);
        let w = rest.deformation(edges);
        let stress = k.stress(&strain);
        let projected = match at.projection {
            Projection::PositivePart => stress.positive_part(),
            Projection::Absolute => stress.absolute(),
        };
        let mut total = stress;
        if at.rate > 0.0 {
            let moved = rest.deformation(self.batches.edge_moves(batch, at.moved));
            total = total + k.stress(&w.strain_rate(&moved)) * rate;
        }

        let (vertices, slots) = (self.batches.vertices::<L>(batch), self.batches.slots::<L>(batch));
        let [g1, g2] = membrane::gradient(rest, &total, &w);
        for (i, force) in [g1 + g2, -g1, -g2].into_iter().enumerate() {
            let [x, y, z] = force.0;
            for (vertices, &quad) in vertices.iter().zip(L::quads([x, y, z, L::zero()]).as_ref()) {
                out.add_force(vertices[i], Padded(quad));
            }
        }
        let hessian = membrane::hessian(rest, k, &projected, &w, material, geometric);
        for (pair, block) in hessian.lower_blocks().into_iter().enumerate() {
            let [[a, b, c], [d, e, f], [g, h, last]] = block.0;
            let (first, second) = (L::quads([a, b, c, d]), L::quads([e, f, g, h]));
            for (lane, slots) in slots.iter().enumerate() {
                out.add(slots[pair] as usize, Flat(first.as_ref()[lane], second.as_ref()[lane], last.lane(lane)));
            }
        }
    }
}

/// The same triangle with its vertices numbered anew and in ascending order.
fn ascending(triangle: &Triangle, inner: &[u32]) -> Triangle {
    let vertices = triangle.vertices.map(|v| inner[v as usize]);
    let mut order = [0, 1, 2];
    order.sort_unstable_by_key(|&i| vertices[i]);
    let [origin, first, second] = order;

    let [[a, b], [c, d]] = triangle.dm_inverse;
    let det = a * d - b * c;
    // Vertices in the material frame: 0 at the origin, the others where the columns of D_m say.
    let points = [[0.0, 0.0], [d / det, -c / det], [-b / det, a / det]];
    let edge = |to: usize| [points[to][0] - points[origin][0], points[to][1] - points[origin][1]];
    let (e1, e2) = (edge(first), edge(second));
    let det = e1[0] * e2[1] - e1[1] * e2[0];

    let [g11, g22, g12] = triangle.rest_gram;
    let product = [[0.0, 0.0, 0.0], [0.0, g11, g12], [0.0, g12, g22]];
    let gram = |i: usize, j: usize| product[i][j] - product[i][origin] - product[origin][j] + product[origin][origin];
    Triangle {
        vertices: order.map(|i| vertices[i]),
        dm_inverse: [[e2[1] / det, -e2[0] / det], [-e1[1] / det, e1[0] / det]],
        rest_gram: [gram(first, first), gram(second, second), gram(first, second)],
        ..*triangle
    }
}
