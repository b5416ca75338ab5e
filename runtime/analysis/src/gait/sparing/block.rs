//! Blocks of cells that are halved.

/// Cells between two columns and two rows, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    /// First and last column, first and last row.
    pub ends: [[usize; 2]; 2],
}

/// Places of a side between which is halved: how often, until a place is an end; both ends are 0.
pub(super) fn depths(count: usize, width: usize) -> Vec<u8> {
    let mut found = vec![0; count];
    let mut sides = sides(count, width);
    for depth in 1.. {
        sides = sides
            .into_iter()
            .filter(|[first, last]| last - first > 1)
            .flat_map(|side| parts(side, true))
            .collect();
        if sides.is_empty() {
            break;
        }
        // The middle is the end of a first half, and the beginning of a second one.
        sides.chunks(2).for_each(|pair| found[pair[0][1]] = depth);
    }
    found
}

/// Sides of about `width` places that cover so many.
fn sides(count: usize, width: usize) -> Vec<[usize; 2]> {
    let last = count.saturating_sub(1);
    let parts = last.div_ceil(width).max(1);
    (0..parts).map(|k| [k * last / parts, (k + 1) * last / parts]).collect()
}

/// First and last place of a side, and the one in the middle if there is one.
pub(super) fn three([first, last]: [usize; 2]) -> impl Iterator<Item = usize> + Clone {
    let middle = usize::midpoint(first, last);
    [first, middle, last]
        .into_iter()
        .enumerate()
        .filter(move |(k, _)| *k != 1 || middle > first)
        .map(|(_, at)| at)
}

/// A side in halves, if it is to be halved and is no single cell or pair of neighbours.
fn parts([first, last]: [usize; 2], halved: bool) -> impl Iterator<Item = [usize; 2]> + Clone {
    let middle = usize::midpoint(first, last);
    let whole = !halved || last - first < 2;
    let all = if whole { [[first, last], [first, last]] } else { [[first, middle], [middle, last]] };
    all.into_iter().take(if whole { 1 } else { 2 })
}

impl Block {
    /// Blocks of about `width` places a side that cover a map of these sizes.
    pub fn all([columns, rows]: [usize; 2], width: usize) -> Vec<Self> {
        let rows = sides(rows, width);
        let one = |x: [usize; 2]| rows.iter().map(move |&y| Self { ends: [x, y] });
        sides(columns, width).into_iter().flat_map(one).collect()
    }

    /// Columns and rows of its four corners.
    pub fn corners(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [x, y] = self.ends;
        x.into_iter().flat_map(move |x| y.into_iter().map(move |y| [x, y]))
    }

    /// Its corners, the middles of its sides and its own.
    pub fn nodes(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [x, y] = self.ends;
        three(x).flat_map(move |x| three(y).map(move |y| [x, y]))
    }

    /// Whether it has cells beside its corners.
    pub fn has_middle(&self) -> bool {
        self.ends.iter().any(|[first, last]| last - first > 1)
    }

    /// Its halves along the axes along which it is to be halved.
    pub fn parts(&self, [along_x, along_y]: [bool; 2]) -> impl Iterator<Item = Self> + use<> {
        let [x, y] = self.ends;
        parts(x, along_x).flat_map(move |x| parts(y, along_y).map(move |y| Self { ends: [x, y] }))
    }

    /// All cells, on its border too.
    pub fn cells(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [x, y] = self.ends;
        (x[0]..=x[1]).flat_map(move |x| (y[0]..=y[1]).map(move |y| [x, y]))
    }

    /// Whether it has a cell in common with another one.
    pub fn touches(&self, other: &Self) -> bool {
        self.ends.iter().zip(other.ends).all(|(a, b)| a[0] <= b[1] && b[0] <= a[1])
    }

    /// Whether a cell lies in it or on its border.
    pub fn holds(&self, at: [usize; 2]) -> bool {
        self.ends.iter().zip(at).all(|(ends, at)| (ends[0]..=ends[1]).contains(&at))
    }
}

#[cfg(test)]
mod tests {
    use super::{Block, depths};

    /// Blocks and their parts cover all cells, with nothing but borders in common; nodes are corners of parts.
    #[test]
    fn blocks_cover_the_map_however_they_are_halved() {
        for (size, both) in [([2, 2], true), ([3, 50], true), ([17, 33], false), ([200, 23], true)] {
            let mut blocks = Block::all(size, 16);
            while blocks.iter().any(Block::has_middle) {
                // Now this way, now that, or both.
                let axes = |block: &Block| {
                    let wide = block.ends[0][1] - block.ends[0][0] > 1;
                    if both { [true; 2] } else { [wide, !wide] }
                };
                for block in &blocks {
                    let corners: Vec<_> = block.parts([true; 2]).flat_map(|part| part.corners()).collect();
                    assert!(block.nodes().all(|at| corners.contains(&at)), "{block:?}");
                }
                blocks = blocks.iter().flat_map(|block| block.parts(axes(block))).collect();
                let mut seen = vec![0; size[0] * size[1]];
                for block in &blocks {
                    // A border belongs to the block before it, but at the very beginning.
                    let inner = |at: &[usize; 2]| {
                        at.iter().zip(block.ends).all(|(&at, ends)| at > ends[0] || at == 0)
                    };
                    block.cells().filter(inner).for_each(|[x, y]| seen[y * size[0] + x] += 1);
                }
                assert!(seen.iter().all(|count| *count == 1), "{size:?}");
            }
        }
    }

    #[test]
    fn middles_are_deeper_than_both_ends() {
        assert_eq!(depths(9, 4), [0, 2, 1, 2, 0, 2, 1, 2, 0]);
        for count in [2, 3, 33, 200] {
            let depths = depths(count, 16);
            let mut blocks = Block::all([count, 2], 16);
            while let Some(block) = blocks.pop() {
                let [first, last] = block.ends[0];
                if last - first > 1 {
                    let ends = depths[first].max(depths[last]);
                    assert_eq!(depths[usize::midpoint(first, last)], ends + 1, "{block:?}");
                    blocks.extend(block.parts([true, false]));
                }
            }
        }
    }
}
