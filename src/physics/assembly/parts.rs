//! A matrix in parts, which are worked on side by side.
//!
//! Where the parts begin depends on the mesh alone, each part writes what is its own, and sums over parts are added up in
//! one order: so the result is the same to the last bit for any number of threads.

use core::ops::Range;

/// A contiguous part of the rows of a matrix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which one it is.
    pub index: usize,
    /// Its rows.
    pub rows: Range<usize>,
    /// Slots of the blocks of these rows.
    pub slots: Range<usize>,
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
    /// Slots in them.
    pub slots: usize,
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

/// One entry per slot.
#[derive(Debug)]
pub struct BySlot<'a, T>(pub &'a mut [T]);

impl<T: Send> Split for BySlot<'_, T> {
    #[inline]
    fn split(self, cut: Cut) -> (Self, Self) {
        let (a, b) = self.0.split_at_mut(cut.slots);
        (Self(a), Self(b))
    }
}

/// One entry per part.
#[derive(Debug)]
pub struct ByPart<'a, T>(pub &'a mut [T]);

impl<T: Send> Split for ByPart<'_, T> {
    #[inline]
    fn split(self, cut: Cut) -> (Self, Self) {
        let (a, b) = self.0.split_at_mut(cut.parts);
        (Self(a), Self(b))
    }
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
        slots: after[0].slots.start - before[0].slots.start,
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
    fn each_part_gets_its_own_rows_and_slots() {
        let part = |index, rows: Range<usize>, slots| Part { index, rows, slots, incoming: 0..0 };
        let parts = [part(0, 0..2, 0..1), part(1, 2..5, 1..4), part(2, 5..6, 4..4)];
        let (mut rows, mut slots) = ([0; 6], [0; 4]);
        let sum = for_parts(&parts, (&mut rows[..], BySlot(&mut slots[..])), &|part: &Part, (rows, slots)| {
            assert_eq!((rows.len(), slots.0.len()), (part.rows.len(), part.slots.len()));
            rows.fill(part.rows.start);
            slots.0.fill(part.rows.start);
            rows.len() as f64
        });
        assert_eq!((rows, slots, sum), ([0, 0, 2, 2, 2, 5], [0, 2, 2, 2], 6.0));
    }
}
