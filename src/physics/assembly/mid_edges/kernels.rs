//! What is computed for eight edges at once.

use core::ops::Range;

use super::topology::Side;
use crate::physics::energy::mid_edge::{Bent, Rows};
use crate::physics::math::{Lanes, Oct, Pack, ROWS, RowKernel, Scalar};

/// Edges in packs, with angles and turns.
#[derive(Clone, Copy)]
pub(super) struct Packs<'a, T> {
    pub rows: &'a [Rows<Pack<T>>],
    pub others: &'a [[[Side; ROWS]; 4]],
    pub half: &'a [Pack<T>],
    pub turns: &'a [Pack<T>],
}

impl<T: Scalar> Packs<'_, T> {
    /// Θ/2 and δ of a pack, and what they give.
    #[inline(always)]
    fn bend<S: Oct<T>>(&self, s: S, pack: usize) -> ([Lanes<T, S>; 2], Bent<Lanes<T, S>>) {
        let Rows { first: [a, b, c], second: [d, e, f] } = &self.rows[pack];
        let load = |pack| Lanes::load(s, pack);
        let rows = Rows { first: [load(a), load(b), load(c)], second: [load(d), load(e), load(f)] };
        let [w, x, y, z] = &self.others[pack];
        let others = [self.phi(s, w), self.phi(s, x), self.phi(s, y), self.phi(s, z)];
        let (half, turn) = (load(&self.half[pack]), load(&self.turns[pack]));
        ([half, turn], rows.bend(half, turn, others))
    }

    /// φ = Θ/2 ± δ of eight edges.
    #[inline(always)]
    fn phi<S: Oct<T>>(&self, s: S, sides: &[Side; ROWS]) -> Lanes<T, S> {
        let mut phi = [T::zero(); ROWS];
        for (phi, side) in phi.iter_mut().zip(sides) {
            let (pack, lane) = (side.edge() / ROWS, side.edge() % ROWS);
            let turn = self.turns[pack].0[lane];
            *phi = self.half[pack].0[lane] + if side.is_second() { -turn } else { turn };
        }
        Lanes::load(s, &Pack(phi))
    }
}

/// One Jacobi sweep over some packs.
pub(super) struct Sweep<'a, T> {
    pub packs: Packs<'a, T>,
    pub relaxation: &'a [Pack<T>],
    pub first: usize,
    pub out: &'a mut [Pack<T>],
}

impl<T: Scalar> RowKernel<T> for Sweep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        for (pack, out) in (self.first..).zip(self.out) {
            let ([_, turn], bent) = self.packs.bend(s, pack);
            *out = (turn - bent.residual() * Lanes::load(s, &self.relaxation[pack])).store();
        }
    }
}

/// The moments of some packs.
pub(super) struct Moments<'a, T> {
    pub packs: Packs<'a, T>,
    pub first: usize,
    pub out: &'a mut [Pack<T>],
}

impl<T: Scalar> RowKernel<T> for Moments<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        for (pack, out) in (self.first..).zip(self.out) {
            let (_, bent) = self.packs.bend(s, pack);
            *out = bent.moment().store();
        }
    }
}

/// The energy of some packs, J.
pub(super) struct EnergyOf<'a, T> {
    pub packs: Packs<'a, T>,
    pub range: Range<usize>,
}

impl<T: Scalar> RowKernel<T> for EnergyOf<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) -> f64 {
        let mut sum = 0.0;
        for pack in self.range {
            let ([half, turn], bent) = self.packs.bend(s, pack);
            sum += bent.energy(half, turn).store().sum();
        }
        sum
    }
}
