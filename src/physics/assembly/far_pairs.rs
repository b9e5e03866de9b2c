//! Pairs of rows that are coupled by a scalar, a multiple of the identity.
//!
//! These are the vertices opposite an edge, which bending alone couples (`bending_hessian`). A block for each would double the
//! matrix. They stand beside it, in both rows, so that each row is summed up on its own.

use core::ops::Range;

/// Which pairs there are. An entry is a row with one of its columns, so each pair has two.
#[derive(Clone, Debug)]
pub struct FarPairs {
    /// By row: its first entry.
    starts: Vec<u32>,
    /// By entry.
    columns: Vec<u32>,
}

impl FarPairs {
    /// All pairs of vertices of an element, but those that have a block, of a row and a smaller column.
    ///
    /// # Panics
    /// If the elements name other vertices, or there are 2³² entries or more.
    pub(super) fn new<'a>(
        vertex_count: usize,
        elements: impl Iterator<Item = &'a [u32]>,
        has_block: impl Fn(u32, u32) -> bool,
    ) -> Self {
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); vertex_count];
        for element in elements {
            for &row in element {
                let far = |&&column: &&u32| column != row && !has_block(row.max(column), row.min(column));
                rows[row as usize].extend(element.iter().filter(far));
            }
        }
        let (mut starts, mut columns) = (Vec::with_capacity(vertex_count + 1), Vec::new());
        starts.push(0);
        for mut row in rows {
            row.sort_unstable();
            row.dedup();
            columns.extend(row);
            starts.push(u32::try_from(columns.len()).expect("fewer than 2³² entries"));
        }
        columns.shrink_to_fit();
        Self { starts, columns }
    }

    /// Number of entries: twice that of pairs.
    pub fn entry_count(&self) -> usize {
        self.columns.len()
    }

    /// The entries of a row, columns ascending.
    #[inline(always)]
    pub fn row(&self, row: usize) -> Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    /// The column of an entry.
    #[inline(always)]
    pub fn column(&self, entry: usize) -> u32 {
        self.columns[entry]
    }

    /// The columns of some entries.
    #[inline(always)]
    pub fn columns(&self, entries: Range<usize>) -> &[u32] {
        &self.columns[entries]
    }

    /// The entry of a row and a column, if there is one.
    pub fn entry(&self, row: usize, column: u32) -> Option<usize> {
        let entries = self.row(row);
        let place = self.columns[entries.clone()].binary_search(&column).ok()?;
        Some(entries.start + place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_without_a_block_stands_in_both_rows() {
        let elements: [&[u32]; 2] = [&[0, 1, 3], &[3, 2, 0]];
        let far = FarPairs::new(4, elements.into_iter(), |row, column| (row, column) != (3, 0) && row != 2);
        let rows: Vec<_> = (0..4).map(|row| far.columns(far.row(row)).to_vec()).collect();
        assert_eq!(rows, [vec![2, 3], vec![], vec![0], vec![0]]);
        assert_eq!((far.entry(0, 3), far.entry(3, 0), far.entry(1, 0)), (Some(1), Some(3), None));
        assert_eq!((far.entry_count(), far.column(1)), (4, 3));
    }
}
