//! The blocks of eight rows, one of each.

use crate::physics::math::{Flat, M3, Oct, Quad, ROWS, Scalar};

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

    /// Adds to one of the blocks.
    #[inline(always)]
    pub fn add(&mut self, lane: usize, block: Flat<T>) {
        let entries: &mut [T; ENTRIES] = self.0[ENTRIES * lane..].first_chunk_mut().expect("a block has 9 entries");
        let [a, b, c, d, e, f, g, h, i] = *entries;
        let first = (T::Quad::new([a, b, c, d]) + block.0).lanes();
        let second = (T::Quad::new([e, f, g, h]) + block.1).lanes();
        entries[0..4].copy_from_slice(&first);
        entries[4..8].copy_from_slice(&second);
        entries[8] = i + block.2;
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

    /// `sum + B x`, block by block.
    #[inline(always)]
    pub fn mul_add<S: Oct<T>>(&self, s: S, x: [S::V; 3], mut sum: [S::V; 3]) -> [S::V; 3] {
        for row in 0..3 {
            for column in 0..3 {
                sum[row] = s.mul_add(s.load(self.entry(row, column)), x[column], sum[row]);
            }
        }
        sum
    }

    /// `sum − B x`, block by block.
    #[inline(always)]
    pub fn mul_sub<S: Oct<T>>(&self, s: S, x: [S::V; 3], mut sum: [S::V; 3]) -> [S::V; 3] {
        for row in 0..3 {
            for column in 0..3 {
                sum[row] = s.mul_sub(s.load(self.entry(row, column)), x[column], sum[row]);
            }
        }
        sum
    }

    /// `Bᵀ x`, block by block.
    #[inline(always)]
    pub fn transposed_mul<S: Oct<T>>(&self, s: S, x: [S::V; 3]) -> [S::V; 3] {
        let mut sum = [s.splat(T::zero()); 3];
        for column in 0..3 {
            let first = s.mul(s.load(self.entry(0, column)), x[0]);
            let second = s.mul_add(s.load(self.entry(1, column)), x[1], first);
            sum[column] = s.mul_add(s.load(self.entry(2, column)), x[2], second);
        }
        sum
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

    #[test]
    fn blocks_are_kept_added_to_and_interleaved() {
        let mut group = Group::zero();
        for lane in 0..ROWS {
            group.set_block(lane, block(lane));
            group.add(lane, block(1).flat());
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
