//! Where the entries of a matrix stand of which most are always zero.

/// Compressed columns: the pattern of a matrix whose other entries are zero in every state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sparsity<'a> {
    /// Rows of the matrix.
    pub rows: usize,
    /// Columns of the matrix.
    pub columns: usize,
    /// Where each column begins among the entries, and behind the last one how many entries there are.
    pub column_starts: &'a [u16],
    /// The row of each entry.
    pub row_indices: &'a [u16],
}

impl<'a> Sparsity<'a> {
    /// (row, column) of each entry, in their order.
    pub fn places(self) -> impl Iterator<Item = (usize, usize)> + 'a {
        let length = |ends: &[u16]| match *ends {
            [start, end] => usize::from(end.wrapping_sub(start)),
            _ => 0,
        };
        let columns = self.column_starts.windows(2).map(length).enumerate();
        let columns = columns.flat_map(|(column, count)| core::iter::repeat_n(column, count));
        self.row_indices.iter().map(|&row| usize::from(row)).zip(columns)
    }

    /// Where each of its `N` entries stands in the dense matrix, column after column.
    ///
    /// # Panics
    /// There are less than `N` entries; generated code asks while it is compiled.
    pub const fn positions<const N: usize>(self) -> [u16; N] {
        let mut positions = [0; N];
        let (mut k, mut column) = (0, 0);
        while k < N {
            while self.column_starts[column + 1] as usize <= k {
                column += 1;
            }
            positions[k] = (column * self.rows) as u16 + self.row_indices[k];
            k += 1;
        }
        positions
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_stand_where_the_pattern_says() {
        let pattern =
            Sparsity { rows: 3, columns: 4, column_starts: &[0, 2, 2, 3, 4], row_indices: &[0, 2, 1, 2] };
        let places = [(0, 0), (2, 0), (1, 2), (2, 3)];
        assert!(pattern.places().eq(places));
        assert_eq!(pattern.positions::<4>().map(usize::from), places.map(|(row, column)| 3 * column + row));
    }
}
