//! Derivatives of one expression with respect to many inputs, from the result back to the inputs; and which inputs an expression has.
use super::node::{Call, Expr, Input, Node};
use super::symbol::Sym;
use std::collections::{BTreeMap, BTreeSet};

/// ∂`of`/∂input for all inputs that `of` has. It costs a few times what `of` does, however many inputs there are.
///
/// Where two arguments of a maximum are equal it is half the slope of each.
pub fn gradient<'g>(of: Sym<'g>) -> BTreeMap<Input, Sym<'g>> {
    let graph = of.graph;
    let nodes = graph.nodes();
    let sym = |e: Expr| Sym::new(graph, e);
    let mut adjoints: Vec<Option<Sym<'g>>> = vec![None; of.expr.node() + 1];
    let seed = if of.expr.is_negated() { of.constant(-1.0) } else { of.constant(1.0) };
    adjoints[of.expr.node()] = Some(seed);
    let mut found = BTreeMap::new();
    for index in (0..=of.expr.node()).rev() {
        let Some(own) = adjoints[index] else { continue };
        let value = sym(Expr::positive(index));
        let mut give = |e: Expr, slope: Sym<'g>| {
            let slope = if e.is_negated() { -slope } else { slope };
            let place = &mut adjoints[e.node()];
            *place = Some(place.map_or(slope, |sum| sum + slope));
        };
        match nodes[index] {
            Node::Constant(_) | Node::Call(Call::Sign, _) => {}
            Node::Input(input) => drop(found.insert(input, own)),
            Node::Add(a, b) => {
                give(a, own);
                give(b, own);
            }
            Node::Mul(a, b) => {
                give(a, own * sym(b));
                give(b, own * sym(a));
            }
            Node::Div(a, b) => {
                give(a, own / sym(b));
                give(b, -(own * value / sym(b)));
            }
            Node::Sqrt(a) => give(a, own * 0.5 / value),
            Node::Sin(a) => give(a, own * sym(a).cos()),
            Node::Cos(a) => give(a, -(own * sym(a).sin())),
            Node::Call(Call::Sin, a) => give(a, own * sym(a).cos_of_any()),
            Node::Call(Call::Cos, a) => give(a, -(own * sym(a).sin_of_any())),
            Node::Call(Call::Exp, a) => give(a, own * value),
            Node::Call(Call::Tanh, a) => give(a, own * (own.constant(1.0) - value * value)),
            Node::Call(Call::Abs, a) => give(a, own * sym(a).call(Call::Sign)),
            Node::Larger(a, b) => {
                let first = ((sym(a) - sym(b)).call(Call::Sign) + 1.0) * 0.5;
                give(a, own * first);
                give(b, own * (own.constant(1.0) - first));
            }
        }
    }
    found
}

/// The inputs that an expression has.
pub fn inputs(of: Sym<'_>) -> BTreeSet<Input> {
    let nodes = of.graph.nodes();
    let mut seen = vec![false; of.expr.node() + 1];
    let mut open = vec![of.expr.node()];
    let mut found = BTreeSet::new();
    while let Some(index) = open.pop() {
        if std::mem::replace(&mut seen[index], true) {
            continue;
        }
        if let Node::Input(input) = nodes[index] {
            found.insert(input);
        }
        open.extend(nodes[index].operands().map(Expr::node));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::graph::Graph;
    use super::super::rewrite::slopes_along;
    use super::*;
    use crate::program::{Evaluator, Order, lower};
    use bipedc_runtime::{Argument, State};

    /// The gradient's product with a direction is the slope along it, for every operation.
    #[test]
    fn gradients_are_the_slopes_along_all_directions() {
        let graph = Graph::new();
        let [x, y] = [0, 1].map(|k| Sym::new(&graph, graph.input(Argument::Q, k)));
        let smooth = (x * y).sin() * (x - y).cos() / (y * y + 1.0) + (x * x + 2.0).sqrt();
        let calls = (y * 0.3).call(Call::Exp) * x.call(Call::Tanh) - (x - y).call(Call::Abs);
        let f = -(smooth + calls + x.larger(y) * (x.sin() + y).sin_of_any() - x.cos().cos_of_any());
        let gradient = gradient(f);
        assert_eq!(inputs(f).len(), 2);
        let mut outputs: Vec<Expr> = gradient.values().map(|g| g.expr).collect();
        for k in 0..2 {
            let along =
                slopes_along(&[f], |input| Some(f.constant(if input.index == k { 1.0 } else { 0.0 })));
            outputs.push(along[0].expr);
        }
        let evaluator = Evaluator::new(&lower(&graph, &outputs, Order::Derivation));
        for at in [[0.4, 0.9], [1.1, -0.2], [-0.6, -2.0]] {
            let mut out = [0.0_f64; 4];
            evaluator.run(&State::new().with(Argument::Q, &at), &mut evaluator.workspace(), &mut out);
            assert!((out[0] - out[2]).abs() < 1e-13 && (out[1] - out[3]).abs() < 1e-13, "{out:?}");
        }
    }
}
