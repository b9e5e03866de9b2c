//! AVX2 and FMA.

use core::arch::x86_64::{__m128, __m256};

use pulp::bytemuck::cast;
use pulp::x86::V3;
use pulp::{Simd, WithSimd};

use super::{Oct, ROWS, RowKernel};
use crate::physics::math::Padded;

/// Runs a kernel with these instructions.
pub(super) fn run<K: RowKernel<f32>>(simd: V3, kernel: K) -> K::Output {
    Simd::vectorize(simd, Compiled { simd, kernel })
}

struct Compiled<K> {
    simd: V3,
    kernel: K,
}

impl<K: RowKernel<f32>> WithSimd for Compiled<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> K::Output {
        self.kernel.run(self.simd)
    }
}

/// The halves of a shuffle that takes two numbers of each operand: the first two, or the last two.
const FIRST: i32 = 0b01_00_01_00;
const LAST: i32 = 0b11_10_11_10;

impl Oct<f32> for V3 {
    type V = __m256;

    #[inline(always)]
    fn splat(self, value: f32) -> __m256 {
        self.avx._mm256_set1_ps(value)
    }
    #[inline(always)]
    fn load(self, from: &[f32; ROWS]) -> __m256 {
        cast(*from)
    }
    #[inline(always)]
    fn store(self, v: __m256) -> [f32; ROWS] {
        cast(v)
    }
    #[inline(always)]
    fn add(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_add_ps(a, b)
    }
    #[inline(always)]
    fn sub(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_sub_ps(a, b)
    }
    #[inline(always)]
    fn mul(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_mul_ps(a, b)
    }
    #[inline(always)]
    fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        self.fma._mm256_fmadd_ps(a, b, c)
    }
    #[inline(always)]
    fn mul_sub(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        self.fma._mm256_fnmadd_ps(a, b, c)
    }
    #[inline(always)]
    fn turn(self, rows: [Padded<f32>; ROWS]) -> [__m256; 3] {
        let avx = self.avx;
        let [a, b, c, d, e, f, g, h] = rows;
        let (a, b) = (pair(self, a, e), pair(self, b, f));
        let (c, d) = (pair(self, c, g), pair(self, d, h));
        let (ab, cd) = (avx._mm256_unpacklo_ps(a, b), avx._mm256_unpacklo_ps(c, d));
        let (ab_z, cd_z) = (avx._mm256_unpackhi_ps(a, b), avx._mm256_unpackhi_ps(c, d));
        // Four rows in either half.
        [
            avx._mm256_shuffle_ps::<FIRST>(ab, cd),
            avx._mm256_shuffle_ps::<LAST>(ab, cd),
            avx._mm256_shuffle_ps::<FIRST>(ab_z, cd_z),
        ]
    }
    #[inline(always)]
    fn turn_back(self, [x, y, z]: [__m256; 3]) -> [Padded<f32>; ROWS] {
        let avx = self.avx;
        let zero = avx._mm256_setzero_ps();
        let (xy, xy_high) = (avx._mm256_unpacklo_ps(x, y), avx._mm256_unpackhi_ps(x, y));
        let (zw, zw_high) = (avx._mm256_unpacklo_ps(z, zero), avx._mm256_unpackhi_ps(z, zero));
        let (a, e) = halves(self, avx._mm256_shuffle_ps::<FIRST>(xy, zw));
        let (b, f) = halves(self, avx._mm256_shuffle_ps::<LAST>(xy, zw));
        let (c, g) = halves(self, avx._mm256_shuffle_ps::<FIRST>(xy_high, zw_high));
        let (d, h) = halves(self, avx._mm256_shuffle_ps::<LAST>(xy_high, zw_high));
        [a, b, c, d, e, f, g, h]
    }
}

#[inline(always)]
fn pair(simd: V3, low: Padded<f32>, high: Padded<f32>) -> __m256 {
    simd.avx._mm256_set_m128(cast::<_, __m128>(high.0), cast::<_, __m128>(low.0))
}

#[inline(always)]
fn halves(simd: V3, both: __m256) -> (Padded<f32>, Padded<f32>) {
    let (low, high) = (simd.avx._mm256_castps256_ps128(both), simd.avx._mm256_extractf128_ps::<1>(both));
    (Padded(cast(low)), Padded(cast(high)))
}
