//! Factorisation of the mass matrix by the tree's sparsity: D = Lᵀ Δ L, leaves first.
use super::model::RobotModel;
use crate::expression::{Purpose, Sym, Work};

/// Degrees of freedom from the root outwards, each with its chain of supporting ones.
pub struct Topology {
    /// `order[k]` is an index into `v`; every one comes after those it hangs on.
    order: Vec<usize>,
    /// `supports[k]`: positions in `order` of all degrees of freedom that carry the k-th, nearest first.
    supports: Vec<Vec<usize>>,
}

impl Topology {
    /// Of a tree.
    pub fn new(tree: &crate::tree::Tree) -> Self {
        let (mut order, mut supports) = (Vec::new(), Vec::<Vec<usize>>::new());
        let mut last_of_body: Vec<usize> = Vec::new();
        for body in &tree.bodies {
            let mut carrier = body.parent.map(|p| last_of_body[p]);
            for k in 0..body.motion.nv() {
                let chain = carrier.map_or_else(Vec::new, |c: usize| {
                    std::iter::once(c).chain(supports[c].iter().copied()).collect()
                });
                order.push(body.v_index + k);
                supports.push(chain);
                carrier = Some(order.len() - 1);
            }
            last_of_body.push(order.len() - 1);
        }
        Self { order, supports }
    }
}

impl Topology {
    /// Of a tree whose base rows up to `held` stand still.
    pub(super) fn beyond(tree: &crate::tree::Tree, held: usize) -> Self {
        let whole = Self::new(tree);
        let kept: Vec<usize> = (0..whole.order.len()).filter(|&k| whole.order[k] >= held).collect();
        let place = |old: &usize| kept.iter().position(|k| k == old);
        Self {
            order: kept.iter().map(|&k| whole.order[k]).collect(),
            supports: kept.iter().map(|&k| whole.supports[k].iter().filter_map(place).collect()).collect(),
        }
    }

    /// Of the joints of a free robot as seen from a foot that stands still: the tree rooted at that foot,
    /// without the base's degrees of freedom.
    pub(super) fn standing_on(tree: &crate::tree::Tree, foot: usize) -> Self {
        let path: Vec<usize> = tree.path_to_root(foot).filter(|&b| tree.bodies[b].parent.is_some()).collect();
        let (mut order, mut supports) = (Vec::new(), Vec::<Vec<usize>>::new());
        for (k, &body) in path.iter().enumerate() {
            order.push(tree.bodies[body].v_index);
            supports.push((0..k).rev().collect());
        }
        let mut position: Vec<Option<usize>> = vec![None; tree.bodies.len()];
        for (index, body) in tree.bodies.iter().enumerate() {
            let Some(parent) = body.parent else { continue };
            if path.contains(&index) {
                continue;
            }
            let chain: Vec<usize> = match (position[parent], path.iter().position(|&b| b == parent)) {
                (Some(k), _) => std::iter::once(k).chain(supports[k].iter().copied()).collect(),
                // Only the joints between this body and the foot carry what hangs on it.
                (None, Some(k)) => (0..k).rev().collect(),
                (None, None) => (0..path.len()).rev().collect(),
            };
            position[index] = Some(order.len());
            order.push(body.v_index);
            supports.push(chain);
        }
        Self { order, supports }
    }
}

fn substitution<'g>(b: &[Sym<'g>]) -> Option<Work<'g>> {
    b.first().map(|x| x.graph.work(Purpose { body: None, quantity: "solved by the factors" }))
}

/// `D = Lᵀ Δ L` with unit lower-triangular `L` that is as sparse as the tree.
pub struct Factor<'g> {
    topology: Topology,
    /// Strictly lower elements, by positions in the order.
    lower: Vec<Vec<Sym<'g>>>,
    /// 1 / Δ
    inverse_diagonal: Vec<Sym<'g>>,
}

impl<'g> Factor<'g> {
    /// Factors a mass matrix (given in the order of `v`).
    pub fn new(model: &RobotModel<'g, '_>, d: &[Vec<Sym<'g>>]) -> Self {
        Self::with_topology(model, Topology::new(model.tree), d)
    }

    /// Factors a matrix of another sparsity.
    pub(super) fn with_topology(model: &RobotModel<'g, '_>, topology: Topology, d: &[Vec<Sym<'g>>]) -> Self {
        let n = topology.order.len();
        let mut h: Vec<Vec<Sym<'g>>> =
            (0..n).map(|r| (0..n).map(|c| d[topology.order[r]][topology.order[c]]).collect()).collect();
        let _work = model.work_on_all("factors of the mass matrix");
        let mut inverse_diagonal = vec![model.constant(1.0); n];
        for k in (0..n).rev() {
            inverse_diagonal[k] = model.constant(1.0) / h[k][k];
            let chain = topology.supports[k].clone();
            for (at, &i) in chain.iter().enumerate() {
                let factor = h[k][i] * inverse_diagonal[k];
                for &j in &chain[at..] {
                    h[i][j] = h[i][j] - factor * h[k][j];
                }
                h[k][i] = factor;
            }
        }
        Self { topology, lower: h, inverse_diagonal }
    }

    /// `D⁻¹ b`, both in the order of `v`.
    pub fn solve(&self, b: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let y = self.half_solve(b);
        let scaled: Vec<_> = y.iter().zip(&self.inverse_diagonal).map(|(&y, &d)| y * d).collect();
        self.back_solve(scaled)
    }

    /// `L⁻ᵀ b`, in the topology's order; `bᵀ D⁻¹ c` is the Δ⁻¹-weighted product of two of these.
    pub fn half_solve(&self, b: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let _work = substitution(b);
        let mut x: Vec<Sym<'g>> = self.topology.order.iter().map(|&v| b[v]).collect();
        for k in (0..x.len()).rev() {
            for &i in &self.topology.supports[k] {
                x[i] = x[i] - self.lower[k][i] * x[k];
            }
        }
        x
    }

    /// `L⁻¹ y` from the topology's order into the order of `v`.
    pub fn back_solve(&self, y: Vec<Sym<'g>>) -> Vec<Sym<'g>> {
        let mut x = y;
        let _work = substitution(&x);
        for k in 0..x.len() {
            for &i in self.topology.supports[k].iter().rev() {
                x[k] = x[k] - self.lower[k][i] * x[i];
            }
        }
        let size = self.topology.order.iter().max().map_or(0, |last| last + 1);
        let mut out = x.first().map_or_else(Vec::new, |first| vec![first.zero(); size]);
        for (k, &v) in self.topology.order.iter().enumerate() {
            out[v] = x[k];
        }
        out
    }

    /// 1 / Δ in the topology's order.
    pub fn inverse_diagonal(&self) -> &[Sym<'g>] {
        &self.inverse_diagonal
    }
}
