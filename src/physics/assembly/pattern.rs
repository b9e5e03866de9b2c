//! Which blocks of the matrix exist, and where each is stored.
//!
//! Rows are worked on [`ROWS`] at a time, in [`Slice`]s: the blocks of a slice stand in groups, of one block for each row.
//! A row with fewer blocks than the longest of its slice is filled up with zeros (Kreutzer et al. 2014, SELL-C-σ).

use super::Part;
use crate::physics::math::ROWS;

/// Sparsity pattern of a symmetric matrix of 3×3 blocks: all diagonal blocks, and of the others the lower half. One of these has
/// a slot: the number of its group times [`ROWS`] plus the place of its row in the slice. That on the diagonal likewise, with
/// the number of the slice.
#[derive(Clone, Debug)]
pub struct BlockPattern {
    rows: Vec<Row>,
    /// By row: slot of the diagonal block.
    diagonals: Vec<u32>,
    slices: Vec<Slice>,
    /// By group.
    columns: Vec<[u32; ROWS]>,
    /// Likewise: whether row and column are neighbours.
    near: Vec<[bool; ROWS]>,
    parts: Vec<Part>,
    incoming: Vec<Crossing>,
}

/// No column.
const NONE: u32 = u32::MAX;

/// Where the blocks of a row are, besides that on the diagonal.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// Number of blocks whose column is in an earlier part.
    crossing: u32,
    /// Number of blocks whose column is in the same part.
    inner: u32,
    /// Slot of the first block of either kind, if it has any.
    first_crossing: u32,
    first_inner: u32,
}

/// Some successive rows of one part, and the groups that their blocks stand in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slice {
    /// The first row.
    pub first_row: u32,
    /// How many there are, at most [`ROWS`].
    pub rows: u32,
    /// The first group, of columns in earlier parts.
    pub crossing: u32,
    /// The first group of columns in the same part.
    pub inner: u32,
    /// The first group that is not of this slice.
    pub end: u32,
}

/// A block of which row and column belong to different parts, as the part of its column sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Its column.
    pub column: u32,
    /// Its row.
    pub row: u32,
    /// Its slot.
    pub slot: u32,
}

/// What makes rows share a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slicing {
    /// Successive rows of which none is coupled with another: a sweep of Gauss–Seidel may take them at once.
    Independent,
    /// Any successive rows, which takes the least memory: for matrices that are not swept over.
    Any,
}

impl BlockPattern {
    /// The pattern that couples all vertices of each element with each other: elements of `near` make them neighbours, those
    /// of `far` reach beyond. `part_starts` are the first rows of the parts: 0 and any others, ascending.
    ///
    /// # Panics
    /// If the elements name other vertices, or there are more than 2³² blocks.
    pub fn new<'a>(
        vertex_count: usize,
        part_starts: &[u32],
        slicing: Slicing,
        near: impl Iterator<Item = &'a [u32]>,
        far: impl Iterator<Item = &'a [u32]>,
    ) -> Self {
        let mut rows: Vec<Vec<(u32, bool)>> = vec![Vec::new(); vertex_count];
        let elements = near.map(|element| (element, false)).chain(far.map(|element| (element, true)));
        for (element, far) in elements {
            for &row in element {
                let left = element.iter().filter(|&&column| column < row);
                rows[row as usize].extend(left.map(|&column| (column, far)));
            }
        }
        for row in &mut rows {
            row.sort_unstable();
            // Where both are to be had, the near one comes first and stays.
            row.dedup_by_key(|(column, _)| *column);
        }

        let mut pattern = Self {
            rows: Vec::with_capacity(vertex_count),
            diagonals: Vec::with_capacity(vertex_count),
            slices: Vec::new(),
            columns: Vec::new(),
            near: Vec::new(),
            parts: Vec::new(),
            incoming: Vec::new(),
        };
        let ends = part_starts.iter().skip(1).copied().chain([vertex_count as u32]);
        for (&start, end) in part_starts.iter().zip(ends) {
            let (slices, groups) = (pattern.slices.len(), pattern.columns.len());
            let mut first = start;
            while first < end {
                let coupled = |&row: &u32| rows[row as usize].last().is_some_and(|&(column, _)| column >= first);
                let most = (end - first).min(ROWS as u32);
                let count = match slicing {
                    Slicing::Any => most,
                    Slicing::Independent => (first + 1..first + most).find(coupled).map_or(most, |row| row - first),
                };
                pattern.push_slice(start, first, &rows[first as usize..(first + count) as usize]);
                first += count;
            }
            pattern.parts.push(Part {
                index: pattern.parts.len(),
                rows: start as usize..end as usize,
                slices: slices..pattern.slices.len(),
                groups: groups..pattern.columns.len(),
                incoming: 0..0,
            });
        }
        assert!(u32::try_from(ROWS * pattern.columns.len()).is_ok(), "fewer than 2³² blocks");
        pattern.slices.shrink_to_fit();
        pattern.columns.shrink_to_fit();
        pattern.near.shrink_to_fit();
        pattern.find_incoming();
        pattern
    }

    /// Adds a slice of these rows, of the part that begins at `part_start`.
    fn push_slice(&mut self, part_start: u32, first_row: u32, rows: &[Vec<(u32, bool)>]) {
        let crossing = |row: &Vec<(u32, bool)>| row.partition_point(|&(column, _)| column < part_start);
        let crossing_groups = rows.iter().map(crossing).max().unwrap_or(0);
        let inner_groups = rows.iter().map(|row| row.len() - crossing(row)).max().unwrap_or(0);
        let first_crossing = self.columns.len();
        let inner = first_crossing + crossing_groups;
        let end = inner + inner_groups;
        self.columns.resize(end, [NONE; ROWS]);
        self.near.resize(end, [false; ROWS]);
        for (lane, row) in rows.iter().enumerate() {
            let crossing = crossing(row);
            let groups = (first_crossing..).take(crossing).chain(inner..);
            for (group, &(column, far)) in groups.zip(row) {
                self.columns[group][lane] = column;
                self.near[group][lane] = !far;
            }
            self.diagonals.push((ROWS * self.slices.len() + lane) as u32);
            self.rows.push(Row {
                crossing: crossing as u32,
                inner: (row.len() - crossing) as u32,
                first_crossing: (ROWS * first_crossing + lane) as u32,
                first_inner: (ROWS * inner + lane) as u32,
            });
        }
        // Where there is no block stands the column of another row, which a sweep knows already.
        for columns in &mut self.columns[first_crossing..] {
            let known = columns.iter().copied().find(|&column| column != NONE).unwrap_or(0);
            for column in columns.iter_mut().filter(|column| **column == NONE) {
                *column = known;
            }
        }
        self.slices.push(Slice {
            first_row,
            rows: rows.len() as u32,
            crossing: first_crossing as u32,
            inner: inner as u32,
            end: end as u32,
        });
    }

    fn find_incoming(&mut self) {
        let mut incoming = Vec::new();
        for row in 0..self.row_count() {
            let crossing = self.rows[row].crossing as usize;
            let slots = self.row(row).take(crossing);
            incoming.extend(slots.map(|slot| Crossing {
                column: self.column(slot),
                row: row as u32,
                slot: slot as u32,
            }));
        }
        incoming.sort_unstable_by_key(|crossing| (crossing.column, crossing.slot));
        for part in &mut self.parts {
            let before = |row: usize| incoming.partition_point(|c| (c.column as usize) < row);
            part.incoming = before(part.rows.start)..before(part.rows.end);
        }
        self.incoming = incoming;
    }

    /// Number of block rows: of vertices.
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Number of groups of [`ROWS`] blocks.
    pub fn group_count(&self) -> usize {
        self.columns.len()
    }

    /// Slots of the blocks of a row left of the diagonal, columns ascending.
    #[inline(always)]
    pub fn row(&self, row: usize) -> impl Iterator<Item = usize> + Clone {
        let Row { crossing, inner, first_crossing, first_inner } = self.rows[row];
        let slots = |first: u32, count: u32| (0..count as usize).map(move |i| first as usize + ROWS * i);
        slots(first_crossing, crossing).chain(slots(first_inner, inner))
    }

    /// Number of blocks of a row left of the diagonal.
    pub fn row_length(&self, row: usize) -> usize {
        self.rows[row].crossing as usize + self.rows[row].inner as usize
    }

    /// The column of a slot.
    #[inline(always)]
    pub fn column(&self, slot: usize) -> u32 {
        self.columns[slot / ROWS][slot % ROWS]
    }

    /// The columns of a group.
    #[inline(always)]
    pub fn columns(&self, group: usize) -> &[u32; ROWS] {
        &self.columns[group]
    }

    /// Slot of the diagonal block of a row.
    #[inline(always)]
    pub fn diagonal(&self, row: usize) -> usize {
        self.diagonals[row] as usize
    }

    /// Columns of a row, left of the diagonal, that are neighbours of it.
    pub fn near(&self, row: usize) -> impl Iterator<Item = u32> {
        self.row(row).filter(|slot| self.near[slot / ROWS][slot % ROWS]).map(|slot| self.column(slot))
    }

    /// The slices, in order.
    #[inline(always)]
    pub fn slices(&self) -> &[Slice] {
        &self.slices
    }

    /// The parts, in order.
    #[inline(always)]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The rows in pieces, each from the first slice that begins at or after one of these rows, to fill the matrix side by
    /// side. Unlike parts they may be coupled.
    pub fn pieces(&self, starts: &[u32]) -> Vec<Part> {
        let slice_at = |row: u32| self.slices.partition_point(|slice| slice.first_row < row);
        let end = Slice {
            first_row: self.row_count() as u32,
            rows: 0,
            crossing: self.group_count() as u32,
            inner: 0,
            end: 0,
        };
        let at = |slice: usize| self.slices.get(slice).copied().unwrap_or(end);
        let piece = |index: usize| {
            let slices = slice_at(starts[index])..starts.get(index + 1).map_or(self.slices.len(), |&row| slice_at(row));
            let (first, next) = (at(slices.start), at(slices.end));
            Part {
                index,
                rows: first.first_row as usize..next.first_row as usize,
                groups: first.crossing as usize..next.crossing as usize,
                slices,
                incoming: 0..0,
            }
        };
        (0..starts.len()).map(piece).collect()
    }

    /// The blocks whose column lies in an earlier part than their row, by column.
    #[inline(always)]
    pub fn incoming(&self) -> &[Crossing] {
        &self.incoming
    }

    /// Slot of the block at (`row`, `column`), if it is below the diagonal and the pattern has it.
    pub fn slot(&self, row: u32, column: u32) -> Option<u32> {
        let Row { crossing, inner, first_crossing, first_inner } = self.rows[row as usize];
        // Those of earlier parts come first. By halves: a row may have as many blocks as there are vertices.
        [(first_crossing, crossing), (first_inner, inner)].into_iter().find_map(|(first, count)| {
            let slot = |i: u32| first + ROWS as u32 * i;
            let (mut low, mut high) = (0, count);
            while low < high {
                let middle = low.midpoint(high);
                if self.column(slot(middle) as usize) < column { low = middle + 1 } else { high = middle }
            }
            (low < count && self.column(slot(low) as usize) == column).then(|| slot(low))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(vertices: usize, part_starts: &[u32], slicing: Slicing) -> BlockPattern {
        let elements: [&[u32]; 2] = [&[0, 1, 2], &[2, 1, 3]];
        BlockPattern::new(vertices, part_starts, slicing, elements.into_iter(), [&[0, 3][..]].into_iter())
    }

    fn columns(pattern: &BlockPattern, row: usize) -> Vec<u32> {
        pattern.row(row).map(|slot| pattern.column(slot)).collect()
    }

    #[test]
    fn pattern_couples_the_vertices_of_each_element() {
        let pattern = pattern(5, &[0], Slicing::Any);
        let rows: Vec<_> = (0..5).map(|row| columns(&pattern, row)).collect();
        assert_eq!(rows, [&[][..], &[0], &[0, 1], &[0, 1, 2], &[]]);
        assert_eq!((pattern.slot(3, 4), pattern.slot(2, 2)), (None, None));
        assert_eq!(pattern.slot(3, 2).map(|slot| pattern.column(slot as usize)), Some(2));
        assert_eq!(pattern.near(3).collect::<Vec<_>>(), [1, 2]);
        // One slice, of as many groups as the longest row has blocks.
        assert_eq!(pattern.slices(), [Slice { first_row: 0, rows: 5, crossing: 0, inner: 0, end: 3 }]);
        // Where there is no block stands the column of one that there is.
        assert_eq!(pattern.columns(2), &[2; ROWS]);
    }

    #[test]
    fn rows_of_a_slice_are_independent_if_they_are_to_be() {
        let pattern = pattern(7, &[0], Slicing::Independent);
        let slices: Vec<_> = pattern.slices().iter().map(|slice| (slice.first_row, slice.rows)).collect();
        assert_eq!(slices, [(0, 1), (1, 1), (2, 1), (3, 4)]);
    }

    #[test]
    fn pieces_are_the_whole_pattern_in_order() {
        let pattern = pattern(7, &[0], Slicing::Independent);
        let pieces = pattern.pieces(&[0, 2, 5]);
        let rows: Vec<_> = pieces.iter().map(|piece| piece.rows.clone()).collect();
        let slices: Vec<_> = pieces.iter().map(|piece| piece.slices.clone()).collect();
        // Row 5 is in the middle of a slice, so the last piece is empty.
        assert_eq!((rows, slices), (vec![0..2, 2..7, 7..7], vec![0..2, 2..4, 4..4]));
        assert_eq!([pieces[0].groups.start, pieces[1].groups.end], [0, pattern.group_count()]);
    }

    #[test]
    fn blocks_between_parts_are_known_to_both() {
        let pattern = pattern(5, &[0, 2], Slicing::Any);
        let rows: Vec<_> = pattern.parts().iter().map(|part| part.rows.clone()).collect();
        assert_eq!(rows, [0..2, 2..5]);
        assert_eq!((columns(&pattern, 2), columns(&pattern, 3)), (vec![0, 1], vec![0, 1, 2]));
        let slice = pattern.slices()[1];
        assert_eq!((slice.inner - slice.crossing, slice.end - slice.inner), (2, 1));
        let incoming: Vec<_> = pattern.incoming().iter().map(|c| (c.column, c.row)).collect();
        assert_eq!(incoming, [(0, 2), (0, 3), (1, 2), (1, 3)]);
        assert_eq!([&pattern.parts()[0].incoming, &pattern.parts()[1].incoming], [&(0..4), &(4..4)]);
        assert!(pattern.incoming().iter().all(|c| pattern.slot(c.row, c.column) == Some(c.slot)));
    }
}
