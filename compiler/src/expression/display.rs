//! Expressions as people write them: infix, with names for what is used twice.
use super::graph::Graph;
use super::node::{Expr, Input, Node};
use std::collections::HashMap;

/// Expressions in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// Shared subexpressions, each before its first use: (name, text).
    pub shared: Vec<(String, String)>,
    /// One per expression asked for.
    pub outputs: Vec<String>,
}

/// Writes expressions; `name` gives the names of run-time values.
///
/// Recursive in the depth of the expressions: meant for small ones.
pub fn write_infix(graph: &Graph, outputs: &[Expr], name: &dyn Fn(Input) -> String) -> Written {
    let nodes = graph.nodes();
    let mut writer = Writer { nodes: &nodes, name, named: HashMap::new() };
    let mut shared = Vec::new();
    for node in shared_nodes(&nodes, outputs) {
        let text = writer.node(node).0;
        let label = format!("t{}", shared.len() + 1);
        writer.named.insert(node, label.clone());
        shared.push((label, text));
    }
    Written { shared, outputs: outputs.iter().map(|&e| writer.sum(e).0).collect() }
}

/// Nodes worth a name, operands before users: used more than once and more than a leaf or its sine.
fn shared_nodes(nodes: &[Node], outputs: &[Expr]) -> Vec<usize> {
    let mut uses = vec![0_usize; nodes.len()];
    for output in outputs {
        uses[output.node()] += 1;
    }
    // Users come after their operands, so every count is complete when its node is reached.
    for index in (0..nodes.len()).rev() {
        if uses[index] > 0 {
            nodes[index].operands().for_each(|operand| uses[operand.node()] += 1);
        }
    }
    let is_leaf = |e: Expr| matches!(nodes[e.node()], Node::Input(_) | Node::Constant(_));
    let worth = |index: usize| match nodes[index] {
        Node::Constant(_) | Node::Input(_) => false,
        Node::Sin(e) | Node::Cos(e) => !is_leaf(e),
        Node::Mul(a, b) => !(is_leaf(a) && is_leaf(b)),
        _ => true,
    };
    (0..nodes.len()).filter(|&index| uses[index] > 1 && worth(index)).collect()
}

/// How tightly a text holds together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Sum,
    Product,
    Atom,
}

struct Writer<'a> {
    nodes: &'a [Node],
    name: &'a dyn Fn(Input) -> String,
    named: HashMap<usize, String>,
}

impl Writer<'_> {
    /// With its sign.
    fn sum(&self, e: Expr) -> (String, Level) {
        match self.terms(e, false).as_slice() {
            [(false, node)] => self.node_or_name(*node),
            // A sign in front binds like a product.
            [only] => (self.sum_of(&[*only]), Level::Product),
            several => (self.sum_of(several), Level::Sum),
        }
    }

    /// The summands of `e`, sums of sums flattened: (negative, node).
    fn terms(&self, e: Expr, negated: bool) -> Vec<(bool, usize)> {
        let negative = e.is_negated() != negated;
        match self.nodes[e.node()] {
            Node::Add(a, b) if !self.named.contains_key(&e.node()) => {
                let mut terms = self.terms(a, negative);
                terms.extend(self.terms(b, negative));
                // `b - a` reads better than `-a + b`.
                if let Some(first) = terms.iter().position(|(negative, _)| !negative) {
                    terms[..=first].rotate_right(1);
                }
                terms
            }
            _ => vec![(negative, e.node())],
        }
    }

    fn factors(&self, e: Expr) -> Vec<usize> {
        match self.nodes[e.node()] {
            Node::Mul(a, b) if !self.named.contains_key(&e.node()) => {
                let mut factors = self.factors(a);
                factors.extend(self.factors(b));
                factors
            }
            _ => vec![e.node()],
        }
    }

    fn node_or_name(&self, node: usize) -> (String, Level) {
        self.named.get(&node).map_or_else(|| self.node(node), |name| (name.clone(), Level::Atom))
    }

    /// A node without looking at its own name.
    fn node(&self, node: usize) -> (String, Level) {
        let call = |f: &str, e: Expr| (format!("{f}({})", self.sum(e).0), Level::Atom);
        match self.nodes[node] {
            Node::Constant(x) => (number(x), Level::Atom),
            Node::Input(input) => ((self.name)(input), Level::Atom),
            Node::Add(..) => (self.sum_of(&self.terms(Expr::positive(node), false)), Level::Sum),
            Node::Mul(..) => (self.product(&self.factors(Expr::positive(node))), Level::Product),
            Node::Div(a, b) => (format!("{}/{}", self.tight(a), self.tight(b)), Level::Product),
            Node::Sqrt(e) => call("sqrt", e),
            Node::Sin(e) => call("sin", e),
            Node::Cos(e) => call("cos", e),
            Node::Call(function, e) => call(function.name(), e),
            Node::Larger(a, b) => (format!("max({}, {})", self.sum(a).0, self.sum(b).0), Level::Atom),
        }
    }

    fn sum_of(&self, terms: &[(bool, usize)]) -> String {
        let mut text = String::new();
        for (index, &(negative, term)) in terms.iter().enumerate() {
            text += match (index, negative) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            };
            let (term, level) = self.node_or_name(term);
            text += &if level == Level::Sum { format!("({term})") } else { term };
        }
        text
    }

    /// Constants first, equal factors as powers.
    fn product(&self, factors: &[usize]) -> String {
        let is_constant = |node: &usize| matches!(self.nodes[*node], Node::Constant(_));
        let mut ordered: Vec<usize> = factors.iter().copied().filter(is_constant).collect();
        ordered.extend(factors.iter().copied().filter(|node| !is_constant(node)));
        let mut powers: Vec<(usize, usize)> = Vec::new();
        for node in ordered {
            match powers.iter_mut().find(|(other, _)| *other == node) {
                Some((_, power)) => *power += 1,
                None => powers.push((node, 1)),
            }
        }
        let one = |&(node, power): &(usize, usize)| {
            let (text, level) = self.node_or_name(node);
            let text = if level < Level::Atom { format!("({text})") } else { text };
            if power > 1 { format!("{text}^{power}") } else { text }
        };
        powers.iter().map(one).collect::<Vec<_>>().join(" ")
    }

    fn tight(&self, e: Expr) -> String {
        let (text, level) = self.sum(e);
        if level < Level::Atom { format!("({text})") } else { text }
    }
}

/// At most twelve significant digits: the rest is rounding dust of the derivation.
fn number(x: f64) -> String {
    let short = x.to_string();
    if short.len() <= 13 {
        return short;
    }
    let rounded: f64 = format!("{x:.11e}").parse().unwrap_or(x);
    if (1e-4..1e9).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_runtime::Argument;

    fn write(graph: &Graph, outputs: &[Expr]) -> Written {
        write_infix(graph, outputs, &|input| ["a", "b", "c"][input.index as usize].to_owned())
    }

    #[test]
    fn signs_sums_and_products_read_like_formulas() {
        let g = Graph::new();
        let [a, b, c] = [0, 1, 2].map(|k| g.input(Argument::Q, k));
        let difference = g.sub(b, g.add(a, c));
        assert_eq!(write(&g, &[difference]).outputs, ["b - a - c"]);
        let product = g.mul(g.constant(-2.0), g.mul(g.sin(a), g.add(b, c)));
        assert_eq!(write(&g, &[product]).outputs, ["-2 sin(a) (b + c)"]);
        let square = g.add(g.mul(g.mul(a, a), b), g.div(-c, g.add(a, b)));
        assert_eq!(write(&g, &[square]).outputs, ["b a^2 - c/(a + b)"]);
    }

    #[test]
    fn what_is_used_twice_gets_a_name() {
        let g = Graph::new();
        let [a, b, c] = [0, 1, 2].map(|k| g.input(Argument::Q, k));
        let sum = g.add(a, b);
        let written = write(&g, &[g.mul(sum, c), g.sin(sum), g.sin(a), g.mul(g.sin(a), b)]);
        assert_eq!(written.shared, [("t1".to_owned(), "a + b".to_owned())]);
        assert_eq!(written.outputs, ["c t1", "sin(t1)", "sin(a)", "b sin(a)"]);
    }
}
