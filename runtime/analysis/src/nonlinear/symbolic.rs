//! Which columns of a sparse symmetric factor belong together: dense blocks (supernodes) along the elimination tree.
use std::collections::BTreeMap;

/// Columns `first..first + width` that have nonzeros in the same rows below.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub first: usize,
    pub width: usize,
    /// Rows below the columns themselves, growing.
    pub below: Vec<usize>,
    /// Blocks that hand what they leave to this one.
    pub children: Vec<usize>,
    /// Runs of the rows below that stand one behind the other in the block above in the tree too: the first one's place here, there (columns first, then rows below), and
    /// how many they are.
    pub runs_above: Vec<[usize; 3]>,
    /// Blocks above it in the tree.
    pub level: usize,
}

impl Block {
    /// Rows below with their places in the block above.
    pub fn columns_above(&self) -> impl Iterator<Item = (usize, usize)> {
        self.runs_above.iter().flat_map(|&[own, above, count]| (0..count).map(move |k| (own + k, above + k)))
    }
}

/// Blocks of a matrix, children before parents.
#[derive(Debug, Clone)]
pub(super) struct Structure {
    /// Column of the matrix that is eliminated at each place, and the other way round.
    pub order: Vec<usize>,
    pub place: Vec<usize>,
    pub blocks: Vec<Block>,
    /// Block of each place.
    pub block_of: Vec<usize>,
}

/// Where a block takes the one below it in: so many columns, with this part of zeros among what is stored.
const MERGED: [(usize, f64); 4] = [(4, 1.0), (16, 0.8), (48, 0.1), (usize::MAX, 0.05)];

impl Structure {
    /// Of a symmetric matrix given by its upper triangle (columns, rows), eliminated in about this order.
    pub fn new((columns, rows): (&[usize], &[usize]), order: &[usize]) -> Self {
        let n = order.len();
        let (order, parents) = in_postorder((columns, rows), order);
        let mut place = vec![0; n];
        order.iter().enumerate().for_each(|(at, &column)| place[column] = at);
        let own = lower((columns, rows), &place);
        let below = filled(&own, &parents);
        let blocks = merged(joined(&below, &parents));
        let mut block_of = vec![0; n];
        for (index, block) in blocks.iter().enumerate() {
            block_of[block.first..block.first + block.width].fill(index);
        }
        let mut found = Self { order, place, blocks, block_of };
        found.connect();
        found
    }

    /// Children of blocks, where their rows are in their parents, and levels.
    fn connect(&mut self) {
        for index in 0..self.blocks.len() {
            let Some(&next) = self.blocks[index].below.first() else { continue };
            let above = self.block_of[next];
            let places: BTreeMap<usize, usize> = {
                let above = &self.blocks[above];
                let own = above.first..above.first + above.width;
                own.chain(above.below.iter().copied()).enumerate().map(|(k, row)| (row, k)).collect()
            };
            let mut runs: Vec<[usize; 3]> = Vec::new();
            for (own, place) in self.blocks[index].below.iter().map(|row| places[row]).enumerate() {
                match runs.last_mut() {
                    Some([_, first, count]) if *first + *count == place => *count += 1,
                    _ => runs.push([own, place, 1]),
                }
            }
            self.blocks[index].runs_above = runs;
            self.blocks[above].children.push(index);
        }
        for index in (0..self.blocks.len()).rev() {
            let level = self.blocks[index].level + 1;
            for child in self.blocks[index].children.clone() {
                self.blocks[child].level = level;
            }
        }
    }
}

/// Rows at places beyond its own, of each place.
fn lower((columns, rows): (&[usize], &[usize]), place: &[usize]) -> Vec<Vec<usize>> {
    let mut found = vec![Vec::new(); place.len()];
    for column in 0..place.len() {
        for &row in &rows[columns[column]..columns[column + 1]] {
            let (a, b) = (place[row], place[column]);
            if a != b {
                found[a.min(b)].push(a.max(b));
            }
        }
    }
    found
}

/// The elimination tree of a permuted matrix (Liu): parent of each place, none: its own number.
fn tree(own: &[Vec<usize>]) -> Vec<usize> {
    let n = own.len();
    let mut before = vec![Vec::new(); n];
    own.iter().enumerate().for_each(|(a, rows)| rows.iter().for_each(|&b| before[b].push(a)));
    let mut parents: Vec<usize> = (0..n).collect();
    let mut ancestors: Vec<usize> = (0..n).collect();
    for (k, before) in before.iter().enumerate() {
        for &a in before {
            let mut at = a;
            while ancestors[at] != at && ancestors[at] != k {
                let above = std::mem::replace(&mut ancestors[at], k);
                at = above;
            }
            if ancestors[at] == at && at != k {
                ancestors[at] = k;
                parents[at] = k;
            }
        }
    }
    parents
}

/// The same elimination with children right before their parents, and the tree of it.
fn in_postorder(matrix: (&[usize], &[usize]), order: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let n = order.len();
    let mut place = vec![0; n];
    order.iter().enumerate().for_each(|(at, &column)| place[column] = at);
    let parents = tree(&lower(matrix, &place));
    let mut children = vec![Vec::new(); n];
    (0..n).filter(|&k| parents[k] != k).for_each(|k| children[parents[k]].push(k));
    let mut sequence = Vec::with_capacity(n);
    for root in (0..n).filter(|&k| parents[k] == k) {
        // Parents before children, turned round.
        let begin = sequence.len();
        let mut open = vec![root];
        while let Some(at) = open.pop() {
            sequence.push(at);
            open.extend(&children[at]);
        }
        sequence[begin..].reverse();
    }
    let mut renamed = vec![0; n];
    sequence.iter().enumerate().for_each(|(at, &k)| renamed[k] = at);
    let parents = sequence.iter().map(|&k| renamed[parents[k]]).collect();
    (sequence.iter().map(|&k| order[k]).collect(), parents)
}

/// Rows of the factor below each column.
fn filled(own: &[Vec<usize>], parents: &[usize]) -> Vec<Vec<usize>> {
    let mut found: Vec<Vec<usize>> = own.to_vec();
    for k in 0..own.len() {
        found[k].sort_unstable();
        found[k].dedup();
        if parents[k] != k {
            let handed: Vec<usize> = found[k].iter().copied().filter(|&row| row != parents[k]).collect();
            found[parents[k]].extend(handed);
        }
    }
    found
}

/// Neighbouring columns whose rows are the same.
fn joined(below: &[Vec<usize>], parents: &[usize]) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    for (k, rows) in below.iter().enumerate() {
        let goes_on = k > 0 && parents[k - 1] == k && below[k - 1].len() == rows.len() + 1;
        match found.last_mut().filter(|_| goes_on) {
            Some(block) => {
                block.width += 1;
                block.below.clone_from(rows);
            }
            None => found.push(Block {
                first: k,
                width: 1,
                below: rows.clone(),
                children: Vec::new(),
                runs_above: Vec::new(),
                level: 0,
            }),
        }
    }
    found
}

/// Takes blocks into those above them where little is lost by it.
fn merged(blocks: Vec<Block>) -> Vec<Block> {
    let mut found: Vec<(Block, usize)> = Vec::new();
    let stored = |width: usize, below: usize| width * (width + 1) / 2 + width * below;
    for block in blocks {
        let (mut block, mut zeros) = (block, 0);
        while let Some((last, before)) = found.last() {
            // The block just before is a child if its first row below is one of these columns.
            let child = last.below.first().is_some_and(|&row| row < block.first + block.width);
            let width = last.width + block.width;
            let whole = stored(width, block.below.len());
            let more = last.width * (block.width + block.below.len() - last.below.len());
            let part = (zeros + before + more) as f64 / whole as f64;
            if !child || !MERGED.iter().any(|&(most, allowed)| width <= most && part <= allowed) {
                break;
            }
            zeros += before + more;
            (block.first, block.width) = (last.first, width);
            found.pop();
        }
        found.push((block, zeros));
    }
    found.into_iter().map(|(block, _)| block).collect()
}
