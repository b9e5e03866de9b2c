//! What is computed for eight edges at once.

use core::ops::Range;

use super::topology::Side;
use crate::physics::energy::mid_edge::{Bent, Rows};
use crate::physics::math::{Lanes, Oct, Pack, ROWS, RowKernel, Scalar};

/// φ of eight edges, in the first triangle of each and in the second, rad.
pub(in super::super) type Phi<T> = [Pack<T>; 2];

/// φ = σ Θ ± δ of eight edges with deviations Θ and the turns δ of another φ; `share` is σ of the first triangle.
#[inline(always)]
pub(in super::super) fn turned<T: Scalar, S: Oct<T>>(
    deviation: Lanes<T, S>,
    share: &Pack<T>,
    [first, second]: &Phi<T>,
) -> Phi<T> {
    let (share, first, second) = (deviation.like(share), deviation.like(first), deviation.like(second));
    let turn = first - share * (first + second);
    let first = share * deviation + turn;
    [first.store(), (deviation - first).store()]
}

/// Edges in packs.
#[derive(Clone, Copy)]
pub(super) struct Packs<'a, T> {
    pub rows: &'a [Rows<Pack<T>>],
    pub others: &'a [[[Side; ROWS]; 4]],
    pub phi: &'a [Phi<T>],
}

impl<T: Scalar> Packs<'_, T> {
    /// What φ of a pack and of the edges around give.
    #[inline(always)]
    fn bend<S: Oct<T>>(&self, s: S, pack: usize) -> Bent<Lanes<T, S>> {
        let Rows { first: [a, b, c], second: [d, e, f] } = &self.rows[pack];
        let load = |pack| Lanes::load(s, pack);
        let rows = Rows { first: [load(a), load(b), load(c)], second: [load(d), load(e), load(f)] };
        let [w, x, y, z] = &self.others[pack];
        let others = [self.gather(s, w), self.gather(s, x), self.gather(s, y), self.gather(s, z)];
        let [first, second] = &self.phi[pack];
        rows.bend([load(first), load(second)], others)
    }

    #[inline(always)]
    fn gather<S: Oct<T>>(&self, s: S, sides: &[Side; ROWS]) -> Lanes<T, S> {
        let mut phi = [T::zero(); ROWS];
        for (phi, side) in phi.iter_mut().zip(sides) {
            let (pack, place) = (side.place() / (2 * ROWS), side.place() % (2 * ROWS));
            *phi = self.phi[pack][place / ROWS].0[place % ROWS];
        }
        Lanes::load(s, &Pack(phi))
    }
}

/// One Jacobi sweep over some packs, and the moments before it.
pub(super) struct Sweep<'a, T> {
    pub packs: Packs<'a, T>,
    pub relaxation: &'a [Pack<T>],
    pub shares: &'a [Pack<T>],
    pub first: usize,
    pub phi: &'a mut [Phi<T>],
    pub moments: &'a mut [Pack<T>],
}

impl<T: Scalar> RowKernel<T> for Sweep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        for (pack, (phi, moment)) in (self.first..).zip(self.phi.iter_mut().zip(self.moments)) {
            let bent = self.packs.bend(s, pack);
            let [first, second] = bent.own;
            let turn = bent.residual() * Lanes::load(s, &self.relaxation[pack]);
            *phi = [(first - turn).store(), (second + turn).store()];
            *moment = bent.moment(Lanes::load(s, &self.shares[pack])).store();
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
            sum += self.packs.bend(s, pack).energy().store().sum();
        }
        sum
    }
}
