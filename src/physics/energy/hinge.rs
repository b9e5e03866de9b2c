//! Bending: dihedral angle with a rest angle (Grinspun et al. 2003, "Discrete Shells"; derivatives as in Tamstorf &
//! Grinspun 2013).
//!
//! Kinematics. Vertices 0 and 1 are the ends of the shared edge `e = x1−x0`, 2 and 3 the vertices opposite. With the
//! normals `n1 = e × (x2−x0)` and `n2 = (x3−x0) × e`, the angle `θ = atan2((n1 × n2)·e/‖e‖, n1·n2)` is 0 when flat.
//!
//! Energy. `E = k_b ‖ē‖/h̄ (θ − θ̄)²`. A sheet of flexural rigidity D (energy `½ D κ²` per area) has `k_b = D/3` on an
//! equilateral mesh; on other meshes the rigidity of hinges depends on the mesh and its direction (a factor 1–3 on grids):
//! [`mid_edge`](super::mid_edge) has not got this weakness.
//!
//! Gradient. `2 k_b ‖ē‖/h̄ (θ − θ̄) ∇θ` with `∇₂θ = −‖e‖ n1/‖n1‖²`, `∇₃θ = −‖e‖ n2/‖n2‖²`; the ends of the edge take the
//! opposite, shared by where the foot of each height falls on the edge.
//!
//! Hessian. Gauss–Newton, `2 k_b ‖ē‖/h̄ ∇θ ∇θᵀ`: positive semi-definite, without the term of the curvature of θ.

use bevy::math::DVec3;

use crate::physics::math::{Real, V3};

/// Rest state and stiffness of a hinge.
#[derive(Clone, Copy, Debug)]
pub struct Rest<T> {
    /// `k_b ‖ē‖/h̄`, J/rad².
    pub stiffness: T,
    /// Rest angle θ̄, rad.
    pub rest_angle: T,
    /// Floor of ‖n1‖² and ‖n2‖², m⁴: the gradient of the angle of a collapsed triangle has no bound.
    pub normal_floor: T,
}

impl Rest<f64> {
    /// A hinge of flexural rigidity `bending` (N·m), rest `length` and mean `height` h̄ (m), and twice the rest areas (m²).
    pub fn new(bending: f64, length: f64, height: f64, double_areas: [f64; 2], rest_angle: f64) -> Self {
        // A thousandth of the smaller rest area: further in, the exact gradient is of no use to anyone.
        let floor = 1e-3 * double_areas[0].min(double_areas[1]);
        Self { stiffness: bending / 3.0 * length / height, rest_angle, normal_floor: floor * floor }
    }
}

/// Edge vectors of a hinge: `x1−x0`, `x2−x0`, `x3−x0`.
pub type Edges<T> = [V3<T>; 3];

/// ∂θ/∂x of the four vertices, rad/m.
#[derive(Clone, Copy, Debug)]
pub struct Gradient<T>(pub [V3<T>; 4]);

impl<T: Real> Gradient<T> {
    /// Change of θ, to first order, when the edge vectors change by `moves`, rad.
    #[inline(always)]
    pub fn change(&self, [e, a, b]: Edges<T>) -> T {
        let [_, g1, g2, g3] = self.0;
        g1.dot(e) + g2.dot(a) + g3.dot(b)
    }
}

/// θ in rad.
#[inline(always)]
pub fn theta<T: Real>([e, a, b]: Edges<T>) -> T {
    let (n1, n2) = (e.cross(a), b.cross(e));
    // (n1 × n2)·e/‖e‖, where n1 × n2 = −(n1·b) e.
    let sine = -(n1.dot(b) * e.norm_squared().sqrt());
    sine.atan2(n1.dot(n2))
}

/// ∇θ.
#[inline(always)]
pub fn gradient<T: Real>([e, a, b]: Edges<T>, normal_floor: T) -> Gradient<T> {
    let (n1, n2) = (e.cross(a), b.cross(e));
    let length_squared = e.norm_squared();
    let one = length_squared.splat(1.0);
    let length = length_squared.sqrt();
    let safe_squared = length_squared.if_positive(length_squared, one);

    let g2 = n1 * -(length / n1.norm_squared().max(normal_floor));
    let g3 = n2 * -(length / n2.norm_squared().max(normal_floor));
    // Where the feet of the heights fall on the edge: 0 at x0, 1 at x1.
    let (t2, t3) = (a.dot(e) / safe_squared, b.dot(e) / safe_squared);
    let g0 = -(g2 * (one - t2) + g3 * (one - t3));
    let g1 = -(g2 * t2 + g3 * t3);
    Gradient([g0, g1, g2, g3])
}

/// θ − θ̄, brought into [−π, π]: a fold passing through π is not a jump.
#[inline(always)]
pub fn deviation<T: Real>(theta: T, rest_angle: T) -> T {
    let (pi, turn) = (theta.splat(core::f64::consts::PI), theta.splat(core::f64::consts::TAU));
    let d = theta - rest_angle;
    let d = (d - pi).if_positive(d - turn, d);
    (-d - pi).if_positive(d + turn, d)
}

/// Energy of a hinge, J.
#[inline(always)]
pub fn energy<T: Real>(rest: &Rest<T>, edges: Edges<T>) -> T {
    let d = deviation(theta(edges), rest.rest_angle);
    rest.stiffness * d * d
}

/// `∂E/∂θ = 2 k_b ‖ē‖/h̄ (θ − θ̄)`, J: times ∇θ it is the gradient.
#[inline(always)]
pub fn moment<T: Real>(rest: &Rest<T>, theta: T) -> T {
    rigidity(rest) * deviation(theta, rest.rest_angle)
}

/// `∂²E/∂θ² = 2 k_b ‖ē‖/h̄`, J: times ∇θ ∇θᵀ it is the Gauss–Newton Hessian.
#[inline(always)]
pub fn rigidity<T: Real>(rest: &Rest<T>) -> T {
    rest.stiffness + rest.stiffness
}

/// The dihedral angle θ of four points, rad.
pub fn dihedral_angle(x: [DVec3; 4]) -> f64 {
    theta([x[1] - x[0], x[2] - x[0], x[3] - x[0]].map(|e| V3(e.to_array())))
}
