//! Expressions made from expressions: slopes along a direction, and inputs replaced by something else.
use super::graph::Graph;
use super::node::{Call, Expr, Input, Node};
use super::symbol::Sym;

/// The derivatives of expressions along a direction: `direction` says how each input changes, `None` not at all.
///
/// Where two arguments of a maximum are equal it is half the slope of each.
pub fn slopes_along<'g>(of: &[Sym<'g>], direction: impl Fn(Input) -> Option<Sym<'g>>) -> Vec<Sym<'g>> {
    let Some(first) = of.first() else { return Vec::new() };
    let graph = first.graph;
    rewritten(of, |index, node, made| {
        let slope = |e: Expr| signed(made, e);
        slope_of(graph, (index, node), slope, &direction)
    })
}

/// The expressions with inputs replaced; `None` leaves an input as it is.
pub fn replaced<'g>(of: &[Sym<'g>], by: impl Fn(Input) -> Option<Sym<'g>>) -> Vec<Sym<'g>> {
    let Some(first) = of.first() else { return Vec::new() };
    let graph = first.graph;
    rewritten(of, |index, node, made| {
        let value = |e: Expr| signed(made, e);
        let same = || Sym::new(graph, Expr::positive(index));
        match node {
            Node::Constant(_) => same(),
            Node::Input(input) => by(input).unwrap_or_else(same),
            Node::Add(a, b) => value(a) + value(b),
            Node::Mul(a, b) => value(a) * value(b),
            Node::Div(a, b) => value(a) / value(b),
            Node::Sqrt(a) => value(a).sqrt(),
            Node::Sin(a) | Node::Call(Call::Sin, a) => value(a).sin_of_any(),
            Node::Cos(a) | Node::Call(Call::Cos, a) => value(a).cos_of_any(),
            Node::Call(call, a) => value(a).call(call),
            Node::Larger(a, b) => value(a).larger(value(b)),
        }
    })
}

/// What was made of a node, with the sign of the edge to it.
fn signed<'g>(made: &[Option<Sym<'g>>], e: Expr) -> Sym<'g> {
    let Some(found) = made[e.node()] else { unreachable!("operands come before their users") };
    if e.is_negated() { -found } else { found }
}

/// Goes through the nodes that `of` needs, operands before users.
fn rewritten<'g>(of: &[Sym<'g>], make: impl Fn(usize, Node, &[Option<Sym<'g>>]) -> Sym<'g>) -> Vec<Sym<'g>> {
    let nodes = of[0].graph.nodes();
    let mut needed = vec![false; nodes.len()];
    let mut open: Vec<usize> = of.iter().map(|x| x.expr.node()).collect();
    while let Some(index) = open.pop() {
        if !std::mem::replace(&mut needed[index], true) {
            open.extend(nodes[index].operands().map(Expr::node));
        }
    }
    let mut made: Vec<Option<Sym<'g>>> = vec![None; nodes.len()];
    for index in (0..nodes.len()).filter(|&index| needed[index]) {
        made[index] = Some(make(index, nodes[index], &made));
    }
    of.iter().map(|x| signed(&made, x.expr)).collect()
}

fn slope_of<'g>(
    graph: &'g Graph,
    (index, node): (usize, Node),
    slope: impl Fn(Expr) -> Sym<'g>,
    direction: &impl Fn(Input) -> Option<Sym<'g>>,
) -> Sym<'g> {
    let sym = |e: Expr| Sym::new(graph, e);
    let (own, zero) = (sym(Expr::positive(index)), sym(Expr::ZERO));
    // Nothing is made for what does not change: a root or a quotient might be none.
    if node.operands().next().is_some() && node.operands().all(|e| slope(e).is_zero()) {
        return zero;
    }
    match node {
        Node::Constant(_) => zero,
        Node::Input(input) => direction(input).unwrap_or(zero),
        Node::Add(a, b) => slope(a) + slope(b),
        Node::Mul(a, b) => slope(a) * sym(b) + sym(a) * slope(b),
        Node::Div(a, b) => (slope(a) - own * slope(b)) / sym(b),
        Node::Sqrt(a) => slope(a) * 0.5 / own,
        Node::Sin(a) => slope(a) * sym(a).cos(),
        Node::Cos(a) => -(slope(a) * sym(a).sin()),
        Node::Call(Call::Sin, a) => slope(a) * sym(a).cos_of_any(),
        Node::Call(Call::Cos, a) => -(slope(a) * sym(a).sin_of_any()),
        Node::Call(Call::Exp, a) => slope(a) * own,
        Node::Call(Call::Tanh, a) => slope(a) * (own.constant(1.0) - own * own),
        Node::Call(Call::Abs, a) => slope(a) * sym(a).call(Call::Sign),
        Node::Call(Call::Sign, _) => zero,
        Node::Larger(a, b) => {
            let first = ((sym(a) - sym(b)).call(Call::Sign) + 1.0) * 0.5;
            slope(b) + first * (slope(a) - slope(b))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Dual, Evaluator, Order, lower};
    use bipedc_runtime::{Argument, State};

    /// Every operation, in one expression of two inputs.
    fn everything(graph: &Graph) -> Sym<'_> {
        let [x, y] = [0, 1].map(|k| Sym::new(graph, graph.input(Argument::Q, k)));
        let smooth = (x * y).sin() * (x - y).cos() / (y * y + 1.0) + (x * x + 2.0).sqrt();
        let calls = (y * 0.3).call(Call::Exp) * x.call(Call::Tanh) - (x - y).call(Call::Abs);
        smooth + calls + x.larger(y) * (x.sin() + y).sin_of_any() - x.cos().cos_of_any()
    }

    #[test]
    fn first_and_second_slopes_are_those_of_dual_numbers() {
        let graph = Graph::new();
        let f = everything(&graph);
        let toward = |input: Input| Some(f.constant([0.7, -1.3][input.index as usize]));
        let first = slopes_along(&[f], toward);
        let second = slopes_along(&first, toward);
        let values = |at: [f64; 2], of: &[Sym<'_>]| {
            let outputs: Vec<Expr> = of.iter().map(|x| x.expr).collect();
            let evaluator = Evaluator::new(&lower(&graph, &outputs, Order::Derivation));
            let mut out = vec![0.0; of.len()];
            evaluator.run(&State::new().with(Argument::Q, &at), &mut evaluator.workspace(), &mut out);
            out
        };
        let evaluator = Evaluator::new(&lower(&graph, &[f.expr], Order::Derivation));
        for at in [[0.4, 0.9], [1.1, -0.2], [-0.6, -2.0]] {
            let along = |k: usize, d: f64| Dual(Dual(at[k], d), Dual(d, 0.0));
            let q = [along(0, 0.7), along(1, -1.3)];
            let mut out = [Dual(Dual(0.0, 0.0), Dual(0.0, 0.0))];
            evaluator.run(&State::new().with(Argument::Q, &q), &mut evaluator.workspace(), &mut out);
            let found = values(at, &[first[0], second[0]]);
            assert!((found[0] - out[0].0.1).abs() < 1e-13, "{found:?} {out:?}");
            assert!((found[1] - out[0].1.1).abs() < 1e-12, "{found:?} {out:?}");
        }
    }

    #[test]
    fn replaced_inputs_give_the_function_of_a_function() {
        let graph = Graph::new();
        let f = everything(&graph);
        let angle = Sym::new(&graph, graph.input(Argument::V, 0));
        let inner = |input: Input| (input.argument == Argument::Q && input.index == 0).then(|| angle.sin());
        let of = replaced(&[f], inner);
        let run = |of: Sym<'_>, state: &State<'_, f64>| {
            let evaluator = Evaluator::new(&lower(&graph, &[of.expr], Order::Derivation));
            let mut out = [0.0];
            evaluator.run(state, &mut evaluator.workspace(), &mut out);
            out[0]
        };
        let (q, v) = ([9.0, 0.3], [0.8]);
        let whole = run(of[0], &State::new().with(Argument::Q, &q).with(Argument::V, &v));
        let q = [0.8f64.sin(), 0.3];
        let parts = run(f, &State::new().with(Argument::Q, &q));
        assert!((whole - parts).abs() < 1e-14, "{whole} {parts}");
    }
}
