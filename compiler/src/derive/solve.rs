//! Factorisation of the mass matrix by the tree's sparsity: D = Lᵀ Δ L, leaves first.
use super::model::RobotModel;
use crate::expression::Sym;

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
        let topology = Topology::new(model.tree);
        let n = topology.order.len();
        let mut h: Vec<Vec<Sym<'g>>> =
            (0..n).map(|r| (0..n).map(|c| d[topology.order[r]][topology.order[c]]).collect()).collect();
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
        for k in 0..x.len() {
            for &i in self.topology.supports[k].iter().rev() {
                x[k] = x[k] - self.lower[k][i] * x[i];
            }
        }
        let mut out = x.clone();
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
