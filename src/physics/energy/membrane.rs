//! Stretch and shear: constant-strain triangle, Green strain, orthotropic Hooke's law (Narain et al. 2012, §3; Volino et
//! al. 2009).
//!
//! Kinematics. `D_m` holds the two material edges of the rest triangle, `F = [x1−x0, x2−x0] D_m⁻¹ = (w_u w_v)` maps warp
//! and weft to space, `ε = ½(FᵀF − I)`. With the rows of D_m⁻¹ as weights, `w_u = Σ δ_u[i] xᵢ`, `w_v = Σ δ_v[i] xᵢ`, where
//! `δ[0] = −δ[1] − δ[2]`. Written with the edges, `ε = D_m⁻ᵀ ½(G − Ḡ) D_m⁻¹` for the Gram matrices G of the edges now and Ḡ
//! at rest: taken this way, from a difference in f64, the strain of a nearly undeformed element keeps all its digits in f32
//! (½(FᵀF − I) has an error of 1e-7, which a stiffness of 1e6 N/m turns into 0.1 N/m).
//!
//! Energy. `E = A [½ k0 ε00² + k1 ε00 ε11 + ½ k2 ε11² + k3 ε01²]` with the rest area A.
//!
//! Stress. `S = [[k0 ε00 + k1 ε11, k3 ε01], [k3 ε01, k1 ε00 + k2 ε11]]`.
//!
//! Gradient. `∂E/∂xᵢ = A [(S00 δ_u[i] + S01 δ_v[i]) w_u + (S01 δ_u[i] + S11 δ_v[i]) w_v]`.
//!
//! Hessian. `H = A [BᵀC B + (Δᵀ S Δ) ⊗ I₃]`: the material term is positive semi-definite because C is, the geometric term is
//! when S is, so S is replaced by its positive part, or by its absolute value.
//!
//! Damping. `−dp A BᵀC B v` is the gradient for the stress `dp C ε̇` of the strain rate `ε̇ = B v`: it acts on the material
//! part only, so that a rigid rotation (ε̇ = 0) is undamped.

use super::stress::Stress;
use crate::physics::math::{M3, Real, V3};

/// Elastic constants k0, k1, k2, k3 in N/m.
#[derive(Clone, Copy, Debug)]
pub struct Orthotropic<T> {
    /// Warp, C11.
    pub k0: T,
    /// Coupling, C12.
    pub k1: T,
    /// Weft, C22.
    pub k2: T,
    /// Shear, 2 G h.
    pub k3: T,
}

/// `e1·e1, e2·e2, e1·e2` of the edges `e1 = x1−x0`, `e2 = x2−x0`, m².
pub type Gram<T> = [T; 3];

/// Rest state of an element.
#[derive(Clone, Copy, Debug)]
pub struct Rest<T> {
    /// D_m⁻¹ by rows, 1/m.
    pub dm_inverse: [[T; 2]; 2],
    /// Rest area A, m².
    pub area: T,
}

/// Images of warp and weft: the columns of F.
#[derive(Clone, Copy, Debug)]
pub struct Deformation<T> {
    /// F times the warp direction.
    pub w_u: V3<T>,
    /// F times the weft direction.
    pub w_v: V3<T>,
}

/// Green strain (ε00, ε11, ε01).
#[derive(Clone, Copy, Debug)]
pub struct Strain<T> {
    /// Along the warp.
    pub e00: T,
    /// Along the weft.
    pub e11: T,
    /// Shear.
    pub e01: T,
}

/// Hessian of an element as its independent part: the blocks of vertices 1 and 2. Those of vertex 0 follow from translation
/// invariance, `H0j = −H1j − H2j`.
#[derive(Clone, Copy, Debug)]
pub struct Hessian<T> {
    /// ∂²E/∂x1².
    pub h11: M3<T>,
    /// ∂²E/∂x2².
    pub h22: M3<T>,
    /// ∂²E/∂x1∂x2.
    pub h12: M3<T>,
}

impl<T: Real> Rest<T> {
    /// The deformation of a triangle with edges `x1−x0` and `x2−x0`.
    #[inline(always)]
    pub fn deformation(&self, edges: [V3<T>; 2]) -> Deformation<T> {
        let [[du1, dv1], [du2, dv2]] = self.dm_inverse;
        Deformation { w_u: edges[0] * du1 + edges[1] * du2, w_v: edges[0] * dv1 + edges[1] * dv2 }
    }

    /// ε from `½(G − Ḡ)`, the half change of the Gram matrix of the edges, m².
    #[inline(always)]
    pub fn green_strain(&self, [g11, g22, g12]: Gram<T>) -> Strain<T> {
        let [[u1, v1], [u2, v2]] = self.dm_inverse;
        let two = u1.splat(2.0);
        Strain {
            e00: u1 * u1 * g11 + u2 * u2 * g22 + two * u1 * u2 * g12,
            e11: v1 * v1 * g11 + v2 * v2 * g22 + two * v1 * v2 * g12,
            e01: u1 * v1 * g11 + u2 * v2 * g22 + (u1 * v2 + u2 * v1) * g12,
        }
    }
}

impl<T: Real> Deformation<T> {
    /// `B v`: change of the Green strain, to first order, when the deformation changes by `rate`.
    #[inline(always)]
    pub fn strain_rate(&self, rate: &Self) -> Strain<T> {
        let shear = self.w_u.dot(rate.w_v) + self.w_v.dot(rate.w_u);
        Strain { e00: self.w_u.dot(rate.w_u), e11: self.w_v.dot(rate.w_v), e01: shear.splat(0.5) * shear }
    }
}

impl<T: Real> Orthotropic<T> {
    /// Energy per rest area, J/m².
    #[inline(always)]
    pub fn energy_density(&self, e: &Strain<T>) -> T {
        let half = self.k0.splat(0.5);
        half * self.k0 * e.e00 * e.e00
            + self.k1 * e.e00 * e.e11
            + half * self.k2 * e.e11 * e.e11
            + self.k3 * e.e01 * e.e01
    }

    /// Second Piola–Kirchhoff stress per unit width, N/m.
    #[inline(always)]
    pub fn stress(&self, e: &Strain<T>) -> Stress<T> {
        Stress { s00: self.k0 * e.e00 + self.k1 * e.e11, s01: self.k3 * e.e01, s11: self.k1 * e.e00 + self.k2 * e.e11 }
    }
}

/// `½(G − Ḡ)` of two edges, m².
#[inline(always)]
pub fn half_gram_change<T: Real>([e1, e2]: [V3<T>; 2], rest: Gram<T>) -> Gram<T> {
    let half = rest[0].splat(0.5);
    [half * (e1.dot(e1) - rest[0]), half * (e2.dot(e2) - rest[1]), half * (e1.dot(e2) - rest[2])]
}

/// Energy of an element, J.
#[inline(always)]
pub fn energy<T: Real>(rest: &Rest<T>, k: &Orthotropic<T>, strain: &Strain<T>) -> T {
    rest.area * k.energy_density(strain)
}

/// ∂E/∂x1 and ∂E/∂x2, N; ∂E/∂x0 is minus their sum.
#[inline(always)]
pub fn gradient<T: Real>(rest: &Rest<T>, s: &Stress<T>, w: &Deformation<T>) -> [V3<T>; 2] {
    let [d1, d2] = rest.dm_inverse;
    [force(rest, s, w, d1), force(rest, s, w, d2)]
}

#[inline(always)]
fn force<T: Real>(rest: &Rest<T>, s: &Stress<T>, w: &Deformation<T>, [du, dv]: [T; 2]) -> V3<T> {
    (w.w_u * (s.s00 * du + s.s01 * dv) + w.w_v * (s.s01 * du + s.s11 * dv)) * rest.area
}

/// Hessian for a stress made safe, the material term weighted by `material` and the geometric one by `geometric`: in the implicit
/// step the two differ, because damping acts on the material term alone (it would brake rigid rotation otherwise).
///
/// With `U = w_u w_uᵀ`, `V = w_v w_vᵀ`, `W = w_u w_vᵀ`, the block (i, j) of BᵀCB is
/// `(k0 uᵢuⱼ + ½k3 vᵢvⱼ) U + (k2 vᵢvⱼ + ½k3 uᵢuⱼ) V + (k1 uᵢvⱼ + ½k3 vᵢuⱼ) W + (k1 vᵢuⱼ + ½k3 uᵢvⱼ) Wᵀ`, u = δ_u, v = δ_v.
#[inline(always)]
pub fn hessian<T: Real>(
    rest: &Rest<T>,
    k: &Orthotropic<T>,
    s: &Stress<T>,
    w: &Deformation<T>,
    material: T,
    geometric: T,
) -> Hessian<T> {
    let (material, geometric) = (material * rest.area, geometric * rest.area);
    let weighted = Weighted {
        k: Orthotropic { k0: k.k0 * material, k1: k.k1 * material, k2: k.k2 * material, k3: k.k3 * material },
        s: Stress { s00: s.s00 * geometric, s01: s.s01 * geometric, s11: s.s11 * geometric },
        uu: w.w_u.outer(w.w_u),
        vv: w.w_v.outer(w.w_v),
        uv: w.w_u.outer(w.w_v),
    };
    let [d1, d2] = rest.dm_inverse;
    Hessian { h11: weighted.block(d1, d1), h22: weighted.block(d2, d2), h12: weighted.block(d1, d2) }
}

/// What the blocks of a Hessian have in common.
struct Weighted<T> {
    k: Orthotropic<T>,
    s: Stress<T>,
    uu: M3<T>,
    vv: M3<T>,
    uv: M3<T>,
}

impl<T: Real> Weighted<T> {
    #[inline(always)]
    fn block(&self, [ui, vi]: [T; 2], [uj, vj]: [T; 2]) -> M3<T> {
        let (k, s) = (&self.k, &self.s);
        let half_k3 = k.k3.splat(0.5) * k.k3;
        let material = self.uu * (k.k0 * ui * uj + half_k3 * vi * vj)
            + self.vv * (k.k2 * vi * vj + half_k3 * ui * uj)
            + self.uv * (k.k1 * ui * vj + half_k3 * vi * uj)
            + self.uv.transpose() * (k.k1 * vi * uj + half_k3 * ui * vj);
        material.add_diagonal(s.s00 * ui * uj + s.s01 * (ui * vj + vi * uj) + s.s11 * vi * vj)
    }
}

impl<T: Real> Hessian<T> {
    /// The blocks (1, 0), (2, 0) and (2, 1).
    #[inline(always)]
    pub fn lower_blocks(&self) -> [M3<T>; 3] {
        let h21 = self.h12.transpose();
        [-(self.h11 + self.h12), -(h21 + self.h22), h21]
    }

    /// All nine blocks.
    pub fn blocks(&self) -> [[M3<T>; 3]; 3] {
        let [h10, h20, h21] = self.lower_blocks();
        let h00 = -(h10 + h20);
        [[h00, h10.transpose(), h20.transpose()], [h10, self.h11, self.h12], [h20, h21, self.h22]]
    }
}
