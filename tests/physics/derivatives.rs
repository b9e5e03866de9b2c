//! Every gradient and Hessian of an element against central differences, in f64 on random states.

use bevy_cloth::physics::energy::hinge;
use bevy_cloth::physics::energy::membrane::{self, Orthotropic, Strain};
use bevy_cloth::physics::energy::stress::Stress;
use bevy_cloth::physics::math::{M3, V3};
use nalgebra::{DMatrix, DVector, Matrix2};
use rand::Rng;
use rand::rngs::StdRng;

use crate::meshes::rng;

const STEP: f64 = 1e-5;
const TOLERANCE: f64 = 1e-6;

fn random_point(rng: &mut StdRng, size: f64) -> V3<f64> {
    V3(core::array::from_fn(|_| rng.random_range(-size..size)))
}

/// Central differences of a vector function of `N` points: one row per component, one column per coordinate.
fn differences<const N: usize>(x: [V3<f64>; N], f: impl Fn([V3<f64>; N]) -> DVector<f64>) -> DMatrix<f64> {
    let columns: Vec<_> = (0..3 * N)
        .map(|i| {
            let at = |offset: f64| {
                let mut y = x;
                y[i / 3].0[i % 3] += offset;
                f(y)
            };
            (at(STEP) - at(-STEP)) / (2.0 * STEP)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

fn stacked(vectors: &[V3<f64>]) -> DVector<f64> {
    DVector::from_iterator(3 * vectors.len(), vectors.iter().flat_map(|v| v.0))
}

fn dense<const N: usize>(blocks: [[M3<f64>; N]; N]) -> DMatrix<f64> {
    DMatrix::from_fn(3 * N, 3 * N, |r, c| blocks[r / 3][c / 3].0[r % 3][c % 3])
}

fn assert_close(ours: &DMatrix<f64>, expected: &DMatrix<f64>, what: &str) {
    let error = (ours - expected).norm() / expected.norm();
    assert!(error < TOLERANCE, "{what}: relative error {error:e}");
}

// --- membrane ---------------------------------------------------------------------------------------------------------

struct Triangle {
    /// How the stress is made safe in the Hessian; `None` for the Hessian itself.
    projection: Option<fn(Stress<f64>) -> Stress<f64>>,
    rest: membrane::Rest<f64>,
    k: Orthotropic<f64>,
    x: [V3<f64>; 3],
}

fn edges([a, b, c]: [V3<f64>; 3]) -> [V3<f64>; 2] {
    [b - a, c - a]
}

fn random_triangle(rng: &mut StdRng) -> Triangle {
    let mut entry = |low, high| rng.random_range(low..high);
    let dm_inverse = [[entry(0.5, 1.5), entry(-0.4, 0.4)], [entry(-0.4, 0.4), entry(0.5, 1.5)]];
    let k = Orthotropic { k0: entry(50.0, 99.0), k1: entry(-20.0, 20.0), k2: entry(20.0, 80.0), k3: entry(5.0, 60.0) };
    let rest = membrane::Rest { dm_inverse, area: entry(0.1, 2.0) };
    loop {
        let x = core::array::from_fn(|_| random_point(rng, 1.5));
        let [e1, e2] = edges(x);
        if e1.cross(e2).norm_squared() > 0.05 {
            return Triangle { projection: None, rest, k, x };
        }
    }
}

impl Triangle {
    fn gradient(&self, x: [V3<f64>; 3]) -> DVector<f64> {
        let w = self.rest.deformation(edges(x));
        let [g1, g2] = membrane::gradient(&self.rest, &self.k.stress(&self.strain(x)), &w);
        stacked(&[-(g1 + g2), g1, g2])
    }

    fn hessian(&self, material: f64, geometric: f64) -> DMatrix<f64> {
        let w = self.rest.deformation(edges(self.x));
        let stress = self.k.stress(&self.strain(self.x));
        let safe = self.projection.map_or(stress, |project| project(stress));
        dense(membrane::hessian(&self.rest, &self.k, &safe, &w, material, geometric).blocks())
    }

    fn strain(&self, x: [V3<f64>; 3]) -> Strain<f64> {
        self.rest.green_strain(membrane::half_gram_change(edges(x), self.rest_gram()))
    }

    /// D_mᵀ D_m.
    fn rest_gram(&self) -> membrane::Gram<f64> {
        let [[a, b], [c, d]] = self.rest.dm_inverse;
        let dm = Matrix2::new(a, b, c, d).try_inverse().expect("a triangle with area");
        let gram = dm.transpose() * dm;
        [gram[(0, 0)], gram[(1, 1)], gram[(0, 1)]]
    }

    fn in_tension(&self) -> bool {
        let s = self.k.stress(&self.strain(self.x));
        s.s00 + s.s11 > 0.0 && s.s00 * s.s11 > s.s01 * s.s01
    }
}

#[test]
fn strain_is_half_of_the_right_cauchy_green_tensor_less_the_identity() {
    let mut rng = rng(8);
    for _ in 0..100 {
        let t = random_triangle(&mut rng);
        let w = t.rest.deformation(edges(t.x));
        let e = t.strain(t.x);
        let expected = [0.5 * (w.w_u.dot(w.w_u) - 1.0), 0.5 * (w.w_v.dot(w.w_v) - 1.0), 0.5 * w.w_u.dot(w.w_v)];
        for (ours, expected) in [e.e00, e.e11, e.e01].into_iter().zip(expected) {
            assert!((ours - expected).abs() < 1e-12, "{ours} {expected}");
        }
    }
}

#[test]
fn membrane_gradient() {
    let mut rng = rng(1);
    for case in 0..200 {
        let t = random_triangle(&mut rng);
        let energy = |x| DVector::from_element(1, membrane::energy(&t.rest, &t.k, &t.strain(x)));
        let expected = differences(t.x, energy).transpose();
        let ours = t.gradient(t.x);
        assert_close(&DMatrix::from_columns(&[ours]), &expected, &format!("case {case}"));
    }
}

#[test]
fn membrane_hessian_is_the_derivative_of_the_gradient() {
    let mut rng = rng(2);
    let mut tension = 0;
    for case in 0..200 {
        let mut t = random_triangle(&mut rng);
        let expected = differences(t.x, |x| t.gradient(x));
        assert_close(&t.hessian(1.0, 1.0), &expected, &format!("case {case}"));
        // In tension the projections change nothing.
        if t.in_tension() {
            tension += 1;
            for project in [Stress::positive_part, Stress::absolute] {
                t.projection = Some(project);
                assert_close(&t.hessian(1.0, 1.0), &expected, &format!("case {case}, projected"));
            }
        }
    }
    assert!(tension > 20, "only {tension} of the states were in tension");
}

#[test]
fn membrane_material_hessian_is_the_square_of_the_strain_derivative_everywhere() {
    let mut rng = rng(3);
    for case in 0..200 {
        let t = random_triangle(&mut rng);
        let strain = |x| {
            let e = t.strain(x);
            DVector::from_column_slice(&[e.e00, e.e11, e.e01])
        };
        let b = differences(t.x, strain);
        let k = &t.k;
        let c = DMatrix::from_row_slice(3, 3, &[k.k0, k.k1, 0.0, k.k1, k.k2, 0.0, 0.0, 0.0, 2.0 * k.k3]);
        let expected = b.transpose() * c * b * t.rest.area;
        assert_close(&t.hessian(1.0, 0.0), &expected, &format!("case {case}"));
    }
}

#[test]
fn projected_membrane_hessian_is_positive_semi_definite() {
    let mut rng = rng(4);
    let mut compressed = 0;
    for case in 0..500 {
        let mut t = random_triangle(&mut rng);
        compressed += u32::from(!t.in_tension());
        for project in [Stress::positive_part, Stress::absolute] {
            t.projection = Some(project);
            let eigenvalues = t.hessian(1.0, 1.0).symmetric_eigenvalues();
            assert!(eigenvalues.min() >= -1e-9 * eigenvalues.max(), "case {case}: {}", eigenvalues.min());
        }
    }
    assert!(compressed > 50, "only {compressed} of the states were compressed");
}

// --- hinge ------------------------------------------------------------------------------------------------------------

type Four = [V3<f64>; 4];

fn hinge_edges([a, b, c, d]: Four) -> hinge::Edges<f64> {
    [b - a, c - a, d - a]
}

fn random_hinge(rng: &mut StdRng) -> (hinge::Rest<f64>, Four) {
    loop {
        let x: Four = core::array::from_fn(|_| random_point(rng, 1.0));
        let [e, a, b] = hinge_edges(x);
        let rest = hinge::Rest {
            stiffness: rng.random_range(0.1..3.0),
            rest_angle: rng.random_range(-1.0..1.0),
            normal_floor: 1e-9,
        };
        let deviation = hinge::deviation(hinge::theta([e, a, b]), rest.rest_angle);
        let thick = e.cross(a).norm_squared().min(b.cross(e).norm_squared()) > 0.1 && e.norm_squared() > 0.1;
        // Central differences cannot straddle the cut of the angle, nor resolve a force that vanishes.
        if thick && (0.05..3.1).contains(&deviation.abs()) {
            return (rest, x);
        }
    }
}

#[test]
fn hinge_angle_gradient_and_energy_gradient() {
    let mut rng = rng(5);
    for case in 0..200 {
        let (rest, x) = random_hinge(&mut rng);
        let energy = |x| DVector::from_element(1, hinge::energy(&rest, hinge_edges(x)));
        let gradient = hinge::gradient(hinge_edges(x), rest.normal_floor);
        let moment = hinge::moment(&rest, hinge::theta(hinge_edges(x)));
        let ours = stacked(&gradient.0.map(|g| g * moment));
        let expected = differences(x, energy).transpose();
        assert_close(&DMatrix::from_columns(&[ours]), &expected, &format!("case {case}"));
    }
}

#[test]
fn hinge_hessian_is_the_derivative_of_the_gradient_at_the_rest_angle() {
    let mut rng = rng(6);
    for case in 0..200 {
        let (mut rest, x) = random_hinge(&mut rng);
        rest.rest_angle = hinge::theta(hinge_edges(x));
        let gradient = |x| {
            let moment = hinge::moment(&rest, hinge::theta(hinge_edges(x)));
            stacked(&hinge::gradient(hinge_edges(x), rest.normal_floor).0.map(|g| g * moment))
        };
        let g = stacked(&hinge::gradient(hinge_edges(x), rest.normal_floor).0);
        let ours = &g * g.transpose() * hinge::rigidity(&rest);
        assert_close(&ours, &differences(x, gradient), &format!("case {case}"));
    }
}

#[test]
fn hinge_bends_by_the_angle_between_its_triangles() {
    for degrees in [-170.0_f64, -90.0, -1.0, 0.0, 30.0, 120.0, 179.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        // A flat hinge along X whose second wing is turned about the edge.
        let x = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.7, -cos, sin]].map(V3);
        let theta = hinge::theta(hinge_edges(x));
        // Turned towards the normal of the first triangle: a valley, negative here.
        assert!((theta + degrees.to_radians()).abs() < 1e-12, "{degrees}: {theta}");
    }
}

#[test]
fn deviation_passes_smoothly_through_a_complete_fold() {
    let near = |theta: f64, rest: f64, expected: f64| {
        let d = hinge::deviation(theta, rest);
        assert!((d - expected).abs() < 1e-12, "{theta} from {rest}: {d}");
    };
    near(-3.0, 3.0, core::f64::consts::TAU - 6.0);
    near(3.0, -3.0, 6.0 - core::f64::consts::TAU);
    near(1.0, -1.0, 2.0);
    near(3.0, 0.0, 3.0);
}

#[test]
fn a_collapsed_hinge_gives_finite_forces() {
    let rest = hinge::Rest::new(1e-5, 0.1, 0.05, [0.01, 0.01], 0.0);
    for x in [[[0.0; 3]; 4], [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.2, 0.0, 0.0]]] {
        let gradient = hinge::gradient(hinge_edges(x.map(V3)), rest.normal_floor).0;
        let theta = hinge::theta(hinge_edges(x.map(V3)));
        let finite = gradient.iter().flat_map(|g| g.0).chain([theta]).all(f64::is_finite);
        assert!(finite, "{theta} {gradient:?}");
    }
}
