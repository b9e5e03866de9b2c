//! What every machine has: two quads.

use super::{Oct, ROWS};
use crate::physics::math::{Padded, Quad, Scalar};

/// SSE2 on x86-64, NEON on 64-bit ARM, otherwise what the compiler makes of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Baseline;

impl<T: Scalar> Oct<T> for Baseline {
    type V = [T::Quad; 2];
    type Wide = Self;

    #[inline(always)]
    fn wide(self) -> Self {
        self
    }
    #[inline(always)]
    fn narrow(self, wide: <Self as Oct<f64>>::V) -> Self::V {
        let mut narrow = [T::zero(); ROWS];
        for (narrow, wide) in narrow.iter_mut().zip(Oct::<f64>::store(self, wide)) {
            *narrow = T::from_f64(wide);
        }
        self.load(&narrow)
    }
    #[inline(always)]
    fn splat(self, value: T) -> Self::V {
        [T::Quad::new([value; 4]); 2]
    }
    #[inline(always)]
    fn load(self, &[a, b, c, d, e, f, g, h]: &[T; ROWS]) -> Self::V {
        [T::Quad::new([a, b, c, d]), T::Quad::new([e, f, g, h])]
    }
    #[inline(always)]
    fn store(self, [low, high]: Self::V) -> [T; ROWS] {
        let ([a, b, c, d], [e, f, g, h]) = (low.lanes(), high.lanes());
        [a, b, c, d, e, f, g, h]
    }
    #[inline(always)]
    fn add(self, a: Self::V, b: Self::V) -> Self::V {
        [a[0] + b[0], a[1] + b[1]]
    }
    #[inline(always)]
    fn sub(self, a: Self::V, b: Self::V) -> Self::V {
        [a[0] - b[0], a[1] - b[1]]
    }
    #[inline(always)]
    fn mul(self, a: Self::V, b: Self::V) -> Self::V {
        [a[0] * b[0], a[1] * b[1]]
    }
    #[inline(always)]
    fn div(self, a: Self::V, b: Self::V) -> Self::V {
        [a[0] / b[0], a[1] / b[1]]
    }
    #[inline(always)]
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        [c[0] + a[0] * b[0], c[1] + a[1] * b[1]]
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        [c[0] - a[0] * b[0], c[1] - a[1] * b[1]]
    }
    #[inline(always)]
    fn sqrt(self, a: Self::V) -> Self::V {
        [a[0].sqrt(), a[1].sqrt()]
    }
    #[inline(always)]
    fn if_greater(self, a: Self::V, b: Self::V, yes: Self::V, no: Self::V) -> Self::V {
        [a[0].if_greater(b[0], yes[0], no[0]), a[1].if_greater(b[1], yes[1], no[1])]
    }
    #[inline(always)]
    fn if_bit(self, bits: &[u8; ROWS], bit: u32, yes: Self::V, no: Self::V) -> Self::V {
        let mut set = [T::zero(); ROWS];
        for (set, bits) in set.iter_mut().zip(bits) {
            *set = T::from_f64(f64::from(bits >> bit & 1));
        }
        Oct::<T>::if_greater(self, self.load(&set), self.splat(T::zero()), yes, no)
    }
    #[inline(always)]
    fn turn(self, [a, b, c, d, e, f, g, h]: [Padded<T>; ROWS]) -> [Self::V; 3] {
        let [x0, y0, z0, _] = T::Quad::transpose([a.0, b.0, c.0, d.0]);
        let [x1, y1, z1, _] = T::Quad::transpose([e.0, f.0, g.0, h.0]);
        [[x0, x1], [y0, y1], [z0, z1]]
    }
    #[inline(always)]
    fn turn_back(self, [x, y, z]: [Self::V; 3]) -> [Padded<T>; ROWS] {
        let zero = T::Quad::new([T::zero(); 4]);
        let [a, b, c, d] = T::Quad::transpose([x[0], y[0], z[0], zero]);
        let [e, f, g, h] = T::Quad::transpose([x[1], y[1], z[1], zero]);
        [Padded(a), Padded(b), Padded(c), Padded(d), Padded(e), Padded(f), Padded(g), Padded(h)]
    }
    #[inline(always)]
    fn transpose(self, rows: [Self::V; ROWS]) -> [Self::V; ROWS] {
        let [r0, r1, r2, r3, r4, r5, r6, r7] = rows;
        let [a0, a1, a2, a3] = T::Quad::transpose([r0[0], r1[0], r2[0], r3[0]]);
        let [b0, b1, b2, b3] = T::Quad::transpose([r4[0], r5[0], r6[0], r7[0]]);
        let [c0, c1, c2, c3] = T::Quad::transpose([r0[1], r1[1], r2[1], r3[1]]);
        let [d0, d1, d2, d3] = T::Quad::transpose([r4[1], r5[1], r6[1], r7[1]]);
        [[a0, b0], [a1, b1], [a2, b2], [a3, b3], [c0, d0], [c1, d1], [c2, d2], [c3, d3]]
    }
    #[inline(always)]
    fn transpose_block(self, first: Self::V) -> Self::V {
        let [a, b, c, d, e, f, g, h]: [T; ROWS] = self.store(first);
        self.load(&[a, d, g, b, e, h, c, f])
    }
}
