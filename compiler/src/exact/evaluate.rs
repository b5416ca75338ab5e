//! Evaluation of expressions over any arithmetic.
use super::arithmetic::{Angle, Arithmetic};
use crate::expression::{Expr, Graph, Input, Node};
use std::collections::BTreeMap;

/// Values of the run-time inputs.
#[derive(Debug, Clone)]
pub struct Assignment<V> {
    /// Numbers.
    pub values: BTreeMap<Input, V>,
    /// Sine and cosine of those inputs that are angles.
    pub angles: BTreeMap<Input, Angle<V>>,
}

impl<V> Default for Assignment<V> {
    fn default() -> Self {
        Self { values: BTreeMap::new(), angles: BTreeMap::new() }
    }
}

/// The nodes that some outputs need, prepared for many evaluations in one arithmetic.
pub struct Evaluator<A: Arithmetic> {
    /// The arithmetic.
    pub arithmetic: A,
    nodes: Vec<Node>,
    needed: Vec<bool>,
    /// Whether sine and cosine of the node are needed.
    is_angle: Vec<bool>,
    constants: Vec<Option<A::Value>>,
    constant_angles: Vec<Option<Angle<A::Value>>>,
    outputs: Vec<Expr>,
}

impl<A: Arithmetic> Evaluator<A> {
    /// Prepares `outputs`.
    ///
    /// # Errors
    /// A sentence: sine or cosine of something that is not a sum of angles, or a number that this field
    /// cannot hold.
    pub fn new(arithmetic: A, graph: &Graph, outputs: &[Expr]) -> Result<Self, String> {
        let nodes = graph.nodes();
        let (needed, is_angle) = requirements(&nodes, outputs);
        let mut constants = vec![None; nodes.len()];
        let mut constant_angles = vec![None; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            let Node::Constant(value) = *node else { continue };
            if needed[index] {
                constants[index] =
                    Some(arithmetic.constant(value).ok_or_else(|| {
                        format!("the number {value} has a denominator that the prime divides")
                    })?);
            }
            if is_angle[index] {
                constant_angles[index] =
                    Some(arithmetic.constant_angle(value).ok_or_else(|| {
                        format!("the angle {value} rad has no rational sine in this field")
                    })?);
            }
        }
        for (index, node) in nodes.iter().enumerate() {
            let sum = matches!(node, Node::Add(..) | Node::Input(_) | Node::Constant(_));
            if is_angle[index] && !sum && doubled(&nodes, index).is_none() {
                return Err("sine or cosine of something that is not a sum of angles".to_owned());
            }
        }
        Ok(Self {
            arithmetic,
            nodes,
            needed,
            is_angle,
            constants,
            constant_angles,
            outputs: outputs.to_vec(),
        })
    }

    /// The inputs that are read.
    pub fn inputs(&self) -> impl Iterator<Item = Input> {
        self.nodes.iter().enumerate().filter_map(|(index, node)| match node {
            Node::Input(input) if self.needed[index] || self.is_angle[index] => Some(*input),
            _ => None,
        })
    }

    /// The outputs; `None` at a pole, at a missing input, or where a square root does not exist.
    pub fn run(&self, assignment: &Assignment<A::Value>) -> Option<Vec<A::Value>> {
        let a = &self.arithmetic;
        let mut values = vec![a.zero(); self.nodes.len()];
        let mut angles = vec![(a.zero(), a.one()); self.nodes.len()];
        for index in 0..self.nodes.len() {
            if self.is_angle[index] {
                angles[index] = self.angle(index, &angles, assignment)?;
            }
            if self.needed[index] {
                values[index] = self.value(index, &values, &angles, assignment)?;
            }
        }
        Some(self.outputs.iter().map(|&e| self.signed(&values, e)).collect())
    }

    fn signed(&self, values: &[A::Value], e: Expr) -> A::Value {
        let value = values[e.node()];
        if e.is_negated() { self.arithmetic.neg(value) } else { value }
    }

    fn value(
        &self,
        index: usize,
        values: &[A::Value],
        angles: &[Angle<A::Value>],
        assignment: &Assignment<A::Value>,
    ) -> Option<A::Value> {
        let (a, v) = (&self.arithmetic, |e| self.signed(values, e));
        match self.nodes[index] {
            Node::Constant(_) => self.constants[index],
            Node::Input(input) => assignment.values.get(&input).copied(),
            Node::Add(x, y) => Some(a.add(v(x), v(y))),
            Node::Mul(x, y) => Some(a.mul(v(x), v(y))),
            Node::Div(x, y) => a.div(v(x), v(y)),
            Node::Sqrt(x) => a.sqrt(v(x)),
            Node::Sin(x) => Some(angles[x.node()].0),
            Node::Cos(x) => Some(angles[x.node()].1),
            // Effects are no part of the rigid-body model that is analysed.
            Node::Call(..) | Node::Larger(..) => None,
        }
    }

    fn angle(
        &self,
        index: usize,
        angles: &[Angle<A::Value>],
        assignment: &Assignment<A::Value>,
    ) -> Option<Angle<A::Value>> {
        let a = &self.arithmetic;
        let angle = |e: Expr| {
            let (s, c) = angles[e.node()];
            if e.is_negated() { (a.neg(s), c) } else { (s, c) }
        };
        match self.nodes[index] {
            Node::Constant(_) => self.constant_angles[index],
            Node::Input(input) => assignment.angles.get(&input).copied(),
            Node::Add(x, y) => Some(a.add_angles(angle(x), angle(y))),
            _ => doubled(&self.nodes, index).map(|x| a.add_angles(angle(x), angle(x))),
        }
    }
}

/// The operand of `2 x`: how the graph writes `x + x`.
fn doubled(nodes: &[Node], index: usize) -> Option<Expr> {
    let Node::Mul(x, y) = nodes[index] else { return None };
    let is_two = |e: Expr| nodes[e.node()] == Node::Constant(2.0);
    if is_two(x) { Some(y) } else { is_two(y).then_some(x) }
}

/// Which nodes are needed as numbers, and which as angles.
fn requirements(nodes: &[Node], outputs: &[Expr]) -> (Vec<bool>, Vec<bool>) {
    let mut needed = vec![false; nodes.len()];
    let mut is_angle = vec![false; nodes.len()];
    for e in outputs {
        needed[e.node()] = true;
    }
    for index in (0..nodes.len()).rev() {
        let trigonometric = matches!(nodes[index], Node::Sin(_) | Node::Cos(_));
        for operand in nodes[index].operands() {
            needed[operand.node()] |= needed[index] && !trigonometric;
            is_angle[operand.node()] |= is_angle[index] || (needed[index] && trigonometric);
        }
    }
    (needed, is_angle)
}

#[cfg(test)]
mod tests {
    use super::super::arithmetic::Rounded;
    use super::super::field::Field;
    use super::*;
    use bipedc_runtime::Argument;

    fn input(index: u32) -> Input {
        Input { argument: Argument::Q, index }
    }

    #[test]
    fn sums_of_angles_follow_the_addition_formulas() {
        let graph = Graph::exact();
        let (x, y) = (graph.input(Argument::Q, 0), graph.input(Argument::Q, 1));
        let sum = graph.sub(graph.add(graph.add(x, x), graph.constant(0.3)), y);
        let outputs = [graph.sin(sum), graph.cos(-sum), graph.add(graph.sin(x), x)];
        let evaluator = Evaluator::new(Rounded, &graph, &outputs).unwrap();
        let mut assignment = Assignment::default();
        for (k, angle) in [(0, 0.7_f64), (1, -1.1)] {
            assignment.values.insert(input(k), angle);
            assignment.angles.insert(input(k), angle.sin_cos());
        }
        let expected = [2.8_f64.sin(), 2.8_f64.cos(), 0.7_f64.sin() + 0.7];
        for (a, b) in evaluator.run(&assignment).unwrap().iter().zip(expected) {
            assert!((a - b).abs() < 1e-14);
        }
    }

    #[test]
    fn other_arguments_of_a_sine_are_refused() {
        let graph = Graph::exact();
        let x = graph.input(Argument::Q, 0);
        let field = Field::all().next().unwrap();
        assert!(Evaluator::new(field, &graph, &[graph.sin(graph.mul(x, x))]).is_err());
    }
}
