//! Which blocks of the matrix exist.

use core::ops::Range;

use super::Part;

/// Sparsity pattern of a symmetric matrix of 3×3 blocks: all diagonal blocks, and of the others the lower half, by rows,
/// columns ascending.
#[derive(Clone, Debug)]
pub struct BlockPattern {
    row_starts: Vec<u32>,
    columns: Vec<u32>,
    /// By slot: whether its row and column are neighbours.
    near: Vec<bool>,
    /// By row: the first slot of a column in the same part.
    own_starts: Vec<u32>,
    parts: Vec<Part>,
    incoming: Vec<Crossing>,
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

impl BlockPattern {
    /// The pattern that couples all vertices of each element with each other: elements of `near` make them neighbours, those
    /// of `far` reach beyond. `part_starts` are the first rows of the parts: 0 and any others, ascending.
    ///
    /// # Panics
    /// If the elements name other vertices, or there are more than 2³² blocks.
    pub fn new<'a>(
        vertex_count: usize,
        part_starts: &[u32],
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
        let (mut row_starts, mut columns, mut near) = (vec![0], Vec::new(), Vec::new());
        for mut row in rows {
            row.sort_unstable();
            // Where both are to be had, the near one comes first and stays.
            row.dedup_by_key(|(column, _)| *column);
            columns.extend(row.iter().map(|&(column, _)| column));
            near.extend(row.iter().map(|&(_, far)| !far));
            row_starts.push(u32::try_from(columns.len()).expect("fewer than 2³² blocks"));
        }
        columns.shrink_to_fit();
        near.shrink_to_fit();

        let mut pattern =
            Self { row_starts, columns, near, own_starts: Vec::new(), parts: Vec::new(), incoming: Vec::new() };
        let ends = part_starts.iter().skip(1).copied().chain([vertex_count as u32]);
        for (&start, end) in part_starts.iter().zip(ends) {
            let rows = start as usize..end as usize;
            let slots = pattern.row_starts[rows.start] as usize..pattern.row_starts[rows.end] as usize;
            for row in rows.clone() {
                let range = pattern.row(row);
                let crossing = pattern.columns[range.clone()].partition_point(|&column| column < start);
                pattern.own_starts.push((range.start + crossing) as u32);
                pattern.incoming.extend((range.start..range.start + crossing).map(|slot| Crossing {
                    column: pattern.columns[slot],
                    row: row as u32,
                    slot: slot as u32,
                }));
            }
            let index = pattern.parts.len();
            pattern.parts.push(Part { index, rows, slots, incoming: 0..0 });
        }
        pattern.incoming.sort_unstable_by_key(|crossing| (crossing.column, crossing.slot));
        for part in &mut pattern.parts {
            let before = |row: usize| pattern.incoming.partition_point(|c| (c.column as usize) < row);
            part.incoming = before(part.rows.start)..before(part.rows.end);
        }
        pattern
    }

    /// Number of block rows: of vertices.
    pub fn row_count(&self) -> usize {
        self.row_starts.len() - 1
    }

    /// Number of blocks below the diagonal.
    pub fn lower_count(&self) -> usize {
        self.columns.len()
    }

    /// Slots of the blocks of a row left of the diagonal.
    #[inline(always)]
    pub fn row(&self, row: usize) -> Range<usize> {
        self.row_starts[row] as usize..self.row_starts[row + 1] as usize
    }

    /// The same, those of columns in an earlier part apart from those in the part of the row.
    #[inline(always)]
    pub fn row_in_parts(&self, row: usize) -> (Range<usize>, Range<usize>) {
        let (all, own) = (self.row(row), self.own_starts[row] as usize);
        (all.start..own, own..all.end)
    }

    /// Columns of all blocks, by slot.
    #[inline(always)]
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// Columns of a row, left of the diagonal, that are neighbours of it.
    pub fn near(&self, row: usize) -> impl Iterator<Item = u32> {
        let range = self.row(row);
        let all = self.columns[range.clone()].iter().zip(&self.near[range]);
        all.filter(|(_, near)| **near).map(|(&column, _)| column)
    }

    /// The parts, in order.
    #[inline(always)]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The blocks whose column lies in an earlier part than their row, by column.
    #[inline(always)]
    pub fn incoming(&self) -> &[Crossing] {
        &self.incoming
    }

    /// Slot of the block at (`row`, `column`), if it is below the diagonal and the pattern has it.
    pub fn slot(&self, row: u32, column: u32) -> Option<u32> {
        let range = self.row(row as usize);
        let start = range.start;
        self.columns[range].binary_search(&column).ok().map(|i| (start + i) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pattern_couples_the_vertices_of_each_element() {
        let elements: [&[u32]; 2] = [&[0, 1, 2], &[2, 1, 3]];
        let pattern = BlockPattern::new(5, &[0], elements.into_iter(), [&[0, 3][..]].into_iter());
        let rows: Vec<&[u32]> = (0..5).map(|row| &pattern.columns()[pattern.row(row)]).collect();
        assert_eq!(rows, [&[][..], &[0], &[0, 1], &[0, 1, 2], &[]]);
        assert_eq!((pattern.slot(3, 4), pattern.slot(2, 2), pattern.slot(3, 2)), (None, None, Some(5)));
        assert_eq!(pattern.near(3).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(pattern.parts(), [Part { index: 0, rows: 0..5, slots: 0..6, incoming: 0..0 }]);
    }

    #[test]
    fn blocks_between_parts_are_known_to_both() {
        let elements: [&[u32]; 2] = [&[0, 1, 2], &[2, 1, 3]];
        let pattern = BlockPattern::new(5, &[0, 2], elements.into_iter(), core::iter::empty());
        let part = |index, rows, slots, incoming| Part { index, rows, slots, incoming };
        assert_eq!(pattern.parts(), [part(0, 0..2, 0..1, 0..3), part(1, 2..5, 1..5, 3..3)]);
        assert_eq!(pattern.row_in_parts(2), (1..3, 3..3));
        assert_eq!(pattern.row_in_parts(3), (3..4, 4..5));
        let incoming: Vec<_> = pattern.incoming().iter().map(|c| (c.column, c.row, c.slot)).collect();
        assert_eq!(incoming, [(0, 2, 1), (1, 2, 2), (1, 3, 3)]);
    }
}
