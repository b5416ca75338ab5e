//! One step's contact problem: which impulses, which velocities they make, which laws tie the two.
use super::dense::{add_rows, dot, row_length};

/// What an impulse may be, and what its velocity is then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// One row: pushes and never pulls, `0 ≤ λ ⊥ ξ ≥ 0` (4.2) on the level of velocities.
    Unilateral,
    /// One row: at most this large and against the motion, `λ ∈ −limits · Sign(ξ)` as (4.5): dry friction of a joint.
    Limited {
        /// Smallest impulse, not positive, N s or N m s.
        low: f64,
        /// Largest one, not negative.
        high: f64,
    },
    /// A normal row and `tangents` rows of friction after it (4.2), (4.5).
    Contact {
        /// Friction coefficient.
        friction: f64,
        /// 1 in the plane, 2 in space.
        tangents: usize,
        /// Shape of the set of friction forces.
        cone: Cone,
    },
    /// Three rows of friction of a flat sole: two tangential ones in its middle, and turning about the vertical. They are
    /// limited by the sum of the `normals` unilateral rows just before them.
    Sole {
        /// Friction coefficient.
        friction: f64,
        /// Largest moment per normal force, m.
        turning: f64,
        /// How many rows before this block are the normal ones.
        normals: usize,
        /// Shape of the set of friction forces.
        cone: Cone,
    },
}

/// The set that tangential impulses stay in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Cone {
    /// `|λ_T| ≤ μ λ_N`: Coulomb's law, the same in all directions.
    #[default]
    Round,
    /// `|λ_x| ≤ μ λ_N` and `|λ_y| ≤ μ λ_N`: what simulators such as ODE use (thesis 4.3.2); too strong by up to √2.
    Pyramid,
}

/// Consecutive rows under one law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Its first row; normal row of a contact.
    pub first: usize,
    /// See [`Law`].
    pub law: Law,
}

impl Block {
    /// How many rows it has.
    pub fn size(&self) -> usize {
        match self.law {
            Law::Unilateral | Law::Limited { .. } => 1,
            Law::Contact { tangents, .. } => 1 + tangents,
            Law::Sole { .. } => 3,
        }
    }
}

/// How far from its limit friction is at it, as a part of it.
const AT_LIMIT: f64 = 1e-6;

/// Find λ so that `ξ = G λ + c` and every block's law hold. Kept between steps: nothing is allocated once it is large
/// enough.
#[derive(Debug, Clone, Default)]
pub struct Problem {
    /// `rows × rows`, symmetric, positive semidefinite: velocities per impulse (Delassus' operator `Wᵀ D⁻¹ W`), 1/kg. Rows are
    /// as long as [`row_length`] says.
    pub(super) delassus: Vec<f64>,
    /// Velocity without impulses plus restitution times the velocity before, m/s.
    pub free: Vec<f64>,
    /// In the order of the rows, without gaps.
    pub blocks: Vec<Block>,
    /// λ: a guess before, the answer after; N s.
    pub impulse: Vec<f64>,
    /// By how much the guess changed from step to step: where it may have come to. Zero: not known.
    pub(super) trend: Vec<f64>,
    /// By block: whether the guess is friction at its limit. It may well stay there, which the guess alone would not tell: what slides on
    /// the springs of `sharing` alone is beyond the limit by next to nothing.
    pub(super) at_limit: Vec<bool>,
    /// ξ of `impulse`, m/s.
    pub velocity: Vec<f64>,
    /// Step of the proximal point by row (r of 4.7), kg.
    pub(super) weight: Vec<f64>,
    /// `|r c|²` of what drives the robot: where stops and points that nothing drives together do not count, however far they are.
    pub(super) driven: f64,
    /// How far `impulse` is from what the laws make of it, by row: what the residual is formed from.
    pub(super) missed: Vec<f64>,
}

impl Problem {
    /// How many impulses there are.
    pub fn rows(&self) -> usize {
        self.free.len()
    }

    /// Takes everything out and makes place for this many rows; λ and c are zero, G is to be written.
    pub fn clear(&mut self, rows: usize) {
        self.blocks.clear();
        self.at_limit.clear();
        self.at_limit.reserve(rows);
        for values in [&mut self.free, &mut self.impulse, &mut self.trend] {
            values.clear();
            values.resize(rows, 0.0);
        }
        for values in [&mut self.velocity, &mut self.weight, &mut self.missed] {
            values.resize(rows, 0.0);
        }
        self.delassus.resize(rows * row_length(rows), 0.0);
    }

    /// Makes room for so many rows once, so that [`Self::clear`] never allocates for fewer.
    pub fn reserve(&mut self, rows: usize) {
        self.clear(rows);
        self.blocks.reserve(rows);
        self.clear(0);
    }

    /// One row of `G`.
    pub fn row(&self, row: usize) -> &[f64] {
        let n = self.rows();
        &self.delassus[row * row_length(n)..][..n]
    }

    /// Writes all of `G`.
    pub fn set_delassus(&mut self, entry: impl Fn(usize, usize) -> f64) {
        let n = self.rows();
        for (i, row) in self.delassus.chunks_exact_mut(row_length(n).max(1)).enumerate() {
            row[..n].iter_mut().enumerate().for_each(|(j, value)| *value = entry(i, j));
        }
    }

    /// One number on the diagonal of `G`.
    pub(super) fn diagonal_mut(&mut self, row: usize) -> &mut f64 {
        let length = row_length(self.rows());
        &mut self.delassus[row * length + row]
    }

    /// `ξ` at the present impulses.
    pub(super) fn move_by_impulses(&mut self) {
        self.velocity.copy_from_slice(&self.free);
        add_rows(&self.delassus, &self.impulse, &mut self.velocity);
    }

    /// `ξ` of one row at the present impulses.
    pub(super) fn velocity_of(&self, row: usize) -> f64 {
        self.free[row] + dot(self.row(row), &self.impulse)
    }

    /// The steps of the proximal point: the reciprocal of the largest velocity per impulse of a block's normal row, or
    /// of its tangential rows together, so that a lone contact is solved at once.
    pub(super) fn weigh(&mut self) {
        for block in 0..self.blocks.len() {
            let Block { first, law } = self.blocks[block];
            self.weight[first] = reciprocal(self.row(first)[first]);
            match law {
                Law::Contact { tangents: 2, .. } => self.weigh_pair(first + 1),
                Law::Contact { .. } => self.weight[first + 1] = reciprocal(self.row(first + 1)[first + 1]),
                Law::Sole { .. } => {
                    self.weigh_pair(first);
                    self.weight[first + 2] = reciprocal(self.row(first + 2)[first + 2]);
                }
                Law::Unilateral | Law::Limited { .. } => {}
            }
        }
        self.driven = self.blocks.iter().map(|block| self.driven_by(block)).sum();
    }

    fn driven_by(&self, block: &Block) -> f64 {
        let rows = block.first..block.first + block.size();
        let one_sided = matches!(block.law, Law::Unilateral | Law::Contact { .. });
        if one_sided && self.free[block.first] >= 0.0 {
            return 0.0;
        }
        rows.map(|row| (self.weight[row] * self.free[row]).powi(2)).sum()
    }

    /// Finds out which blocks' friction is at its limit in the guess.
    pub(super) fn find_limits(&mut self) {
        self.at_limit.clear();
        for block in &self.blocks {
            let (load, tangential, friction) = match block.law {
                Law::Contact { friction, tangents: 2, cone: Cone::Round } => {
                    (self.impulse[block.first], block.first + 1, friction)
                }
                Law::Sole { friction, normals, cone: Cone::Round, .. } => {
                    (self.load(block.first, normals), block.first, friction)
                }
                _ => {
                    self.at_limit.push(false);
                    continue;
                }
            };
            let own = &self.impulse[tangential..tangential + 2];
            let (force, most) = ((own[0] * own[0] + own[1] * own[1]).sqrt(), friction * load.max(0.0));
            self.at_limit.push(most > 0.0 && (force - most).abs() <= AT_LIMIT * most);
        }
    }

    /// Two tangential rows have one weight.
    fn weigh_pair(&mut self, first: usize) {
        let (a, b) = (self.row(first), self.row(first + 1));
        let (xx, xy, yy) = (a[first], a[first + 1], b[first + 1]);
        let largest = 0.5 * (xx + yy) + (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        self.weight[first..first + 2].fill(reciprocal(largest));
    }

    /// Sum of the normal impulses of a sole whose friction begins at `first`.
    pub(super) fn load(&self, first: usize, normals: usize) -> f64 {
        self.impulse[first - normals..first].iter().map(|impulse| impulse.max(0.0)).sum()
    }
}

fn reciprocal(x: f64) -> f64 {
    if x > 0.0 { x.recip() } else { 0.0 }
}

/// The nearest admissible tangential impulse (prox of 4.7) under a normal impulse.
pub(super) fn nearest(tangential: [f64; 2], limit: f64, tangents: usize, cone: Cone) -> [f64; 2] {
    match (cone, tangents) {
        (Cone::Round, 2) => {
            let length = (tangential[0] * tangential[0] + tangential[1] * tangential[1]).sqrt();
            if length <= limit { tangential } else { tangential.map(|x| x * (limit / length)) }
        }
        _ => tangential.map(|x| x.clamp(-limit, limit)),
    }
}
