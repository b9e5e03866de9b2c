//! Couplings of vertices that the pattern of A does not know: a spring across the cloth, later cloth on cloth.
//!
//! A stencil with signed weights w and stiffness K adds `w wᵀ ⊗ K` to A. Where the pattern lacks a pair, that stands beside A instead,
//! and the diagonal of A gets `Dᵢ = |wᵢ| Σ|wⱼ| K`, by Gershgorin no less than it: so A is positive definite with the diagonal alone,
//! which preconditioners and factorizations see, and the product puts the difference right.

use super::stencils::block;
use super::{ImplicitStep, Stencil};
use crate::physics::math::{M3, Padded, Scalar};

/// What the product has beside A: `Σ (w wᵀ − diag |wᵢ| Σ|wⱼ|) ⊗ K`.
#[derive(Clone, Debug)]
pub struct Couplings<T>(Vec<Coupling<T>>);

impl<T> Default for Couplings<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

#[derive(Clone, Copy, Debug)]
struct Coupling<T> {
    vertices: [u32; 4],
    weights: [T; 4],
    /// |wᵢ| Σ|wⱼ|, as the diagonal of A has it.
    lumps: [T; 4],
    /// γ² K, kg.
    stiffness: M3<T>,
}

impl<T: Scalar> Couplings<T> {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds a stencil; the blocks are to be added to the diagonal of these rows.
    pub(super) fn push(
        &mut self,
        step: &ImplicitStep,
        stencil: &Stencil,
    ) -> impl Iterator<Item = (usize, M3<T>)> + use<T> {
        let all: f64 = stencil.weights.iter().map(|weight| weight.abs()).sum();
        let lump = move |weight: f64| weight.abs() * all;
        let (stiffness, square) = (stencil.stiffness, step.gamma * step.gamma);
        self.0.push(Coupling {
            vertices: stencil.vertices,
            weights: stencil.weights.map(T::from_f64),
            lumps: stencil.weights.map(|weight| T::from_f64(lump(weight))),
            stiffness: block(&stiffness, square),
        });
        let stencil = *stencil;
        let corners = stencil.vertices.into_iter().zip(stencil.weights).filter(|&(_, weight)| weight != 0.0);
        corners
            .map(|(row, weight)| (row as usize, weight))
            .map(move |(row, weight)| (row, block(&stiffness, square * lump(weight))))
    }

    /// Takes out the rows that are pinned, whose moves are prescribed: what they push goes to b.
    pub(super) fn constrain(&mut self, b: &mut [Padded<T>], pinned: &[bool], prescribed: impl Fn(usize) -> Padded<T>) {
        for Coupling { vertices, weights, lumps, stiffness } in &mut self.0 {
            let mut pushed = Padded::zero();
            for ((&vertex, weight), lump) in vertices.iter().zip(&mut *weights).zip(lumps) {
                if pinned[vertex as usize] && *weight != T::zero() {
                    pushed += prescribed(vertex as usize) * *weight;
                    (*weight, *lump) = (T::zero(), T::zero());
                }
            }
            let force = stiffness.times(pushed);
            for (&vertex, &weight) in vertices.iter().zip(&*weights).filter(|(_, weight)| **weight != T::zero()) {
                b[vertex as usize] -= force * weight;
            }
        }
    }

    /// Adds to `y = A x` what is beside A; returns its part of `xᵀ A x`.
    pub(super) fn add_product(&self, x: &[Padded<T>], y: &mut [Padded<T>]) -> f64 {
        let mut sum = 0.0;
        for Coupling { vertices, weights, lumps, stiffness } in &self.0 {
            let corners = vertices.map(|vertex| vertex as usize).into_iter().zip(weights).zip(lumps);
            let mut point = Padded::zero();
            for ((vertex, &weight), _) in corners.clone() {
                point += x[vertex] * weight;
            }
            let force = stiffness.times(point);
            for ((vertex, &weight), &lump) in corners {
                let product = force * weight - stiffness.times(x[vertex]) * lump;
                y[vertex] += product;
                sum += x[vertex].dot_f64(product);
            }
        }
        sum
    }
}
