//! Eight rows at once: how the linear solver's inner loops go through a matrix.
//!
//! Vectors keep 3 numbers and a zero side by side ([`Padded`]); eight of them are turned into eight x, eight y and eight z,
//! to be multiplied with eight blocks whose entries lie side by side.

// AVX-512 is left alone: with its registers sweeps gain a little and the coarse matrices lose as much.
#[cfg(target_arch = "x86_64")]
mod avx2;
mod baseline;

use super::{Padded, Scalar};

/// Rows worked on at once.
pub const ROWS: usize = 8;

/// Arithmetic on eight numbers side by side in one instruction set.
pub trait Oct<T: Scalar>: Copy + Send + Sync + 'static {
    /// Eight numbers.
    type V: Copy + Send + Sync + 'static;
    /// The same instruction set in f64.
    type Wide: Oct<f64>;

    /// The same instruction set in f64.
    fn wide(self) -> Self::Wide;
    /// Rounds to this precision.
    fn narrow(self, wide: <Self::Wide as Oct<f64>>::V) -> Self::V;
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
    /// a / b.
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    /// c + a b.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c − a b.
    fn mul_sub(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// √a.
    fn sqrt(self, a: Self::V) -> Self::V;
    /// `yes` where a > b, `no` elsewhere.
    fn if_greater(self, a: Self::V, b: Self::V, yes: Self::V, no: Self::V) -> Self::V;
    /// `yes` where this bit is set, `no` elsewhere.
    fn if_bit(self, bits: &[u8; ROWS], bit: u32, yes: Self::V, no: Self::V) -> Self::V;
    /// Eight vectors as eight x, eight y and eight z.
    fn turn(self, rows: [Padded<T>; ROWS]) -> [Self::V; 3];
    /// The opposite of [`Oct::turn`].
    fn turn_back(self, xyz: [Self::V; 3]) -> [Padded<T>; ROWS];
    /// Number j of vector i becomes number i of vector j.
    fn transpose(self, rows: [Self::V; ROWS]) -> [Self::V; ROWS];
    /// The first eight entries of a 3×3 block, by columns instead of rows.
    fn transpose_block(self, first: Self::V) -> Self::V;
}

/// A computation over eight rows at once, compiled once for each instruction set. `run` and what it calls in its hot loops
/// must be `#[inline(always)]`: only what is inlined is compiled anew.
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
        return avx2::run_f32(simd, kernel);
    }
    kernel.run(baseline::Baseline)
}

/// Runs a kernel in its version for this machine, in f64.
pub(super) fn dispatch_f64<K: RowKernel<f64>>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return avx2::run_f64(simd, kernel);
    }
    kernel.run(baseline::Baseline)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors turned, put through every operation with their own coordinates, and turned back; and numbers transposed.
    #[derive(Clone, Copy)]
    struct Through<T: Scalar>([Padded<T>; ROWS]);

    type Seen<T> = ([Padded<T>; ROWS], [Padded<T>; ROWS], [[T; ROWS]; ROWS]);

    impl<T: Scalar> RowKernel<T> for Through<T> {
        type Output = Seen<T>;

        #[inline(always)]
        fn run<S: Oct<T>>(self, s: S) -> Seen<T> {
            let [x, y, z] = s.turn(self.0);
            let two = s.load(&s.store(s.splat(T::from_f64(2.0))));
            let sums = [s.sub(s.mul_add(x, y, z), two), s.mul_sub(y, z, x), s.add(s.mul(two, z), x)];
            let bits = [0, 4, 0, 4, 7, 3, 4, 0];
            let others = [s.div(s.sqrt(x), two), s.if_greater(x, z, y, z), s.if_bit(&bits, 2, x, y)];
            let row = |i: usize| s.load(&core::array::from_fn(|j| T::from_f64((10 * i + j) as f64)));
            let mut transposed = s.transpose(core::array::from_fn(row)).map(|row| s.store(row));
            transposed[7] = s.store(s.transpose_block(row(1)));
            (s.turn_back(sums), s.turn_back(others), transposed)
        }
    }

    fn expected<T: Scalar>(rows: [[f64; 3]; ROWS]) -> Seen<T> {
        let sums = rows.map(|[x, y, z]| [z + x * y - 2.0, x - y * z, 2.0 * z + x]);
        let of = |i: usize| {
            let [x, y, z] = rows[i];
            [0.5 * x.sqrt(), if x > z { y } else { z }, if [1, 3, 4, 6].contains(&i) { x } else { y }]
        };
        let mut transposed = core::array::from_fn(|i| core::array::from_fn(|j| T::from_f64((10 * j + i) as f64)));
        transposed[7] = [10.0, 13.0, 16.0, 11.0, 14.0, 17.0, 12.0, 15.0].map(T::from_f64);
        (sums.map(Padded::from_f64), core::array::from_fn(|i| Padded::from_f64(of(i))), transposed)
    }

    #[test]
    fn every_instruction_set_computes_the_same() {
        // Squares, so that roots are exact.
        let rows = core::array::from_fn(|i| [(i * i) as f64, 1.0 - 2.0 * i as f64, 4.5 * i as f64]);
        let single = Through(rows.map(Padded::<f32>::from_f64));
        let double = Through(rows.map(Padded::<f64>::from_f64));
        assert_eq!(dispatch_f32(single), expected(rows));
        assert_eq!(single.run(baseline::Baseline), expected(rows));
        assert_eq!(dispatch_f64(double), expected(rows));
        assert_eq!(double.run(baseline::Baseline), expected(rows));
    }

    struct Narrowed([f64; ROWS]);

    impl<T: Scalar> RowKernel<T> for Narrowed {
        type Output = [T; ROWS];

        #[inline(always)]
        fn run<S: Oct<T>>(self, s: S) -> [T; ROWS] {
            s.store(s.narrow(s.wide().load(&self.0)))
        }
    }

    #[test]
    fn every_instruction_set_rounds_alike() {
        let values = [0.1, -1e-3, 1e10, 0.0, 7.7, 1.0 / 3.0, -5.5, 2.0];
        assert_eq!(dispatch_f32(Narrowed(values)), values.map(|v| v as f32));
        assert_eq!(RowKernel::<f32>::run(Narrowed(values), baseline::Baseline), values.map(|v| v as f32));
        assert_eq!(dispatch_f64(Narrowed(values)), values);
    }
}
