//! What every machine has: two quads.

use super::{Oct, ROWS};
use crate::physics::math::{Padded, Quad, Scalar};

/// SSE2 on x86-64, NEON on 64-bit ARM, otherwise what the compiler makes of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Baseline;

impl<T: Scalar> Oct<T> for Baseline {
    type V = [T::Quad; 2];

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
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        [c[0] + a[0] * b[0], c[1] + a[1] * b[1]]
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        [c[0] - a[0] * b[0], c[1] - a[1] * b[1]]
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
        [a, b, c, d, e, f, g, h].map(Padded)
    }
}
