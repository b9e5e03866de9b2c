//! Four lanes at once, which every machine has: the unit of the linear solver's inner loops.
//!
//! Matrices keep their 3×3 blocks as 9 numbers in a row, vectors keep 3 numbers and a fourth that is zero.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

use wide::{f32x4, f64x4};

use super::{M3, Scalar, V3};

/// Four numbers side by side.
pub trait Quad<T>:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// From its lanes.
    fn new(lanes: [T; 4]) -> Self;
    /// Its lanes.
    fn lanes(self) -> [T; 4];
    /// The first lanes of four, the second ones, and so on.
    fn transpose(four: [Self; 4]) -> [Self; 4];
    /// Square roots.
    fn sqrt(self) -> Self;
    /// `yes` where `self` > `other`, `no` elsewhere.
    fn if_greater(self, other: Self, yes: Self, no: Self) -> Self;
}

macro_rules! impl_quad {
    ($quad:ty, $t:ty) => {
        impl Quad<$t> for $quad {
            #[inline(always)]
            fn new(lanes: [$t; 4]) -> Self {
                <$quad>::new(lanes)
            }
            #[inline(always)]
            fn lanes(self) -> [$t; 4] {
                self.to_array()
            }
            #[inline(always)]
            fn transpose(four: [Self; 4]) -> [Self; 4] {
                <$quad>::transpose(four)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$quad>::sqrt(self)
            }
            #[inline(always)]
            fn if_greater(self, other: Self, yes: Self, no: Self) -> Self {
                self.simd_gt(other).select(yes, no)
            }
        }
    };
}

impl_quad!(f32x4, f32);
impl_quad!(f64x4, f64);

/// A 3-vector in four lanes, of which the last one is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Padded<T: Scalar>(pub T::Quad);

impl<T: Scalar> Padded<T> {
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::new([T::zero(); 3])
    }

    /// From its components.
    #[inline(always)]
    pub fn new([x, y, z]: [T; 3]) -> Self {
        Self(T::Quad::new([x, y, z, T::zero()]))
    }

    /// Its components.
    #[inline(always)]
    pub fn v3(self) -> V3<T> {
        let [x, y, z, _] = self.0.lanes();
        V3([x, y, z])
    }

    /// Rounds to this precision.
    #[inline(always)]
    pub fn from_f64(v: [f64; 3]) -> Self {
        Self::new([T::from_f64(v[0]), T::from_f64(v[1]), T::from_f64(v[2])])
    }

    /// Widens to f64.
    #[inline(always)]
    pub fn to_f64(self) -> [f64; 3] {
        self.v3().to_f64()
    }

    /// Dot product in f64.
    #[inline(always)]
    pub fn dot_f64(self, other: Self) -> f64 {
        self.v3().dot_f64(other.v3())
    }

    /// The same with zero in the last lane, whatever was there.
    #[inline(always)]
    fn truncated(self) -> Self {
        Self::new(self.v3().0)
    }
}

impl<T: Scalar> Add for Padded<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0)
    }
}

impl<T: Scalar> Sub for Padded<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0)
    }
}

impl<T: Scalar> Mul<T> for Padded<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: T) -> Self {
        Self(self.0 * T::Quad::new([s; 4]))
    }
}

impl<T: Scalar> AddAssign for Padded<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<T: Scalar> SubAssign for Padded<T> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

/// Four successive numbers of a block.
#[inline(always)]
fn quad<T: Scalar, const FROM: usize>(block: &M3<T>) -> T::Quad {
    T::Quad::new(*block.0.as_flattened()[FROM..].first_chunk().expect("a block has 9 numbers"))
}

/// `Σ B x` under way, over blocks B and vectors x: products by entry, which are added up along the rows at the end.
#[derive(Clone, Copy, Debug)]
pub struct RowSums<T: Scalar>([T::Quad; 3]);

impl<T: Scalar> RowSums<T> {
    /// Nothing yet.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([Padded::<T>::zero().0; 3])
    }

    /// Adds `B x`.
    #[inline(always)]
    pub fn add(&mut self, block: &M3<T>, x: Padded<T>) {
        let [x0, x1, x2, _] = x.0.lanes();
        let [a, b, c] = &mut self.0;
        // The last row begins a number early, so as not to reach beyond the block: its first lane does not count.
        *a = *a + quad::<T, 0>(block) * x.0;
        *b = *b + quad::<T, 3>(block) * x.0;
        *c = *c + quad::<T, 5>(block) * T::Quad::new([x0, x0, x1, x2]);
    }

    /// The sum.
    #[inline(always)]
    pub fn total(self) -> Padded<T> {
        let [a, b, c] = self.0;
        let (a, b, c) = (a.lanes(), b.lanes(), c.lanes());
        let zero = T::zero();
        Padded(
            T::Quad::new([a[0], b[0], c[1], zero])
                + T::Quad::new([a[1], b[1], c[2], zero])
                + T::Quad::new([a[2], b[2], c[3], zero]),
        )
    }
}

impl<T: Scalar> M3<T> {
    /// `B x`, for one block alone.
    #[inline(always)]
    pub fn times(&self, x: Padded<T>) -> Padded<T> {
        let mut sums = RowSums::zero();
        sums.add(self, x);
        sums.total()
    }

    /// `Bᵀ x`, for one block alone.
    #[inline(always)]
    pub fn transposed_times(&self, x: Padded<T>) -> Padded<T> {
        let [x0, x1, x2, _] = x.0.lanes();
        let [_, c0, c1, c2] = (quad::<T, 5>(self) * T::Quad::new([x2; 4])).lanes();
        let rows = quad::<T, 0>(self) * T::Quad::new([x0; 4]) + quad::<T, 3>(self) * T::Quad::new([x1; 4]);
        Padded(rows + T::Quad::new([c0, c1, c2, T::zero()])).truncated()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: M3<f32> = M3([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 10.0]]);
    const X: [f32; 3] = [0.5, -2.0, 3.0];

    #[test]
    fn products_agree_with_those_of_a_plain_matrix() {
        let x = Padded::new(X);
        assert_eq!(A.times(x).v3(), A.mul_vector(V3(X)));
        assert_eq!(A.transposed_times(x).v3(), A.transpose().mul_vector(V3(X)));
        let mut sums = RowSums::zero();
        sums.add(&A, x);
        sums.add(&A.transpose(), x);
        assert_eq!(sums.total(), Padded::new((A.mul_vector(V3(X)) + A.transpose().mul_vector(V3(X))).0));
        assert_eq!(A.transposed_times(x).0.lanes()[3], 0.0);
    }
}
