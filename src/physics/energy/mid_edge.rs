//! Bending: curvature of each triangle from the normals at the middle of its edges (Grinspun, Gingold, Reisman & Zorin 2006,
//! "Computing discrete shape operators on general meshes"; on a flat mesh the constant-moment plate element of Morley 1968).
//!
//! Kinematics. The normal at the middle of an edge is turned about the edge, relative to the normals of its two triangles,
//! by `φ = Θ/2 + δ` in the first and `φ = Θ/2 − δ` in the second: Θ = θ − θ̄ is the deviation of the dihedral angle of
//! [`hinge`](super::hinge), and the turn δ, one number per edge, is free. Where one of the triangles is clamped, the normal is its
//! own, and all of Θ is φ in the other: in general `φ = σ Θ ± δ` with shares σ that add up to 1. With rest length l_i, rest area A and in-plane normal n_i of edge i
//! in material axes, the change of curvature of a triangle is `K = Σ φ_i l_i/A n_i n_iᵀ`.
//!
//! Energy. `E = ½ A K : Ĉ : K = ½ Σ P_ij φ_i φ_j` per triangle, `P_ij = l_i l_j/A v_iᵀ Ĉ v_j` with `v = (n_x², n_y², n_x n_y)` and the
//! flexural rigidity Ĉ of the sheet, minimised over all δ. Unlike that of hinges it has the rigidity of the sheet in every
//! direction on every mesh, as constant curvature is represented exactly.
//!
//! Gradient. At the minimum over δ only the angles count: the moment of an edge is `∂E/∂θ = Σ_T σ (P φ)_e`, and times ∇θ it is
//! the gradient. What is left to the minimum is the residual `∂E/∂δ = (P φ)_e` of the first triangle less that of the second.
//!
//! Hessian. For fixed δ Gauss–Newton gives `Σ_T σ_i σ_j P_ij ∇θ_i ∇θ_jᵀ`, which couples the six vertices of a triangle and its
//! neighbours. [`lumped`] is the diagonal matrix that bounds it from above, and couples no more vertices than hinges do.

use crate::physics::math::Real;

/// Flexural rigidity Ĉ of an orthotropic sheet, acting on the curvatures (K_xx, K_yy, K_xy) along warp and weft, N·m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlexuralRigidity {
    /// D_warp, for K_xx.
    pub warp: f64,
    /// D_weft, for K_yy.
    pub weft: f64,
    /// Coupling of K_xx and K_yy.
    pub coupling: f64,
    /// Twist, for K_xy: 2 (1 − ν) D for an isotropic sheet.
    pub twist: f64,
}

/// The matrix P of a triangle, N·m: edge i is opposite vertex i. `dm_inverse` is its inverse material edge matrix, in 1/m, and
/// `area` its rest area, in m².
pub fn stiffness(rigidity: &FlexuralRigidity, dm_inverse: [[f64; 2]; 2], area: f64) -> [[f64; 3]; 3] {
    let [a, b] = dm_inverse;
    // Gradients of the barycentric coordinates: ∇λ_i = −n_i l_i / 2A.
    let gradients = [[-a[0] - b[0], -a[1] - b[1]], a, b];
    let bent = gradients.map(|[x, y]| {
        // v_i l_i, as n_i n_iᵀ does not feel the sign.
        let scale = 2.0 * area / (x * x + y * y).sqrt();
        [x * x * scale, y * y * scale, x * y * scale]
    });
    let FlexuralRigidity { warp, weft, coupling, twist } = *rigidity;
    let product = |[xx, yy, xy]: [f64; 3], [ux, uy, uxy]: [f64; 3]| {
        (warp * xx * ux + weft * yy * uy + coupling * (xx * uy + yy * ux) + twist * xy * uxy) / area
    };
    bent.map(|i| bent.map(|j| product(i, j)))
}

/// The rows of P that belong to an edge, in both of its triangles: with itself, then with the two other edges.
#[derive(Clone, Copy, Debug)]
pub struct Rows<T> {
    /// In the first triangle, N·m.
    pub first: [T; 3],
    /// In the second; zero at the boundary.
    pub second: [T; 3],
}

/// What the φ of an edge and its neighbours give.
#[derive(Clone, Copy, Debug)]
pub struct Bent<T> {
    /// φ of the edge in its first and second triangle, rad.
    pub own: [T; 2],
    /// (P φ)_e of the first triangle, N·m.
    pub first: T,
    /// (P φ)_e of the second.
    pub second: T,
}

impl<T: Real> Rows<T> {
    /// For φ of the edge in its first and second triangle, and of the two other edges of either.
    #[inline(always)]
    pub fn bend(&self, own: [T; 2], others: [T; 4]) -> Bent<T> {
        let [a, b, c] = self.first;
        let [d, e, f] = self.second;
        Bent {
            own,
            first: a * own[0] + b * others[0] + c * others[1],
            second: d * own[1] + e * others[2] + f * others[3],
        }
    }
}

impl<T: Real> Bent<T> {
    /// ∂E/∂θ, N·m, for the share of the first triangle in Θ.
    #[inline(always)]
    pub fn moment(&self, share: T) -> T {
        self.second + (self.first - self.second) * share
    }

    /// ∂E/∂δ, N·m.
    #[inline(always)]
    pub fn residual(&self) -> T {
        self.first - self.second
    }

    /// The part of the energy that is counted at the edge, J.
    #[inline(always)]
    pub fn energy(&self) -> T {
        let [first, second] = self.own;
        (self.first * first + self.second * second) * first.splat(0.5)
    }
}

/// The entry of the diagonal matrix that bounds the Hessian from above: `Σ_j |Q_ej|` with `Q = Σ_T σ_e σ_j P_ej` (Gershgorin),
/// N·m, for the shares of the edge in its triangles and of the four other edges; those at the boundary have none.
pub fn lumped(rows: &Rows<f64>, own: [f64; 2], others: [f64; 4]) -> f64 {
    let [a, b, c] = rows.first;
    let [d, e, f] = rows.second;
    own[0] * (own[0] * a + others[0] * b.abs() + others[1] * c.abs())
        + own[1] * (own[1] * d + others[2] * e.abs() + others[3] * f.abs())
}
