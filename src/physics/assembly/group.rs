//! The blocks of eight rows, one of each.

use crate::physics::math::{M3, Oct, Quad, ROWS, Scalar};

/// Entries of a block.
const ENTRIES: usize = 9;

/// [`ROWS`] blocks: one after the other while they are added to, or entry by entry once interleaved.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Group<T>([T; ENTRIES * ROWS]);

impl<T: Scalar> Group<T> {
    /// Zero blocks.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([T::zero(); ENTRIES * ROWS])
    }

    /// One of the blocks.
    #[inline(always)]
    pub fn block(&self, lane: usize) -> M3<T> {
        let [a, b, c, d, e, f, g, h, i] = *self.0[ENTRIES * lane..].first_chunk().expect("a block has 9 entries");
        M3([[a, b, c], [d, e, f], [g, h, i]])
    }

    /// Changes one of the blocks.
    #[inline(always)]
    pub fn set_block(&mut self, lane: usize, block: M3<T>) {
        self.0[ENTRIES * lane..][..ENTRIES].copy_from_slice(block.0.as_flattened());
    }

    /// The first eight entries of one of the blocks, and the last.
    #[inline(always)]
    pub fn entries<S: Oct<T>>(&self, s: S, lane: usize) -> (S::V, T) {
        let entries: &[T; ENTRIES] = self.0[ENTRIES * lane..].first_chunk().expect("a block has 9 entries");
        let [a, b, c, d, e, f, g, h, last] = *entries;
        (s.load(&[a, b, c, d, e, f, g, h]), last)
    }

    /// Adds to one of the blocks: to its first eight entries, and to the last.
    #[inline(always)]
    pub fn accumulate<S: Oct<T>>(&mut self, s: S, lane: usize, first: S::V, last: T) {
        let entries: &mut [T; ENTRIES] = self.0[ENTRIES * lane..].first_chunk_mut().expect("a block has 9 entries");
        if let Some((entries, end)) = entries.split_first_chunk_mut::<ROWS>() {
            *entries = s.store(s.add(s.load(entries), first));
            end[0] += last;
        }
    }

    /// Brings the entries of all blocks side by side.
    #[inline(always)]
    pub fn interleave(&mut self) {
        let old = self.0;
        for lane in [0, 4] {
            for entry in [0, 4] {
                let first = ENTRIES * lane + entry;
                let quads = [
                    quad(&old, first),
                    quad(&old, first + ENTRIES),
                    quad(&old, first + 2 * ENTRIES),
                    quad(&old, first + 3 * ENTRIES),
                ];
                for (i, quad) in T::Quad::transpose(quads).into_iter().enumerate() {
                    self.0[ROWS * (entry + i) + lane..][..4].copy_from_slice(&quad.lanes());
                }
            }
        }
        for lane in 0..ROWS {
            self.0[ROWS * (ENTRIES - 1) + lane] = old[ENTRIES * lane + ENTRIES - 1];
        }
    }

    /// One of the blocks, interleaved.
    #[inline(always)]
    pub fn interleaved_block(&self, lane: usize) -> M3<T> {
        let mut block = M3::zero();
        for (entry, value) in block.0.as_flattened_mut().iter_mut().enumerate() {
            *value = self.0[ROWS * entry + lane];
        }
        block
    }

    /// An entry of all blocks, interleaved.
    #[inline(always)]
    fn entry(&self, row: usize, column: usize) -> &[T; ROWS] {
        self.0[ROWS * (3 * row + column)..].first_chunk().expect("there are so many rows")
    }

    /// A row of entries, interleaved.
    #[inline(always)]
    fn row<S: Oct<T>>(&self, s: S, row: usize) -> [S::V; 3] {
        [s.load(self.entry(row, 0)), s.load(self.entry(row, 1)), s.load(self.entry(row, 2))]
    }

    /// `sum + B x`, block by block.
    #[inline(always)]
    pub fn mul_add<S: Oct<T>>(&self, s: S, [x, y, z]: [S::V; 3], mut sum: [S::V; 3]) -> [S::V; 3] {
        for (row, sum) in sum.iter_mut().enumerate() {
            let [a, b, c] = self.row(s, row);
            *sum = s.mul_add(c, z, s.mul_add(b, y, s.mul_add(a, x, *sum)));
        }
        sum
    }

    /// `sum − B x`, block by block.
    #[inline(always)]
    pub fn mul_sub<S: Oct<T>>(&self, s: S, [x, y, z]: [S::V; 3], mut sum: [S::V; 3]) -> [S::V; 3] {
        for (row, sum) in sum.iter_mut().enumerate() {
            let [a, b, c] = self.row(s, row);
            *sum = s.mul_sub(c, z, s.mul_sub(b, y, s.mul_sub(a, x, *sum)));
        }
        sum
    }

    /// `Bᵀ x`, block by block.
    #[inline(always)]
    pub fn transposed_mul<S: Oct<T>>(&self, s: S, [x, y, z]: [S::V; 3]) -> [S::V; 3] {
        let ([a, b, c], [d, e, f], [g, h, i]) = (self.row(s, 0), self.row(s, 1), self.row(s, 2));
        [
            s.mul_add(g, z, s.mul_add(d, y, s.mul(a, x))),
            s.mul_add(h, z, s.mul_add(e, y, s.mul(b, x))),
            s.mul_add(i, z, s.mul_add(f, y, s.mul(c, x))),
        ]
    }
}

/// Four successive entries.
#[inline(always)]
fn quad<T: Scalar>(entries: &[T], first: usize) -> T::Quad {
    T::Quad::new(*entries[first..].first_chunk().expect("four entries"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::math::{Padded, RowKernel, V3};

    fn block(lane: usize) -> M3<f32> {
        M3(core::array::from_fn(|r| core::array::from_fn(|c| (100 * lane + 10 * r + c) as f32)))
    }

    /// Adds to each block what another group has in its place.
    struct Sums<'a>(&'a mut Group<f32>, &'a Group<f32>);

    impl RowKernel<f32> for Sums<'_> {
        type Output = ();

        #[inline(always)]
        fn run<S: Oct<f32>>(self, s: S) {
            for lane in 0..ROWS {
                let (first, last) = self.1.entries(s, lane);
                self.0.accumulate(s, lane, first, last);
            }
        }
    }

    #[test]
    fn blocks_are_kept_added_to_and_interleaved() {
        let (mut group, mut other) = (Group::zero(), Group::zero());
        for lane in 0..ROWS {
            group.set_block(lane, block(lane));
            other.set_block(lane, block(1));
        }
        f32::dispatch(Sums(&mut group, &other));
        for lane in 0..ROWS {
            assert_eq!(group.block(lane), block(lane) + block(1));
        }
        group.interleave();
        for lane in 0..ROWS {
            assert_eq!(group.interleaved_block(lane), block(lane) + block(1));
        }
        assert_eq!(*group.entry(1, 2), core::array::from_fn(|lane| (100 * lane + 12 + 112) as f32));
    }

    /// x + B x, x − B x and Bᵀ x.
    struct Products<'a>(&'a Group<f32>, [Padded<f32>; ROWS]);

    impl RowKernel<f32> for Products<'_> {
        type Output = [[Padded<f32>; ROWS]; 3];

        #[inline(always)]
        fn run<S: Oct<f32>>(self, s: S) -> Self::Output {
            let x = s.turn(self.1);
            let [sum, rest] = [self.0.mul_add(s, x, x), self.0.mul_sub(s, x, x)];
            [s.turn_back(sum), s.turn_back(rest), s.turn_back(self.0.transposed_mul(s, x))]
        }
    }

    #[test]
    fn products_are_those_of_each_block() {
        let mut group = Group::zero();
        (0..ROWS).for_each(|lane| group.set_block(lane, block(lane)));
        group.interleave();
        let x = |lane: usize| V3([1.0, -2.0, lane as f32]);
        let products = f32::dispatch(Products(&group, core::array::from_fn(|lane| Padded::new(x(lane).0))));
        for lane in 0..ROWS {
            let product = block(lane).mul_vector(x(lane));
            let expected = [x(lane) + product, x(lane) - product, block(lane).transpose().mul_vector(x(lane))];
            assert_eq!(products.map(|rows| rows[lane].v3()), expected);
        }
    }
}
