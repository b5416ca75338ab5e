//! From expressions to instructions: only what is needed, products fused into sums, in an order that keeps
//! values short-lived.
use super::{Instruction, Operand, Program, schedule};
use crate::expression::{Expr, Graph, Node, Purpose};
use bipedc_runtime::{Argument, Arguments};
use rustc_hash::FxHashMap;

/// In which order operations are written down. Compilers keep it nearly as it is, so it decides how much
/// independent work stands close together and how many values live at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// As derived: recursions over the tree go through both legs in turn, which hides latencies.
    Derivation,
    /// Operands just before their use: few live values, for long eliminations.
    DepthFirst,
    /// By a list scheduler that weighs both.
    Balanced,
}

/// Lowers `outputs` into a program.
pub fn lower(graph: &Graph, outputs: &[Expr], order: Order) -> Program {
    let nodes = graph.nodes();
    let uses = count_uses(&nodes, outputs);
    let mut lowering = Lowering {
        nodes: &nodes,
        purpose_of: &graph.purposes(),
        uses: &uses,
        angle_of: FxHashMap::default(),
        angles: Vec::new(),
        instructions: Vec::new(),
        purposes: Vec::new(),
        value_of: FxHashMap::default(),
        negative_of: FxHashMap::default(),
        negated: negated_outputs(nodes.len(), outputs),
        arguments: Vec::new(),
    };
    let angles = angle_nodes(&nodes, &uses);
    for &angle in &angles {
        let operand = lowering.signed_value(Expr::positive(angle));
        lowering.angle_of.insert(angle, lowering.angles.len() as u32);
        lowering.angles.push(operand);
    }
    let angles_ready = lowering.instructions.len();
    if order == Order::Derivation {
        lowering.in_order_of_derivation();
    }
    let outputs = outputs.iter().map(|&e| lowering.signed_value(e)).collect();
    let arguments = Arguments::of(&lowering.arguments);
    let mut program = Program {
        angles: lowering.angles,
        angles_ready,
        instructions: lowering.instructions,
        purposes: lowering.purposes,
        outputs,
        arguments,
    };
    if order == Order::Balanced {
        schedule(&mut program);
    }
    program
}

/// How often each reachable node is used as an operand or output.
fn count_uses(nodes: &[Node], outputs: &[Expr]) -> Vec<u32> {
    let mut uses = vec![0; nodes.len()];
    for e in outputs {
        uses[e.node()] += 1;
    }
    for index in (0..nodes.len()).rev() {
        if uses[index] > 0 {
            for operand in nodes[index].operands() {
                uses[operand.node()] += 1;
            }
        }
    }
    uses
}

/// Nodes under a sine or cosine that is needed.
fn angle_nodes(nodes: &[Node], uses: &[u32]) -> Vec<usize> {
    let mut angles: Vec<usize> = (0..nodes.len())
        .filter(|&i| uses[i] > 0)
        .filter_map(|i| match nodes[i] {
            Node::Sin(e) | Node::Cos(e) => Some(e.node()),
            _ => None,
        })
        .collect();
    angles.sort_unstable();
    angles.dedup();
    angles
}

/// Nodes that stand among the outputs with a minus sign alone: their sums are written with the signs of all terms exchanged.
fn negated_outputs(nodes: usize, outputs: &[Expr]) -> Vec<bool> {
    let mut negated = vec![false; nodes];
    outputs.iter().filter(|e| e.is_negated()).for_each(|e| negated[e.node()] = true);
    outputs.iter().filter(|e| !e.is_negated()).for_each(|e| negated[e.node()] = false);
    negated
}

/// An operand and whether it stands for its negative.
type Signed = (Operand, bool);

struct Lowering<'a> {
    nodes: &'a [Node],
    purpose_of: &'a [Purpose],
    uses: &'a [u32],
    angle_of: FxHashMap<usize, u32>,
    angles: Vec<Operand>,
    instructions: Vec<Instruction>,
    purposes: Vec<Purpose>,
    /// Of each node, which can be the negative of its value: a sign is no operation of its own.
    value_of: FxHashMap<usize, Signed>,
    /// Negatives that were needed as operands.
    negative_of: FxHashMap<usize, Operand>,
    /// Nodes whose negatives are wanted.
    negated: Vec<bool>,
    arguments: Vec<Argument>,
}

impl Lowering<'_> {
    /// `node`: of the graph, that the instruction belongs to.
    fn push(&mut self, node: usize, instruction: Instruction) -> Operand {
        self.instructions.push(instruction);
        self.purposes.push(self.purpose_of[node]);
        Operand::Value(self.instructions.len() as u32 - 1)
    }

    /// The operand of an edge whose node has a value.
    fn signed(&self, e: Expr) -> Signed {
        let (operand, negative) = self.value_of[&e.node()];
        (operand, negative != e.is_negated())
    }

    /// An edge as an operand, negated where it has to be.
    fn signed_value(&mut self, e: Expr) -> Operand {
        self.compute(e);
        match self.signed(e) {
            (Operand::Constant(x), true) => Operand::Constant(-x),
            (operand, true) => {
                if let Some(&negative) = self.negative_of.get(&e.node()) {
                    return negative;
                }
                let negative = self.push(e.node(), Instruction::Neg(operand));
                self.negative_of.insert(e.node(), negative);
                negative
            }
            (operand, false) => operand,
        }
    }

    /// Computes everything in the order in which it was derived.
    fn in_order_of_derivation(&mut self) {
        let mut fused = vec![false; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            if let (Node::Add(a, b), true) = (node, self.uses[index] > 0) {
                if self.fusible(*b).is_some() {
                    fused[b.node()] = true;
                } else if self.fusible(*a).is_some() {
                    fused[a.node()] = true;
                }
            }
        }
        for (index, fused) in fused.into_iter().enumerate() {
            if self.uses[index] > 0 && !fused {
                self.compute(Expr::positive(index));
            }
        }
    }

    /// Gives a node its value; depth first with an explicit stack, since chains grow long.
    fn compute(&mut self, e: Expr) {
        let mut stack = vec![e.node()];
        while let Some(&top) = stack.last() {
            if self.value_of.contains_key(&top) {
                stack.pop();
                continue;
            }
            let missing: Vec<usize> =
                self.needs(top).into_iter().filter(|n| !self.value_of.contains_key(n)).collect();
            if missing.is_empty() {
                let signed = self.emit(top);
                self.value_of.insert(top, signed);
                stack.pop();
            } else {
                // The last one pushed is computed first.
                stack.extend(missing.into_iter().rev());
            }
        }
    }

    /// A product that only this sum uses can be fused into it.
    fn fusible(&self, e: Expr) -> Option<(Expr, Expr)> {
        match self.nodes[e.node()] {
            Node::Mul(a, b) if self.uses[e.node()] == 1 => Some((a, b)),
            _ => None,
        }
    }

    /// Nodes that must have values before `index` can be emitted.
    fn needs(&self, index: usize) -> Vec<usize> {
        match self.nodes[index] {
            Node::Sin(_) | Node::Cos(_) => Vec::new(),
            Node::Add(a, b) => match (self.fusible(a), self.fusible(b)) {
                (_, Some((x, y))) => vec![a.node(), x.node(), y.node()],
                (Some((x, y)), None) => vec![b.node(), x.node(), y.node()],
                (None, None) => vec![a.node(), b.node()],
            },
            node => node.operands().map(Expr::node).collect(),
        }
    }

    fn emit(&mut self, index: usize) -> Signed {
        let operand = match self.nodes[index] {
            Node::Constant(x) => Operand::Constant(x),
            Node::Input(input) => {
                self.arguments.push(input.argument);
                Operand::Input(input.argument, input.index)
            }
            Node::Sin(e) => Operand::Sin(self.angle_of[&e.node()]),
            Node::Cos(e) => Operand::Cos(self.angle_of[&e.node()]),
            Node::Mul(a, b) => return self.emit_product(index, (a, b), Instruction::Mul),
            Node::Div(a, b) => return self.emit_product(index, (a, b), Instruction::Div),
            Node::Sqrt(a) => {
                let operand = self.signed_value(a);
                self.push(index, Instruction::Sqrt(operand))
            }
            Node::Call(call, a) => {
                let operand = self.signed_value(a);
                self.push(index, Instruction::Call(call, operand))
            }
            Node::Larger(a, b) => {
                let (a, b) = (self.signed_value(a), self.signed_value(b));
                self.push(index, Instruction::Larger(a, b))
            }
            Node::Add(a, b) => return self.emit_sum(index, a, b),
        };
        (operand, false)
    }

    fn emit_product(
        &mut self,
        index: usize,
        (a, b): (Expr, Expr),
        of: fn(Operand, Operand) -> Instruction,
    ) -> Signed {
        let ((a, minus_a), (b, minus_b)) = (self.signed(a), self.signed(b));
        (self.push(index, of(a, b)), minus_a != minus_b)
    }

    fn emit_sum(&mut self, index: usize, a: Expr, b: Expr) -> Signed {
        let (product, addend) = match (self.fusible(a), self.fusible(b)) {
            (_, Some(factors)) => ((factors, b.is_negated()), a),
            (Some(factors), None) => ((factors, a.is_negated()), b),
            (None, None) => return self.emit_plain_sum(index, a, b),
        };
        let ((x, y), minus) = product;
        let ((x, minus_x), (y, minus_y), (c, minus_c)) =
            (self.signed(x), self.signed(y), self.signed(addend));
        let negative = self.negated[index];
        let instruction = Instruction::Fused {
            a: x,
            b: y,
            c,
            minus_product: negative ^ minus ^ minus_x ^ minus_y,
            minus_addend: negative ^ minus_c,
        };
        (self.push(index, instruction), negative)
    }

    fn emit_plain_sum(&mut self, index: usize, a: Expr, b: Expr) -> Signed {
        let ((a, minus_a), (b, minus_b)) = (self.signed(a), self.signed(b));
        if minus_a == minus_b {
            return (self.push(index, Instruction::Add(a, b)), minus_a);
        }
        let negative = self.negated[index];
        let difference = if minus_b != negative { Instruction::Sub(a, b) } else { Instruction::Sub(b, a) };
        (self.push(index, difference), negative)
    }
}
