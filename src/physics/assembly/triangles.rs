//! The membrane elements of a cloth.

use super::BlockPattern;
use super::batch::{self, Batches, Elements, FILLER, Output, PartBatches};
use super::implicit_step::{Linearisation, Projection};
use super::parts::{Part, for_parts};
use crate::physics::energy::membrane::{self, Gram, Orthotropic, Rest, Strain};
use crate::physics::material::Fabric;
use crate::physics::math::{Lanes, Oct, Pack, Padded, ROWS, Real, Scalar, V3};
use crate::physics::mesh::{RestShape, Triangle};

/// All triangles, in batches, the vertices of each in ascending order.
pub(super) struct Triangles<T> {
    batches: Batches<3, 3>,
    /// Which triangle of the rest shape stands at each place.
    sources: Vec<u32>,
    rest: Vec<Rest<Pack<T>>>,
    /// Gram matrices of the rest edges: in f64, see [`membrane`].
    rest_grams: Vec<Gram<Pack<f64>>>,
    constants: Orthotropic<f64>,
}

fn constants(fabric: &Fabric) -> Orthotropic<f64> {
    Orthotropic {
        k0: fabric.warp_stiffness.into(),
        k1: fabric.coupling.into(),
        k2: fabric.weft_stiffness.into(),
        k3: fabric.shear_stiffness.into(),
    }
}

impl<T: Scalar> Triangles<T> {
    pub fn new(shape: &RestShape, fabric: &Fabric, inner: &[u32], rank: &[u32], pattern: &BlockPattern) -> Self {
        let vertices: Vec<_> = shape.triangles.iter().map(|t| ascending(t, inner).vertices).collect();
        let (batches, sources) = Batches::new(&vertices, pattern, rank);
        let zero = Pack([T::zero(); ROWS]);
        let count = sources.len() / ROWS;
        let mut triangles = Self {
            batches,
            sources,
            // A filler has no area, so no energy, force or Hessian.
            rest: vec![Rest { dm_inverse: [[zero; 2]; 2], area: zero }; count],
            rest_grams: vec![[Pack([0.0; ROWS]); 3]; count],
            constants: constants(fabric),
        };
        triangles.measure(shape, inner);
        triangles
    }

    /// Takes over what the triangles measure at rest.
    pub fn measure(&mut self, shape: &RestShape, inner: &[u32]) {
        let rests = self.rest.iter_mut().zip(&mut self.rest_grams);
        for (sources, (rest, grams)) in self.sources.chunks_exact(ROWS).zip(rests) {
            for (lane, &source) in sources.iter().enumerate().filter(|(_, source)| **source != FILLER) {
                let triangle = ascending(&shape.triangles[source as usize], inner);
                for (row, values) in rest.dm_inverse.iter_mut().zip(triangle.dm_inverse) {
                    row[0].0[lane] = T::from_f64(values[0]);
                    row[1].0[lane] = T::from_f64(values[1]);
                }
                rest.area.0[lane] = T::from_f64(triangle.area);
                for (gram, value) in grams.iter_mut().zip(triangle.rest_gram) {
                    gram.0[lane] = value;
                }
            }
        }
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, fabric: &Fabric) {
        self.constants = constants(fabric);
    }

    /// Elastic energy at `x`, J.
    pub fn energy_at(&self, parts: &[Part], x: &[Padded<f64>]) -> f64 {
        for_parts(parts, (), &|part: &Part, ()| batch::energy(self, part.index, x))
    }

    /// Rest state of a batch.
    #[inline(always)]
    fn rest<S: Oct<T>>(&self, s: S, batch: usize) -> Rest<Lanes<T, S>> {
        let Rest { dm_inverse: [[u1, v1], [u2, v2]], area } = &self.rest[batch];
        let area = Lanes::load(s, area);
        Rest { dm_inverse: [[area.like(u1), area.like(v1)], [area.like(u2), area.like(v2)]], area }
    }

    /// Constants, of as many elements as `like`.
    #[inline(always)]
    fn constants<S: Oct<T>>(&self, like: Lanes<T, S>) -> Orthotropic<Lanes<T, S>> {
        let Orthotropic { k0, k1, k2, k3 } = self.constants;
        Orthotropic { k0: like.splat(k0), k1: like.splat(k1), k2: like.splat(k2), k3: like.splat(k3) }
    }

    /// The Green strain, from edges in f64.
    #[inline(always)]
    fn strain<S: Oct<T>>(
        &self,
        s: S,
        batch: usize,
        rest: &Rest<Lanes<T, S>>,
        edges: [V3<Lanes<f64, S::Wide>>; 2],
    ) -> Strain<Lanes<T, S>> {
        let [g11, g22, g12] = &self.rest_grams[batch];
        let rest_gram = [Lanes::load(s.wide(), g11), Lanes::load(s.wide(), g22), Lanes::load(s.wide(), g12)];
        let [g11, g22, g12] = membrane::half_gram_change(edges, rest_gram);
        rest.green_strain([Lanes::narrow(s, g11), Lanes::narrow(s, g22), Lanes::narrow(s, g12)])
    }
}

impl<T: Scalar> Elements<T> for Triangles<T> {
    fn batches(&self) -> &[PartBatches] {
        self.batches.parts()
    }

    #[inline(always)]
    fn energy<S: Oct<T>>(&self, s: S, batch: usize, x: &[Padded<f64>]) -> Lanes<T, S> {
        let rest = self.rest(s, batch);
        let strain = self.strain(s, batch, &rest, self.batches.edges(s.wide(), batch, x));
        membrane::energy(&rest, &self.constants(rest.area), &strain)
    }

    #[inline(always)]
    fn assemble<S: Oct<T>>(&self, s: S, batch: usize, at: &Linearisation<T>, out: &mut Output<T>) {
        let rest = self.rest(s, batch);
        let k = self.constants(rest.area);
        let (material, geometric) = (rest.area.splat(at.material), rest.area.splat(at.geometric));
        let [e1, e2] = self.batches.edges(s.wide(), batch, at.x);
        let strain = self.strain(s, batch, &rest, [e1, e2]);
        let w = rest.deformation([V3::narrow(s, e1), V3::narrow(s, e2)]);
        let stress = k.stress(&strain);
        let projected = match at.projection {
            Projection::PositivePart => stress.positive_part(),
            Projection::Absolute => stress.absolute(),
        };
        let mut total = stress;
        if at.rate > 0.0 {
            let moved = rest.deformation(self.batches.edge_moves(s, batch, at.moved));
            total = total + k.stress(&w.strain_rate(&moved)) * rest.area.splat(at.rate);
        }

        let [g1, g2] = membrane::gradient(&rest, &total, &w);
        out.add_forces(s, self.batches.vertices(batch, 0), g1 + g2);
        out.add_forces(s, self.batches.vertices(batch, 1), -g1);
        out.add_forces(s, self.batches.vertices(batch, 2), -g2);
        let hessian = membrane::hessian(&rest, &k, &projected, &w, material, geometric);
        for (pair, block) in hessian.lower_blocks().iter().enumerate() {
            out.add_blocks(s, self.batches.slots(batch, pair), block);
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
