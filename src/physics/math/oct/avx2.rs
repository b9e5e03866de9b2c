//! AVX2 and FMA.

use core::arch::x86_64::{__m128, __m128i, __m256, __m256d};

use pulp::bytemuck::cast;
use pulp::x86::V3;
use pulp::{Simd, WithSimd};

use super::{Oct, ROWS, RowKernel};
use crate::physics::math::Padded;

/// Runs a kernel with these instructions, in f32.
pub(super) fn run_f32<K: RowKernel<f32>>(simd: V3, kernel: K) -> K::Output {
    Simd::vectorize(simd, Single { simd, kernel })
}

/// Runs a kernel with these instructions, in f64.
pub(super) fn run_f64<K: RowKernel<f64>>(simd: V3, kernel: K) -> K::Output {
    Simd::vectorize(simd, Double { simd, kernel })
}

struct Single<K> {
    simd: V3,
    kernel: K,
}

impl<K: RowKernel<f32>> WithSimd for Single<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> K::Output {
        self.kernel.run(self.simd)
    }
}

struct Double<K> {
    simd: V3,
    kernel: K,
}

impl<K: RowKernel<f64>> WithSimd for Double<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> K::Output {
        self.kernel.run(self.simd)
    }
}

/// The halves of a shuffle that takes two numbers of each operand: the first two, or the last two.
const FIRST: i32 = 0b01_00_01_00;
const LAST: i32 = 0b11_10_11_10;
/// The low halves, or the high halves, of two operands.
const LOW: i32 = 0x20;
const HIGH: i32 = 0x31;
/// Greater, false for NaN, without a signal.
const GREATER: i32 = 30;

impl Oct<f32> for V3 {
    type V = __m256;
    type Wide = Self;

    #[inline(always)]
    fn wide(self) -> Self {
        self
    }
    #[inline(always)]
    fn narrow(self, [low, high]: [__m256d; 2]) -> __m256 {
        self.avx._mm256_set_m128(self.avx._mm256_cvtpd_ps(high), self.avx._mm256_cvtpd_ps(low))
    }
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
    fn div(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_div_ps(a, b)
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
    fn sqrt(self, a: __m256) -> __m256 {
        self.avx._mm256_sqrt_ps(a)
    }
    #[inline(always)]
    fn if_greater(self, a: __m256, b: __m256, yes: __m256, no: __m256) -> __m256 {
        self.avx._mm256_blendv_ps(no, yes, self.avx._mm256_cmp_ps::<GREATER>(a, b))
    }
    #[inline(always)]
    fn if_bit(self, bits: &[u8; ROWS], bit: u32, yes: __m256, no: __m256) -> __m256 {
        // The bit goes to the sign, which is what a blend looks at.
        let lanes = self.avx2._mm256_cvtepu8_epi32(bytes(self, bits));
        let sign = self.avx2._mm256_sllv_epi32(lanes, self.avx._mm256_set1_epi32(31 - bit as i32));
        self.avx._mm256_blendv_ps(no, yes, cast(sign))
    }
    #[inline(always)]
    fn turn(self, [a, b, c, d, e, f, g, h]: [Padded<f32>; ROWS]) -> [__m256; 3] {
        let avx = self.avx;
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
        let [ae, bf, cg, dh] = transpose_halves(self, [x, y, z, self.avx._mm256_setzero_ps()]);
        let ((a, e), (b, f)) = (halves(self, ae), halves(self, bf));
        let ((c, g), (d, h)) = (halves(self, cg), halves(self, dh));
        [a, b, c, d, e, f, g, h]
    }
    #[inline(always)]
    fn transpose(self, [a, b, c, d, e, f, g, h]: [__m256; ROWS]) -> [__m256; ROWS] {
        let avx = self.avx;
        let [p0, p1, p2, p3] = transpose_halves(self, [a, b, c, d]);
        let [q0, q1, q2, q3] = transpose_halves(self, [e, f, g, h]);
        [
            avx._mm256_permute2f128_ps::<LOW>(p0, q0),
            avx._mm256_permute2f128_ps::<LOW>(p1, q1),
            avx._mm256_permute2f128_ps::<LOW>(p2, q2),
            avx._mm256_permute2f128_ps::<LOW>(p3, q3),
            avx._mm256_permute2f128_ps::<HIGH>(p0, q0),
            avx._mm256_permute2f128_ps::<HIGH>(p1, q1),
            avx._mm256_permute2f128_ps::<HIGH>(p2, q2),
            avx._mm256_permute2f128_ps::<HIGH>(p3, q3),
        ]
    }
    #[inline(always)]
    fn transpose_block(self, first: __m256) -> __m256 {
        self.avx2._mm256_permutevar8x32_ps(first, self.avx._mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5))
    }
}

impl Oct<f64> for V3 {
    type V = [__m256d; 2];
    type Wide = Self;

    #[inline(always)]
    fn wide(self) -> Self {
        self
    }
    #[inline(always)]
    fn narrow(self, wide: [__m256d; 2]) -> [__m256d; 2] {
        wide
    }
    #[inline(always)]
    fn splat(self, value: f64) -> [__m256d; 2] {
        [self.avx._mm256_set1_pd(value); 2]
    }
    #[inline(always)]
    fn load(self, from: &[f64; ROWS]) -> [__m256d; 2] {
        cast(*from)
    }
    #[inline(always)]
    fn store(self, v: [__m256d; 2]) -> [f64; ROWS] {
        cast(v)
    }
    #[inline(always)]
    fn add(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        [self.avx._mm256_add_pd(a[0], b[0]), self.avx._mm256_add_pd(a[1], b[1])]
    }
    #[inline(always)]
    fn sub(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        [self.avx._mm256_sub_pd(a[0], b[0]), self.avx._mm256_sub_pd(a[1], b[1])]
    }
    #[inline(always)]
    fn mul(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        [self.avx._mm256_mul_pd(a[0], b[0]), self.avx._mm256_mul_pd(a[1], b[1])]
    }
    #[inline(always)]
    fn div(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        [self.avx._mm256_div_pd(a[0], b[0]), self.avx._mm256_div_pd(a[1], b[1])]
    }
    #[inline(always)]
    fn mul_add(self, a: [__m256d; 2], b: [__m256d; 2], c: [__m256d; 2]) -> [__m256d; 2] {
        [self.fma._mm256_fmadd_pd(a[0], b[0], c[0]), self.fma._mm256_fmadd_pd(a[1], b[1], c[1])]
    }
    #[inline(always)]
    fn mul_sub(self, a: [__m256d; 2], b: [__m256d; 2], c: [__m256d; 2]) -> [__m256d; 2] {
        [self.fma._mm256_fnmadd_pd(a[0], b[0], c[0]), self.fma._mm256_fnmadd_pd(a[1], b[1], c[1])]
    }
    #[inline(always)]
    fn sqrt(self, a: [__m256d; 2]) -> [__m256d; 2] {
        [self.avx._mm256_sqrt_pd(a[0]), self.avx._mm256_sqrt_pd(a[1])]
    }
    #[inline(always)]
    fn if_greater(self, a: [__m256d; 2], b: [__m256d; 2], yes: [__m256d; 2], no: [__m256d; 2]) -> [__m256d; 2] {
        let avx = self.avx;
        [
            avx._mm256_blendv_pd(no[0], yes[0], avx._mm256_cmp_pd::<GREATER>(a[0], b[0])),
            avx._mm256_blendv_pd(no[1], yes[1], avx._mm256_cmp_pd::<GREATER>(a[1], b[1])),
        ]
    }
    #[inline(always)]
    fn if_bit(self, bits: &[u8; ROWS], bit: u32, yes: [__m256d; 2], no: [__m256d; 2]) -> [__m256d; 2] {
        let (all, places) = (bytes(self, bits), self.avx._mm256_set1_epi64x(63 - i64::from(bit)));
        let low = self.avx2._mm256_cvtepu8_epi64(all);
        let high = self.avx2._mm256_cvtepu8_epi64(self.sse2._mm_srli_si128::<4>(all));
        [
            self.avx._mm256_blendv_pd(no[0], yes[0], cast(self.avx2._mm256_sllv_epi64(low, places))),
            self.avx._mm256_blendv_pd(no[1], yes[1], cast(self.avx2._mm256_sllv_epi64(high, places))),
        ]
    }
    #[inline(always)]
    fn turn(self, [a, b, c, d, e, f, g, h]: [Padded<f64>; ROWS]) -> [[__m256d; 2]; 3] {
        let [x0, y0, z0] = turn_four(self, [a, b, c, d]);
        let [x1, y1, z1] = turn_four(self, [e, f, g, h]);
        [[x0, x1], [y0, y1], [z0, z1]]
    }
    #[inline(always)]
    fn turn_back(self, [x, y, z]: [[__m256d; 2]; 3]) -> [Padded<f64>; ROWS] {
        let zero = self.avx._mm256_setzero_pd();
        let [a, b, c, d] = transpose_four(self, [x[0], y[0], z[0], zero]);
        let [e, f, g, h] = transpose_four(self, [x[1], y[1], z[1], zero]);
        cast::<[__m256d; ROWS], [wide::f64x4; ROWS]>([a, b, c, d, e, f, g, h]).map(Padded)
    }
    #[inline(always)]
    fn transpose(self, [a, b, c, d, e, f, g, h]: [[__m256d; 2]; ROWS]) -> [[__m256d; 2]; ROWS] {
        let [p0, p1, p2, p3] = transpose_four(self, [a[0], b[0], c[0], d[0]]);
        let [q0, q1, q2, q3] = transpose_four(self, [e[0], f[0], g[0], h[0]]);
        let [r0, r1, r2, r3] = transpose_four(self, [a[1], b[1], c[1], d[1]]);
        let [s0, s1, s2, s3] = transpose_four(self, [e[1], f[1], g[1], h[1]]);
        [[p0, q0], [p1, q1], [p2, q2], [p3, q3], [r0, s0], [r1, s1], [r2, s2], [r3, s3]]
    }
    #[inline(always)]
    fn transpose_block(self, first: [__m256d; 2]) -> [__m256d; 2] {
        let [a, b, c, d, e, f, g, h]: [f64; ROWS] = self.store(first);
        self.load(&[a, d, g, b, e, h, c, f])
    }
}

#[inline(always)]
fn bytes(simd: V3, bits: &[u8; ROWS]) -> __m128i {
    simd.sse2._mm_set_epi64x(0, i64::from_le_bytes(*bits))
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

/// Transposes the first four and the last four numbers of four vectors.
#[inline(always)]
fn transpose_halves(simd: V3, [a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
    let avx = simd.avx;
    let (ab, ab_high) = (avx._mm256_unpacklo_ps(a, b), avx._mm256_unpackhi_ps(a, b));
    let (cd, cd_high) = (avx._mm256_unpacklo_ps(c, d), avx._mm256_unpackhi_ps(c, d));
    [
        avx._mm256_shuffle_ps::<FIRST>(ab, cd),
        avx._mm256_shuffle_ps::<LAST>(ab, cd),
        avx._mm256_shuffle_ps::<FIRST>(ab_high, cd_high),
        avx._mm256_shuffle_ps::<LAST>(ab_high, cd_high),
    ]
}

#[inline(always)]
fn turn_four(simd: V3, [a, b, c, d]: [Padded<f64>; 4]) -> [__m256d; 3] {
    let [x, y, z, _] = transpose_four(simd, [cast(a.0), cast(b.0), cast(c.0), cast(d.0)]);
    [x, y, z]
}

#[inline(always)]
fn transpose_four(simd: V3, [a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
    let avx = simd.avx;
    let (ab_even, ab_odd) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
    let (cd_even, cd_odd) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
    [
        avx._mm256_permute2f128_pd::<LOW>(ab_even, cd_even),
        avx._mm256_permute2f128_pd::<LOW>(ab_odd, cd_odd),
        avx._mm256_permute2f128_pd::<HIGH>(ab_even, cd_even),
        avx._mm256_permute2f128_pd::<HIGH>(ab_odd, cd_odd),
    ]
}
