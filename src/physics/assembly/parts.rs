//! A matrix in parts, which are worked on side by side.
//!
//! Where the parts begin depends on the mesh alone, each part writes what is its own, and sums over parts are added up in
//! one order: so the result is the same to the last bit for any number of threads.

use core::ops::Range;

use bevy::math::DVec3;

/// A contiguous part of the rows of a matrix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which one it is.
    pub index: usize,
    /// Its rows.
    pub rows: Range<usize>,
    /// The slices of these rows.
    pub slices: Range<usize>,
    /// The groups of blocks of these slices.
    pub groups: Range<usize>,
    /// Which of [`BlockPattern::incoming`](super::BlockPattern::incoming) concern its rows.
    pub incoming: Range<usize>,
}

/// How much the first of two pieces holds.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Parts.
    pub parts: usize,
    /// Rows in them.
    pub rows: usize,
    /// Slices in them.
    pub slices: usize,
    /// Groups in them.
    pub groups: usize,
}

/// What can be cut where a part ends.
pub trait Split: Sized + Send {
    /// Cuts.
    fn split(self, cut: Cut) -> (Self, Self);
}

impl Split for () {
    #[inline]
    fn split(self, _: Cut) -> (Self, Self) {
        ((), ())
    }
}

/// One entry per row.
impl<T: Send> Split for &mut [T] {
    #[inline]
    fn split(self, cut: Cut) -> (Self, Self) {
        self.split_at_mut(cut.rows)
    }
}

macro_rules! split_by {
    ($(#[$doc:meta] $name:ident, $count:ident;)+) => {
        $(
            #[$doc]
            #[derive(Debug)]
            pub struct $name<'a, T>(pub &'a mut [T]);

            impl<T: Send> Split for $name<'_, T> {
                #[inline]
                fn split(self, cut: Cut) -> (Self, Self) {
                    let (a, b) = self.0.split_at_mut(cut.$count);
                    (Self(a), Self(b))
                }
            }
        )+
    };
}

split_by! {
    /// One entry per group.
    ByGroup, groups;
    /// One entry per slice.
    BySlice, slices;
    /// One entry per part.
    ByPart, parts;
}

macro_rules! split_tuple {
    ($($name:ident)+) => {
        impl<$($name: Split),+> Split for ($($name,)+) {
            #[inline]
            #[expect(non_snake_case, reason = "named as their types")]
            fn split(self, cut: Cut) -> (Self, Self) {
                let ($($name,)+) = self;
                $(let $name = $name.split(cut);)+
                (($($name.0,)+), ($($name.1,)+))
            }
        }
    };
}

split_tuple!(A B);
split_tuple!(A B C);
split_tuple!(A B C D);

/// What parts report, taken together.
pub trait Merge: Send {
    /// Takes two together.
    fn merge(self, other: Self) -> Self;
}

impl Merge for () {
    #[inline]
    fn merge(self, (): Self) {}
}

impl Merge for f64 {
    #[inline]
    fn merge(self, other: Self) -> Self {
        self + other
    }
}

impl Merge for DVec3 {
    #[inline]
    fn merge(self, other: Self) -> Self {
        self + other
    }
}

impl Merge for bool {
    #[inline]
    fn merge(self, other: Self) -> Self {
        self && other
    }
}

impl<const N: usize> Merge for [f64; N] {
    #[inline]
    fn merge(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i] + other[i])
    }
}

/// Runs `work` on each part and its piece of the data, side by side if the current thread pool allows.
pub fn for_parts<S: Split, R: Merge>(parts: &[Part], data: S, work: &(impl Fn(&Part, S) -> R + Sync)) -> R {
    if let [part] = parts {
        return work(part, data);
    }
    let (before, after) = parts.split_at(parts.len() / 2);
    let (first, second) = data.split(Cut {
        parts: before.len(),
        rows: after[0].rows.start - before[0].rows.start,
        slices: after[0].slices.start - before[0].slices.start,
        groups: after[0].groups.start - before[0].groups.start,
    });
    let (a, b) = join(|| for_parts(before, first, work), || for_parts(after, second, work));
    a.merge(b)
}

/// Runs `work`, in the current thread pool if the parts can gain from that: entering it once costs less than with each
/// [`for_parts`].
pub fn in_pool<R: Send>(parts: usize, work: impl FnOnce() -> R + Send) -> R {
    #[cfg(feature = "parallel")]
    if parts > 1 && rayon::current_num_threads() > 1 {
        return rayon::scope(|_| work());
    }
    #[cfg(not(feature = "parallel"))]
    let _ = parts;
    work()
}

#[cfg(feature = "parallel")]
fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    if rayon::current_num_threads() > 1 { rayon::join(a, b) } else { (a(), b()) }
}

#[cfg(not(feature = "parallel"))]
fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_gets_its_own_rows_slices_and_groups() {
        let part = |index, rows, slices, groups| Part { index, rows, slices, groups, incoming: 0..0 };
        let parts = [part(0, 0..2, 0..1, 0..1), part(1, 2..5, 1..3, 1..4), part(2, 5..6, 3..4, 4..4)];
        let (mut rows, mut slices, mut groups) = ([0; 6], [0; 4], [0; 4]);
        let data = (&mut rows[..], BySlice(&mut slices[..]), ByGroup(&mut groups[..]));
        let sum = for_parts(&parts, data, &|part: &Part, (rows, BySlice(slices), ByGroup(groups))| {
            let lengths = (part.rows.len(), part.slices.len(), part.groups.len());
            assert_eq!((rows.len(), slices.len(), groups.len()), lengths);
            for piece in [&mut *rows, slices, groups] {
                piece.fill(part.index);
            }
            rows.len() as f64
        });
        assert_eq!((rows, slices, groups, sum), ([0, 0, 1, 1, 1, 2], [0, 1, 1, 2], [0, 1, 1, 1], 6.0));
    }
}
