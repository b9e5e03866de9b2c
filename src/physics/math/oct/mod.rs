//! Eight rows at once: how the linear solver's inner loops go through a matrix.
//!
//! Vectors keep 3 numbers and a zero side by side ([`Padded`]); eight of them are turned into eight x, eight y and eight z,
//! to be multiplied with eight blocks whose entries lie side by side.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod baseline;

use super::{Kernel, Padded, Scalar};

/// Rows worked on at once.
pub const ROWS: usize = 8;

/// Arithmetic on eight numbers side by side in one instruction set.
pub trait Oct<T: Scalar>: Copy {
    /// Eight numbers.
    type V: Copy;

    /// The same number eight times.
    fn splat(self, value: T) -> Self::V;
    /// From memory.
    fn load(self, from: &[T; ROWS]) -> Self::V;
    /// To memory.
    fn store(self, v: Self::V) -> [T; ROWS];
    /// a + b.
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// a − b.
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b.
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// c + a b.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c − a b.
    fn mul_sub(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// Eight vectors as eight x, eight y and eight z.
    fn turn(self, rows: [Padded<T>; ROWS]) -> [Self::V; 3];
    /// The opposite of [`Oct::turn`].
    fn turn_back(self, xyz: [Self::V; 3]) -> [Padded<T>; ROWS];
}

/// A computation over eight rows at once, compiled once for each instruction set. As with [`Kernel`], `run` and what it
/// calls in its hot loops must be `#[inline(always)]`.
pub trait RowKernel<T: Scalar> {
    /// What it computes.
    type Output;
    /// Computes it.
    fn run<S: Oct<T>>(self, s: S) -> Self::Output;
}

/// Runs a kernel in its version for this machine, in f32.
pub(super) fn dispatch_f32<K: RowKernel<f32>>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return avx2::run(simd, kernel);
    }
    kernel.run(baseline::Baseline)
}

/// Runs a kernel in f64: of the reference, not of the fast path.
pub(super) fn dispatch_f64<K: RowKernel<f64>>(kernel: K) -> K::Output {
    super::dispatch(OnBaseline(kernel))
}

struct OnBaseline<K>(K);

impl<K: RowKernel<f64>> Kernel for OnBaseline<K> {
    type Output = K::Output;

    #[inline(always)]
    fn run(self) -> K::Output {
        self.0.run(baseline::Baseline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors turned, put through every operation with their own coordinates, and turned back.
    struct Through<T: Scalar>([Padded<T>; ROWS]);

    impl<T: Scalar> RowKernel<T> for Through<T> {
        type Output = [Padded<T>; ROWS];

        #[inline(always)]
        fn run<S: Oct<T>>(self, s: S) -> Self::Output {
            let [x, y, z] = s.turn(self.0);
            let two = s.load(&s.store(s.splat(T::splat(2.0))));
            s.turn_back([s.sub(s.mul_add(x, y, z), two), s.mul_sub(y, z, x), s.add(s.mul(two, z), x)])
        }
    }

    #[test]
    fn every_instruction_set_computes_the_same() {
        let vector = |i: usize| [i as f64, 1.0 - 2.0 * i as f64, 0.5 * i as f64];
        let expected = |i: usize| {
            let [x, y, z] = vector(i);
            [z + x * y - 2.0, x - y * z, 2.0 * z + x]
        };
        let rows = core::array::from_fn(|i| Padded::<f32>::from_f64(vector(i)));
        let rows_f64 = core::array::from_fn(|i| Padded::<f64>::from_f64(vector(i)));
        for (i, row) in dispatch_f32(Through(rows)).into_iter().enumerate() {
            assert_eq!(row, Padded::from_f64(expected(i)));
            assert_eq!(Through(rows).run(baseline::Baseline)[i], row);
            assert_eq!(dispatch_f64(Through(rows_f64))[i], Padded::from_f64(expected(i)));
        }
    }
}
