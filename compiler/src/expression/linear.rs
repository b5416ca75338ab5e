//! Separation of what is linear in the inertial parameters (thesis 5.1–5.6, Algorithm 5.1), on the graph
//! instead of on expanded text.
use super::graph::Graph;
use super::node::{Expr, Node};
use bipedc_runtime::Argument;
use std::collections::BTreeMap;

/// `known + Σ coefficient · parameter`
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LinearForm {
    /// The part without parameters (the thesis' ζ, with the sign it has in the function).
    pub known: Option<Expr>,
    /// Coefficient by parameter index; zero coefficients are absent.
    pub coefficients: BTreeMap<u32, Expr>,
}

impl LinearForm {
    fn of(known: Expr) -> Self {
        Self { known: (known != Expr::ZERO).then_some(known), coefficients: BTreeMap::new() }
    }
    fn known(&self) -> Expr {
        self.known.unwrap_or(Expr::ZERO)
    }
    fn is_known(&self) -> bool {
        self.coefficients.is_empty()
    }
    fn map(&self, f: impl Fn(Expr) -> Expr) -> Self {
        let mut form = Self::of(f(self.known()));
        form.coefficients = self.coefficients.iter().map(|(&k, &c)| (k, f(c))).collect();
        form.coefficients.retain(|_, c| *c != Expr::ZERO);
        form
    }
    fn add(&self, graph: &Graph, other: &Self) -> Self {
        let mut sum = Self::of(graph.add(self.known(), other.known()));
        sum.coefficients.clone_from(&self.coefficients);
        for (&k, &c) in &other.coefficients {
            let entry = sum.coefficients.entry(k).or_insert(Expr::ZERO);
            *entry = graph.add(*entry, c);
        }
        sum.coefficients.retain(|_, c| *c != Expr::ZERO);
        sum
    }
}

/// Separates every output into known part and one coefficient per element of [`Argument::Parameters`].
///
/// # Errors
/// The index of the first output that is not linear in the parameters.
pub fn separate(graph: &Graph, outputs: &[Expr]) -> Result<Vec<LinearForm>, usize> {
    let mut forms: BTreeMap<usize, Option<LinearForm>> = BTreeMap::new();
    let purposes = graph.purposes();
    for index in reachable(graph, outputs) {
        let _work = graph.work(purposes[index]);
        let form = separate_node(graph, &forms, index);
        forms.insert(index, form);
    }
    let signed = |e: &Expr| forms[&e.node()].as_ref().map(|form| apply_sign(form, *e));
    outputs.iter().enumerate().map(|(i, e)| signed(e).ok_or(i)).collect()
}

fn apply_sign(form: &LinearForm, e: Expr) -> LinearForm {
    if e.is_negated() { form.map(|c| -c) } else { form.clone() }
}

fn separate_node(
    graph: &Graph,
    forms: &BTreeMap<usize, Option<LinearForm>>,
    index: usize,
) -> Option<LinearForm> {
    let itself = Expr::positive(index);
    let form = |e: Expr| forms[&e.node()].as_ref().map(|form| apply_sign(form, e));
    match graph.node(index) {
        Node::Input(input) if input.argument == Argument::Parameters => {
            Some(LinearForm { known: None, coefficients: BTreeMap::from([(input.index, Expr::ONE)]) })
        }
        Node::Constant(_) | Node::Input(_) => Some(LinearForm::of(itself)),
        Node::Add(a, b) => {
            let (fa, fb) = (form(a)?, form(b)?);
            if fa.is_known() && fb.is_known() {
                Some(LinearForm::of(itself))
            } else {
                Some(fa.add(graph, &fb))
            }
        }
        Node::Mul(a, b) => {
            let (fa, fb) = (form(a)?, form(b)?);
            match (fa.is_known(), fb.is_known()) {
                (true, true) => Some(LinearForm::of(itself)),
                (true, false) => Some(fb.map(|c| graph.mul(a, c))),
                (false, true) => Some(fa.map(|c| graph.mul(b, c))),
                (false, false) => None,
            }
        }
        Node::Div(a, b) => {
            let (fa, fb) = (form(a)?, form(b)?);
            match (fa.is_known(), fb.is_known()) {
                (true, true) => Some(LinearForm::of(itself)),
                (false, true) => Some(fa.map(|c| graph.div(c, b))),
                _ => None,
            }
        }
        Node::Sqrt(a) | Node::Sin(a) | Node::Cos(a) | Node::Call(_, a) => {
            form(a)?.is_known().then(|| LinearForm::of(itself))
        }
        Node::Larger(a, b) => (form(a)?.is_known() && form(b)?.is_known()).then(|| LinearForm::of(itself)),
    }
}

/// Indices of all nodes that `outputs` need, operands first.
fn reachable(graph: &Graph, outputs: &[Expr]) -> Vec<usize> {
    let nodes = graph.nodes();
    let mut needed = vec![false; nodes.len()];
    for e in outputs {
        needed[e.node()] = true;
    }
    for index in (0..nodes.len()).rev() {
        if needed[index] {
            for operand in nodes[index].operands() {
                needed[operand.node()] = true;
            }
        }
    }
    (0..nodes.len()).filter(|&i| needed[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separates_products_and_leaves_the_rest() {
        let g = Graph::new();
        let (x, y) = (g.input(Argument::Q, 0), g.input(Argument::Q, 1));
        let (p, r) = (g.input(Argument::Parameters, 0), g.input(Argument::Parameters, 1));
        // x (p - y r) + y
        let e = g.add(g.mul(x, g.sub(p, g.mul(y, r))), y);
        let form = &separate(&g, &[-e]).unwrap()[0];
        assert_eq!(form.known, Some(-y));
        assert_eq!(form.coefficients[&0], -x);
        assert_eq!(form.coefficients[&1], g.mul(x, y));
    }

    #[test]
    fn products_of_parameters_are_refused() {
        let g = Graph::new();
        let p = g.input(Argument::Parameters, 0);
        assert_eq!(separate(&g, &[Expr::ONE, g.mul(p, p)]), Err(1));
    }
}
