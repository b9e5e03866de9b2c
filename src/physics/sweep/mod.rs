//! A nonlinear Gauss–Seidel sweep over the triangles, which takes out of a prediction the strain that it has and the solution has not.
//!
//! Where inertia alone leads, a triangle that turns by φ in a step is stretched by φ²/2: tens of N/m that the solution does not have.
//! Linearized there, a step is as stiff against that turn as if they were real. So each triangle first takes out the change of its
//! Green strain since the step began, as the constraint of XPBD would (Macklin, Müller & Chentanez 2016, eq. 18, with one multiplier
//! for each of the three strains): see [`projection`].
//!
//! A sweep moves the point of linearization and nothing else: where the step leads is still what its linear system says.

mod batches;
mod projection;

use bevy::math::DVec3;

use self::batches::Batches;
use self::projection::Projected;
use super::assembly::Part;
use super::assembly::parts::for_parts;
use super::energy::membrane::Orthotropic;
use super::material::Fabric;
use super::math::{Lanes, Oct, Pack, Padded, ROWS, RowKernel, Scalar, V3};
use super::mesh::RestShape;

/// A vertex in a sweep.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct Point<T: Scalar> {
    /// Where the step begins, from the first vertex of the cloth, m.
    at: Padded<T>,
    /// How far it has moved since, m.
    moved: Padded<T>,
}

/// Rest state of a batch of triangles.
#[derive(Clone, Copy, Debug)]
struct Rest<T> {
    /// D_m⁻¹ by rows, 1/m.
    dm_inverse: [[Pack<T>; 2]; 2],
    /// m².
    area: Pack<T>,
}

/// The triangles of a cloth, for sweeps. Vertices are numbered as the engine does.
#[derive(Clone, Debug)]
pub struct StrainSweep<T: Scalar> {
    batches: Batches,
    rest: Vec<Rest<T>>,
    /// Inverse of the stiffness, m/N; of shear, of its tensor component.
    compliance: Orthotropic<f64>,
    points: Vec<Point<T>>,
    /// 1/kg; zero for vertices that a sweep may not move.
    inverse_masses: Vec<T>,
}

impl<T: Scalar> StrainSweep<T> {
    /// For the triangles of a cloth whose rows are cut into these parts.
    pub fn new(shape: &RestShape, fabric: &Fabric, inner: &[u32], parts: &[Part]) -> Self {
        let zero = Point { at: Padded::zero(), moved: Padded::zero() };
        let triangles: Vec<_> = shape.triangles.iter().map(|t| t.vertices.map(|v| inner[v as usize])).collect();
        let mut sweep = Self {
            batches: Batches::new(&triangles, inner.len(), parts),
            rest: Vec::new(),
            compliance: compliance(fabric),
            points: vec![zero; inner.len()],
            inverse_masses: vec![T::zero(); inner.len()],
        };
        sweep.measure(shape);
        sweep
    }

    /// Changes the material.
    pub fn set_fabric(&mut self, fabric: &Fabric) {
        self.compliance = compliance(fabric);
    }

    /// Takes over what the triangles measure at rest.
    pub fn measure(&mut self, shape: &RestShape) {
        let pack = |sources: &[Option<u32>], value: &dyn Fn(usize) -> f64| {
            Pack(core::array::from_fn(|lane| T::from_f64(sources[lane].map_or(0.0, |source| value(source as usize)))))
        };
        self.rest.clear();
        self.rest.extend(self.batches.sources().map(|sources| Rest {
            dm_inverse: [0, 1].map(|row| {
                [0, 1].map(|column| pack(sources, &|source| shape.triangles[source].dm_inverse[row][column]))
            }),
            area: pack(sources, &|source| shape.triangles[source].area),
        }));
    }

    /// Sweeps `count` times over `points`, for a step of γ² = `square` (s²) that began at `x`. Vertices that `fixed` names stay;
    /// `masses` are those of the others, kg.
    pub fn run(
        &mut self,
        (count, square): (u32, f64),
        x: &[DVec3],
        masses: &[f64],
        fixed: impl Fn(usize) -> bool + Sync,
        points: &mut [DVec3],
        parts: &[Part],
    ) {
        let Self { batches, rest, compliance, points: swept, inverse_masses } = self;
        let first = x[0];
        let predicted = &*points;
        for_parts(parts, (&mut swept[..], &mut inverse_masses[..]), &|part: &Part, (swept, inverse_masses)| {
            for ((point, inverse), vertex) in swept.iter_mut().zip(inverse_masses).zip(part.rows.clone()) {
                *point = Point {
                    at: Padded::from_f64((x[vertex] - first).to_array()),
                    moved: Padded::from_f64((predicted[vertex] - x[vertex]).to_array()),
                };
                *inverse = if fixed(vertex) { T::zero() } else { T::from_f64(1.0 / masses[vertex]) };
            }
        });
        let inverse_masses = &inverse_masses[..];
        let sweep = |batches: &[batches::Batch], first_batch: usize, first_vertex: usize, points: &mut [Point<T>]| {
            let rest = &rest[first_batch..][..batches.len()];
            T::dispatch(Sweep { batches, rest, compliance, inverse_masses, first_vertex, points, square });
        };
        for _ in 0..count {
            for_parts(parts, &mut swept[..], &|part: &Part, points| {
                let inside = batches.inside(part.index);
                sweep(&batches.all()[inside.clone()], inside.start, part.rows.start, points);
            });
            let across = batches.across();
            sweep(&batches.all()[across.clone()], across.start, 0, swept);
        }
        let swept = &swept[..];
        for_parts(parts, points, &|part: &Part, points| {
            for (to, vertex) in points.iter_mut().zip(part.rows.clone()) {
                *to = x[vertex] + DVec3::from(swept[vertex].moved.to_f64());
            }
        });
    }
}

fn compliance(fabric: &Fabric) -> Orthotropic<f64> {
    let [k0, k1, k2, k3] =
        [fabric.warp_stiffness, fabric.coupling, fabric.weft_stiffness, fabric.shear_stiffness].map(f64::from);
    let determinant = k0 * k2 - k1 * k1;
    Orthotropic { k0: k2 / determinant, k1: -k1 / determinant, k2: k0 / determinant, k3: 0.5 / k3 }
}

/// One sweep over batches, whose vertices stand in `points` from number `first_vertex` on.
struct Sweep<'a, T: Scalar> {
    batches: &'a [batches::Batch],
    rest: &'a [Rest<T>],
    compliance: &'a Orthotropic<f64>,
    inverse_masses: &'a [T],
    first_vertex: usize,
    points: &'a mut [Point<T>],
    square: f64,
}

impl<T: Scalar> RowKernel<T> for Sweep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        let Self { batches, rest, compliance, inverse_masses, first_vertex, points, square } = self;
        for (batch, rest) in batches.iter().zip(rest) {
            let [[u1, v1], [u2, v2]] = &rest.dm_inverse;
            let area = Lanes::load(s, &rest.area);
            let [m0, m1, m2] = [
                mobility(s, &batch.vertices[0], inverse_masses, area),
                mobility(s, &batch.vertices[1], inverse_masses, area),
                mobility(s, &batch.vertices[2], inverse_masses, area),
            ];
            let triangle = Projected {
                dm_inverse: [[area.like(u1), area.like(v1)], [area.like(u2), area.like(v2)]],
                mobility: [m0, m1, m2],
            };
            let (a0, d0) = gather(s, &batch.vertices[0], first_vertex, points);
            let (a1, d1) = gather(s, &batch.vertices[1], first_vertex, points);
            let (a2, d2) = gather(s, &batch.vertices[2], first_vertex, points);
            let [m0, m1, m2] = triangle.moves(compliance, square, [a1 - a0, a2 - a0], [d1 - d0, d2 - d0]);
            scatter(s, &batch.vertices[0], first_vertex, m0, points);
            scatter(s, &batch.vertices[1], first_vertex, m1, points);
            scatter(s, &batch.vertices[2], first_vertex, m2, points);
        }
    }
}

// Functions, as closures and `map` are not compiled for the instruction set of a kernel.

/// A/m of one vertex of each triangle, m²/kg.
#[inline(always)]
fn mobility<T: Scalar, S: Oct<T>>(
    s: S,
    vertices: &[u32; ROWS],
    inverse_masses: &[T],
    area: Lanes<T, S>,
) -> Lanes<T, S> {
    let mut inverse = [T::zero(); ROWS];
    for (inverse, &vertex) in inverse.iter_mut().zip(vertices) {
        *inverse = inverse_masses[vertex as usize];
    }
    Lanes::load(s, &Pack(inverse)) * area
}

/// Where one vertex of each triangle was when the step began, and how far it has moved since, m.
#[inline(always)]
fn gather<T: Scalar, S: Oct<T>>(
    s: S,
    vertices: &[u32; ROWS],
    first_vertex: usize,
    points: &[Point<T>],
) -> (V3<Lanes<T, S>>, V3<Lanes<T, S>>) {
    let (mut at, mut moved) = ([Padded::zero(); ROWS], [Padded::zero(); ROWS]);
    for (lane, &vertex) in vertices.iter().enumerate() {
        let point = &points[vertex as usize - first_vertex];
        (at[lane], moved[lane]) = (point.at, point.moved);
    }
    (V3::of(s, s.turn(at)), V3::of(s, s.turn(moved)))
}

/// Moves one vertex of each triangle on.
#[inline(always)]
fn scatter<T: Scalar, S: Oct<T>>(
    s: S,
    vertices: &[u32; ROWS],
    first_vertex: usize,
    V3([x, y, z]): V3<Lanes<T, S>>,
    points: &mut [Point<T>],
) {
    for (&vertex, moved) in vertices.iter().zip(s.turn_back([x.v, y.v, z.v])) {
        points[vertex as usize - first_vertex].moved += moved;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::assembly::{Ordering, System};
    use crate::physics::mesh::{RestShapeOptions, SurfaceMesh};

    const SIDE: u32 = 12;

    fn sheet() -> RestShape {
        let corners: Vec<_> =
            (0..=SIDE).flat_map(|i| (0..=SIDE).map(move |j| DVec3::new(i.into(), 0.0, j.into()))).collect();
        let at = |i: u32, j: u32| i * (SIDE + 1) + j;
        let cells = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j)));
        let triangles: Vec<_> = cells
            .flat_map(|(i, j)| [[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]])
            .collect();
        let positions: Vec<_> = corners.iter().map(|x| 0.05 * *x).collect();
        let mesh = SurfaceMesh { positions: &positions, triangles: &triangles, uvs: None };
        RestShape::new(&mesh, &RestShapeOptions::default()).unwrap()
    }

    /// Positions, masses and parts in the order of the engine, with the sweep.
    struct Stage {
        sweep: StrainSweep<f64>,
        x: Vec<DVec3>,
        masses: Vec<f64>,
        parts: Vec<Part>,
    }

    fn stage(ordering: impl Fn(&RestShape) -> Ordering) -> Stage {
        let (shape, fabric) = (sheet(), Fabric::cotton());
        let ordering = ordering(&shape);
        let parts = System::<f64>::new(&shape, &fabric, &ordering).matrix.pattern().parts().to_vec();
        let inner =
            |values: &dyn Fn(usize) -> f64| ordering.outer.iter().map(|&v| values(v as usize)).collect::<Vec<_>>();
        Stage {
            sweep: StrainSweep::new(&shape, &fabric, &ordering.inner, &parts),
            x: ordering.outer.iter().map(|&v| shape.positions[v as usize]).collect(),
            masses: inner(&|v| shape.vertex_areas[v] * f64::from(fabric.density)),
            parts,
        }
    }

    fn in_two_parts(shape: &RestShape) -> Ordering {
        Ordering { part_starts: vec![0, 80], ..Ordering::new(shape) }
    }

    /// Turned by `angle` rad about an edge, as velocities would do it: along the tangent.
    fn turned(x: &[DVec3], angle: f64) -> Vec<DVec3> {
        x.iter().map(|x| *x + angle * DVec3::Y * x.x).collect()
    }

    /// Mean square stretch between vertices that are beside each other.
    fn stretch(x: &[DVec3], y: &[DVec3]) -> f64 {
        let pairs = (0..x.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        let near = pairs.filter(|&(a, b)| x[a].distance(x[b]) < 0.06);
        near.map(|(a, b)| (y[a].distance(y[b]) / x[a].distance(x[b]) - 1.0).powi(2)).sum()
    }

    #[test]
    fn strain_that_a_prediction_adds_is_taken_out_and_momentum_kept() {
        for ordering in [Ordering::new, in_two_parts] {
            let Stage { mut sweep, x, masses, parts } = stage(ordering);
            let wave = |x: DVec3| DVec3::new((40.0 * x.z).sin(), 2.0 * (50.0 * x.x).cos(), (45.0 * x.x).sin());
            let mut points: Vec<_> = x.iter().map(|&x| x + 0.004 * wave(x)).collect();
            let before = points.clone();
            let added = stretch(&x, &points);
            sweep.run((2, 1e-4), &x, &masses, |_| false, &mut points, &parts);
            assert!(stretch(&x, &points) < 0.3 * added, "{} of {added}", stretch(&x, &points));
            let moved: DVec3 = masses.iter().zip(points.iter().zip(&before)).map(|(&m, (&a, &b))| m * (a - b)).sum();
            assert!(moved.length() < 1e-15, "{moved}");
        }
    }

    #[test]
    fn nothing_that_only_moves_as_a_whole_or_is_fixed_is_moved() {
        let Stage { mut sweep, x, masses, parts } = stage(in_two_parts);
        let mut points: Vec<_> = x.iter().map(|x| *x + DVec3::new(0.3, -0.2, 0.1)).collect();
        let shifted = points.clone();
        sweep.run((1, 1e-4), &x, &masses, |_| false, &mut points, &parts);
        assert!(points.iter().zip(&shifted).all(|(a, b)| a.distance(*b) < 1e-14));
        let mut points = turned(&x, 0.3);
        let before = points.clone();
        sweep.run((1, 1e-4), &x, &masses, |vertex| vertex % 3 == 0, &mut points, &parts);
        for (vertex, (a, b)) in points.iter().zip(&before).enumerate() {
            assert!(vertex % 3 != 0 || a.distance(*b) < 1e-15);
        }
    }
}
