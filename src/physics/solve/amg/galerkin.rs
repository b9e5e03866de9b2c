//! The matrix of a coarser level, Pᵀ A P.
//!
//! With `A = D + L + Lᵀ` and `B = ½ D + L` it is `Pᵀ B P` and its transpose together. So for each row i of L the sums
//! `S(i, J) = Σⱼ B(i, j) P(j, J)` are made first, and `P(i, I) S(i, J)` then added at (I, J), or transposed at (J, I),
//! whichever is below the diagonal. All of that is laid out once, so that nothing is left to be decided for each matrix.

use std::sync::Arc;

use super::prolongation::{ENTRIES, Prolongation};
use crate::physics::assembly::parts::{ByGroup, ByPart, BySlice, Part, for_parts};
use crate::physics::assembly::{BlockCsr, BlockPattern, Group, Slicing};
use crate::physics::math::{M3, Oct, Pack, ROWS, RowKernel, Scalar};

/// What of the product depends on the patterns alone.
#[derive(Clone, Debug)]
pub(super) struct Galerkin<T: Scalar> {
    /// By row of A: starts of its parts of `terms` and of `targets`.
    starts: Vec<[u32; 2]>,
    /// Block by block, the diagonal first: which sum of the row each product with a weight belongs to.
    terms: Vec<[u16; ENTRIES]>,
    /// Sum by sum: where the products with the weights of the row go.
    targets: Vec<[Target; ENTRIES]>,
    /// Of the coarse matrix, filled side by side.
    pieces: Vec<Part>,
    /// The rows of A that each piece has to do with.
    rows: Vec<Vec<u32>>,
    /// The sums of a row, by piece.
    scratch: Vec<Vec<Sum<T>>>,
}

/// A sum as it is, transposed, and zero; while it is made, two parts of it.
type Sum<T> = [Block<T>; 3];

/// A block: its first eight entries, and the last.
#[derive(Clone, Copy, Debug)]
struct Block<T> {
    first: Pack<T>,
    last: T,
}

impl<T: Scalar> Block<T> {
    fn zero() -> Self {
        Self { first: Pack([T::zero(); ROWS]), last: T::zero() }
    }

    /// Adds a block times a weight.
    #[inline(always)]
    fn add_scaled<S: Oct<T>>(&mut self, s: S, (first, last): (S::V, T), weight: T) {
        self.first.0 = s.store(s.mul_add(first, s.splat(weight), s.load(&self.first.0)));
        self.last += last * weight;
    }
}

/// A slot of the coarse matrix, and which form of the sum goes there: its number is in the two highest bits.
#[derive(Clone, Copy, Debug)]
struct Target(u32);

impl Target {
    const AS_IT_IS: u32 = 0;
    const TRANSPOSED: u32 = 1;
    /// The product belongs on the diagonal.
    const ZERO: u32 = 2;
    const SLOT_BITS: u32 = 30;

    fn new(slot: u32, form: u32) -> Self {
        assert!(slot < 1 << Self::SLOT_BITS, "fewer than 2³⁰ blocks");
        Self(slot | form << Self::SLOT_BITS)
    }

    #[inline(always)]
    fn slot(self) -> usize {
        (self.0 & ((1 << Self::SLOT_BITS) - 1)) as usize
    }

    #[inline(always)]
    fn form(self) -> usize {
        (self.0 >> Self::SLOT_BITS) as usize % 3
    }
}

/// The columns J of the sums of a row of A, and by term which of them it belongs to.
fn sums_of_row<T: Scalar>(pattern: &BlockPattern, p: &Prolongation<T>, row: usize) -> (Vec<u32>, Vec<[u16; ENTRIES]>) {
    let others = pattern.row(row).map(|slot| p.row(pattern.column(slot) as usize).columns);
    let columns: Vec<_> = core::iter::once(p.row(row).columns).chain(others).collect();
    let mut sums = columns.concat();
    sums.sort_unstable();
    sums.dedup();
    let place = |column| {
        let place = sums.binary_search(&column).expect("each column has a sum");
        u16::try_from(place).expect("rows have fewer than 2¹⁶ blocks")
    };
    // Entries without a weight go where few others do.
    let spread = |columns: [u32; ENTRIES]| {
        let mut places = columns.map(place);
        for e in 1..ENTRIES {
            if columns[e] == columns[0] {
                places[e] = (e % sums.len()) as u16;
            }
        }
        places
    };
    let terms = columns.into_iter().map(spread).collect();
    (sums, terms)
}

/// Which unknowns of the result are coupled, each pair at least once, the larger first.
pub(super) fn couplings<T: Scalar>(pattern: &BlockPattern, p: &Prolongation<T>) -> impl Iterator<Item = [u32; 2]> {
    (0..pattern.row_count()).flat_map(|row| {
        let (sums, _) = sums_of_row(pattern, p, row);
        let columns = p.row(row).columns;
        sums.into_iter().flat_map(move |j| columns.map(|i| [i.max(j), i.min(j)]))
    })
}

impl<T: Scalar> Galerkin<T> {
    /// The product for matrices of `pattern`, and the pattern of the result, which is filled in pieces and swept over in parts that
    /// begin at these rows.
    pub fn new(
        pattern: &BlockPattern,
        p: &Prolongation<T>,
        coarse: usize,
        piece_starts: &[u32],
        part_starts: &[u32],
        slicing: Slicing,
    ) -> (Self, Arc<BlockPattern>) {
        let pairs: Vec<_> = couplings(pattern, p).collect();
        let coarse_pattern =
            BlockPattern::new(coarse, part_starts, slicing, pairs.iter().map(|pair| &pair[..]), core::iter::empty());
        let pieces = coarse_pattern.pieces(piece_starts);
        let piece_of = |row: u32| pieces.partition_point(|piece| piece.rows.end <= row as usize);

        let (mut starts, mut terms, mut targets, mut longest) = (vec![[0; 2]], Vec::new(), Vec::new(), 0);
        let mut rows = vec![Vec::new(); pieces.len()];
        for row in 0..pattern.row_count() {
            let own = p.row(row).columns;
            let (sums, terms_of_row) = sums_of_row(pattern, p, row);
            let pairs = own.iter().flat_map(|&i| sums.iter().map(move |&j| i.max(j)));
            let mut touched: Vec<_> = pairs.map(piece_of).collect();
            touched.sort_unstable();
            touched.dedup();
            touched.into_iter().for_each(|piece| rows[piece].push(row as u32));

            // Of an entry that belongs on the diagonal zero goes to any slot.
            let any =
                own.iter().zip(own.iter().cycle().skip(1)).find_map(|(&i, &j)| coarse_pattern.slot(i.max(j), i.min(j)));
            let target = |i: u32, j: u32| match coarse_pattern.slot(i.max(j), i.min(j)) {
                Some(slot) => Target::new(slot, if i > j { Target::AS_IT_IS } else { Target::TRANSPOSED }),
                None => Target::new(any.unwrap_or(0), Target::ZERO),
            };
            longest = longest.max(sums.len());
            targets.extend(sums.into_iter().map(|j| own.map(|i| target(i, j))));
            terms.extend(terms_of_row);
            starts.push([terms.len() as u32, targets.len() as u32]);
        }
        terms.shrink_to_fit();
        targets.shrink_to_fit();
        let scratch = vec![vec![[Block::zero(); 3]; longest]; pieces.len()];
        (Self { starts, terms, targets, pieces, rows, scratch }, Arc::new(coarse_pattern))
    }

    /// `coarse = Pᵀ A P`. Rows of A that are coupled with no others (pins) stay out: smoothing alone solves them.
    pub fn multiply(&mut self, a: &BlockCsr<T>, p: &Prolongation<T>, coarse: &mut BlockCsr<T>) {
        let Self { starts, terms, targets, pieces, rows, scratch } = self;
        let pattern = Arc::clone(coarse.pattern());
        let (diagonal, lower) = coarse.clear();
        let data = (diagonal, lower, ByPart(scratch));
        for_parts(pieces, data, &|part: &Part, (BySlice(diagonal), ByGroup(lower), ByPart(scratch))| {
            diagonal.fill(Group::zero());
            lower.fill(Group::zero());
            for sums in scratch {
                let (rows, coarse) = (&rows[part.index], &*pattern);
                let (diagonal, lower) = (&mut *diagonal, &mut *lower);
                T::dispatch(Multiply { starts, terms, targets, rows, a, p, coarse, part, diagonal, lower, sums });
            }
            // An aggregate of pins alone: nothing will ever be asked of it.
            for row in part.rows.clone() {
                let slot = pattern.diagonal(row);
                let group = &mut diagonal[slot / ROWS - part.slices.start];
                if group.block(slot % ROWS) == M3::zero() {
                    group.set_block(slot % ROWS, M3::scaled_identity(T::from_f64(1.0)));
                }
            }
        });
    }
}

struct Multiply<'a, T: Scalar> {
    starts: &'a [[u32; 2]],
    terms: &'a [[u16; ENTRIES]],
    targets: &'a [[Target; ENTRIES]],
    rows: &'a [u32],
    a: &'a BlockCsr<T>,
    p: &'a Prolongation<T>,
    coarse: &'a BlockPattern,
    part: &'a Part,
    diagonal: &'a mut [Group<T>],
    lower: &'a mut [Group<T>],
    sums: &'a mut [Sum<T>],
}

impl<T: Scalar> RowKernel<T> for Multiply<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Oct<T>>(self, s: S) {
        let Self { starts, terms, targets, rows, a, p, coarse, part, diagonal, lower, sums } = self;
        let pattern = &**a.pattern();
        for &row in rows {
            let row = row as usize;
            if a.fixed[row] {
                continue;
            }
            let ([term, target], [term_end, target_end]) = (starts[row].map(|n| n as usize), starts[row + 1]);
            let mut terms = terms[term..term_end as usize].iter();
            let targets = &targets[target..target_end as usize];
            let sums = &mut sums[..targets.len()];
            for [even, odd, _] in &mut *sums {
                (*even, *odd) = (Block::zero(), Block::zero());
            }
            let own = p.row(row);
            let own_places = terms.next().copied().unwrap_or_default();
            let (first, last) = a.diagonal_entries(s, row);
            for e in 0..ENTRIES {
                let half = T::from_f64(0.5) * own.weights[e];
                sums[usize::from(own_places[e])][0].add_scaled(s, (first, last), half);
            }
            for ((slot, places), i) in pattern.row(row).zip(terms).zip(1..) {
                let column = pattern.column(slot) as usize;
                if a.fixed[column] {
                    continue;
                }
                let (block, weights) = (a.entries(s, slot), p.row(column).weights);
                for e in 0..ENTRIES {
                    // Two sums in turn: one would have to wait for itself.
                    sums[usize::from(places[e])][i % 2].add_scaled(s, block, weights[e]);
                }
            }
            for (forms, targets) in sums.iter_mut().zip(targets) {
                let [even, odd, _] = *forms;
                let sum = s.add(s.load(&even.first.0), s.load(&odd.first.0));
                let last = even.last + odd.last;
                forms[Target::AS_IT_IS as usize] = Block { first: Pack(s.store(sum)), last };
                forms[Target::TRANSPOSED as usize] = Block { first: Pack(s.store(s.transpose_block(sum))), last };
                for e in 0..ENTRIES {
                    let (slot, weight) = (targets[e].slot(), own.weights[e]);
                    if let Some(group) = lower.get_mut((slot / ROWS).wrapping_sub(part.groups.start)) {
                        let Block { first, last } = &forms[targets[e].form()];
                        group.accumulate(s, slot % ROWS, s.mul(s.load(&first.0), s.splat(weight)), *last * weight);
                    }
                }
            }
            for e in 0..ENTRIES {
                let (slot, weight) = (coarse.diagonal(own.columns[e] as usize), own.weights[e]);
                if let Some(group) = diagonal.get_mut((slot / ROWS).wrapping_sub(part.slices.start)) {
                    let [sum, transposed, _] = &sums[usize::from(own_places[e])];
                    let both = s.add(s.load(&sum.first.0), s.load(&transposed.first.0));
                    let last = (sum.last + transposed.last) * weight;
                    group.accumulate(s, slot % ROWS, s.mul(both, s.splat(weight)), last);
                }
            }
        }
    }
}
