//! Which blocks of the matrix exist.

/// Sparsity pattern of a symmetric matrix of 3×3 blocks, by rows, columns ascending, both halves stored.
#[derive(Clone, Debug)]
pub struct BlockPattern {
    row_starts: Vec<u32>,
    columns: Vec<u32>,
    diagonals: Vec<u32>,
}

impl BlockPattern {
    /// The pattern that couples all vertices of each element with each other, and every vertex with itself.
    pub fn new<'a>(vertex_count: usize, elements: impl Iterator<Item = &'a [u32]>) -> Self {
        let mut rows: Vec<Vec<u32>> = (0..vertex_count as u32).map(|v| vec![v]).collect();
        for element in elements {
            for &row in element {
                rows[row as usize].extend_from_slice(element);
            }
        }
        let mut pattern = Self { row_starts: vec![0], columns: Vec::new(), diagonals: Vec::new() };
        for (vertex, mut row) in rows.into_iter().enumerate() {
            row.sort_unstable();
            row.dedup();
            let diagonal = row.partition_point(|&column| (column as usize) < vertex);
            pattern.diagonals.push((pattern.columns.len() + diagonal) as u32);
            pattern.columns.extend(row);
            pattern.row_starts.push(pattern.columns.len() as u32);
        }
        pattern
    }

    /// Number of block rows: of vertices.
    pub fn row_count(&self) -> usize {
        self.diagonals.len()
    }

    /// Number of blocks.
    pub fn block_count(&self) -> usize {
        self.columns.len()
    }

    /// Slots of the blocks of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> core::ops::Range<usize> {
        self.row_starts[row] as usize..self.row_starts[row + 1] as usize
    }

    /// Columns of all blocks, by slot.
    #[inline(always)]
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// Slots of the diagonal blocks, by row.
    #[inline(always)]
    pub fn diagonals(&self) -> &[u32] {
        &self.diagonals
    }

    /// Slot of the block at (`row`, `column`), if the pattern has it.
    pub fn slot(&self, row: u32, column: u32) -> Option<u32> {
        let range = self.row(row as usize);
        let start = range.start;
        self.columns[range].binary_search(&column).ok().map(|i| (start + i) as u32)
    }

    /// Slots of the blocks (i, j) of an element's vertices, row by row.
    ///
    /// # Panics
    /// If the element is not one of those that the pattern was made for.
    pub(super) fn element_slots<const V: usize>(&self, vertices: [u32; V]) -> [[u32; V]; V] {
        vertices.map(|row| vertices.map(|column| self.slot(row, column).expect("element outside the pattern")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pattern_couples_the_vertices_of_each_element() {
        let elements: [&[u32]; 2] = [&[0, 1, 2], &[2, 1, 3]];
        let pattern = BlockPattern::new(5, elements.into_iter());
        let rows: Vec<&[u32]> = (0..5).map(|row| &pattern.columns()[pattern.row(row)]).collect();
        assert_eq!(rows, [&[0, 1, 2][..], &[0, 1, 2, 3], &[0, 1, 2, 3], &[1, 2, 3], &[4]]);
        assert_eq!(pattern.slot(0, 3), None);
        for row in 0..5 {
            assert_eq!(pattern.slot(row, row), Some(pattern.diagonals()[row as usize]));
        }
    }
}
