//! Very long programs as several functions.
//!
//! rustc takes more than linear time for a function: 30 000 instructions on end cost minutes. Parts of a few
//! thousand, never inlined, hand values on through a workspace; every operation stays as it was, so the
//! results have the same bits.
use super::program::{Head, others, output_parameter, parameters, storing};
use super::statements::{Code, Reads, constant};
use super::text::Text;
use crate::compile::Function;
use crate::program::{Instruction, Operand, Pair, Program};
use std::ops::Range;

/// A value and its place in the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Slot {
    value: u32,
    place: usize,
}

#[derive(Debug, Clone, PartialEq)]
struct FunctionPart {
    instructions: Range<usize>,
    /// Values of earlier parts that it needs.
    loads: Vec<Slot>,
    /// Values that later parts need.
    stores: Vec<Slot>,
    /// Indices of the outputs it writes.
    outputs: Vec<usize>,
}

struct Plan {
    parts: Vec<FunctionPart>,
    /// How many parts run before the sines and cosines.
    before: usize,
    /// Places of the angles that are computed.
    angles: Vec<Slot>,
    /// Length of the workspace.
    places: usize,
}

/// Cuts `range` into pieces of nearly equal length, none longer than `limit`, or by one where the border would part twins.
fn cut(range: Range<usize>, limit: usize, pairs: &[Option<Pair>]) -> Vec<Range<usize>> {
    let count = range.len().div_ceil(limit.max(1));
    let at = |k: usize| {
        let border = range.start + k * range.len() / count;
        let parts_twins = border > range.start && pairs.get(border - 1).is_some_and(Option::is_some);
        border + usize::from(parts_twins)
    };
    (0..count).map(|k| at(k)..at(k + 1)).collect()
}

fn values(operands: impl Iterator<Item = Operand>) -> Vec<u32> {
    let mut list: Vec<u32> = operands
        .filter_map(|o| match o {
            Operand::Value(k) => Some(k),
            _ => None,
        })
        .collect();
    list.sort_unstable();
    list.dedup();
    list
}

fn operands(p: &Program, range: &Range<usize>) -> impl Iterator<Item = Operand> {
    p.instructions[range.clone()].iter().flat_map(Instruction::operands)
}

impl Plan {
    fn new(p: &Program, limit: usize, pairs: &[Option<Pair>]) -> Self {
        let mut ranges = cut(0..p.angles_ready, limit, pairs);
        let before = ranges.len();
        ranges.extend(cut(p.angles_ready..p.instructions.len(), limit, pairs));
        if ranges.len() == before {
            // Outputs may consist of sines alone.
            ranges.push(p.instructions.len()..p.instructions.len());
        }
        let needs: Vec<Vec<u32>> = ranges.iter().map(|range| values(operands(p, range))).collect();
        let mut last_part = vec![0; p.instructions.len()];
        for (part, values) in needs.iter().enumerate() {
            values.iter().for_each(|&v| last_part[v as usize] = part);
        }
        let angles = values(p.angles.iter().copied());
        // Angles are read after the parts before them have run.
        angles.iter().for_each(|&v| last_part[v as usize] = last_part[v as usize].max(before));
        let mut plan = Self { parts: Vec::new(), before, angles: Vec::new(), places: 0 };
        plan.assign(p, ranges, &needs, &last_part, &angles);
        plan
    }

    /// Gives places to the values that cross a border; a place is free again after the last part that reads it.
    fn assign(
        &mut self,
        p: &Program,
        ranges: Vec<Range<usize>>,
        needs: &[Vec<u32>],
        last_part: &[usize],
        angles: &[u32],
    ) {
        let mut alive: Vec<Slot> = Vec::new();
        let mut free: Vec<usize> = Vec::new();
        let last = ranges.len() - 1;
        for (k, range) in ranges.into_iter().enumerate() {
            if k == self.before {
                self.angles = alive.iter().copied().filter(|slot| angles.contains(&slot.value)).collect();
            }
            let loads: Vec<Slot> =
                alive.iter().copied().filter(|slot| needs[k].binary_search(&slot.value).is_ok()).collect();
            let (dead, still): (Vec<Slot>, Vec<Slot>) =
                alive.into_iter().partition(|slot| last_part[slot.value as usize] <= k);
            alive = still;
            free.extend(dead.iter().map(|slot| slot.place));
            let mut stores = Vec::new();
            for value in range.clone().filter(|&v| last_part[v] > k) {
                let place = free.pop().unwrap_or_else(|| {
                    self.places += 1;
                    self.places - 1
                });
                stores.push(Slot { value: value as u32, place });
            }
            alive.extend(&stores);
            let written = |o: &Operand| match o {
                Operand::Value(v) => range.contains(&(*v as usize)),
                _ => k == last,
            };
            let outputs = (0..p.outputs.len()).filter(|&o| written(&p.outputs[o])).collect();
            self.parts.push(FunctionPart { instructions: range, loads, stores, outputs });
        }
    }
}

/// One part as a function; what it is called with.
fn part(code: &Code<'_>, f: &Function, plan: &Plan, index: usize, text: &mut Text) -> String {
    let (p, part) = (code.program, &plan.parts[index]);
    let reads = Reads::of(operands(p, &part.instructions).chain(part.outputs.iter().map(|&o| p.outputs[o])));
    let mut taken = parameters(code.model, reads.arguments());
    let mut passed: Vec<&str> = reads.arguments().map(|a| a.name()).collect();
    let count = p.angles.len();
    let (output, out) = output_parameter(code.model, f);
    let (loaded, stored) = (!part.loads.is_empty(), !part.stores.is_empty());
    for (taken_too, parameter, argument) in [
        (reads.any_sine(), format!("sin: &[R; {count}]"), "&sin"),
        (reads.any_cosine(), format!("cos: &[R; {count}]"), "&cos"),
        (loaded || stored, format!("w: &mut [R; {}]", plan.places), "&mut w"),
        (!part.outputs.is_empty(), output, out),
    ] {
        if taken_too {
            taken.push(parameter);
            passed.push(argument);
        }
    }
    let name = format!("{}_part_{index}", f.name);
    let head = Head { visibility: "", name: &name, parameters: taken, result: "" };
    let open = head.open_dispatched(part.instructions.len(), "#[inline(never)]", text);
    reads.name_inputs(code, text);
    reads.name_angles(code, text);
    part_body(code, part, text);
    open.close(text);
    format!("{name}({});", passed.join(", "))
}

fn part_body(code: &Code<'_>, part: &FunctionPart, text: &mut Text) {
    let place = |value: usize| part.loads.iter().find(|slot| slot.value as usize == value).map(|s| s.place);
    let mut loads: Vec<usize> = part.loads.iter().map(|slot| code.declared(slot.value as usize)).collect();
    loads.dedup();
    code.bindings(text, loads, |code, text, k, start| {
        let name = code.name(k);
        match (place(k), code.is_first(k).then(|| place(k + 1)).flatten()) {
            (Some(a), Some(b)) => text.line(&format!("{start}{name} = two(w[{a}], w[{b}]);")),
            (Some(a), None) | (None, Some(a)) if code.is_first(k) => {
                text.line(&format!("{start}{name} = both(w[{a}]);"));
            }
            (a, _) => text.line(&format!("{start}{name} = w[{}];", a.unwrap_or(0))),
        }
    });
    code.statements(text, part.instructions.clone());
    for slot in &part.stores {
        text.line(&format!("w[{}] = {};", slot.place, code.operand(Operand::Value(slot.value))));
    }
    others(code, part.outputs.iter().copied(), text);
}

/// Sines and cosines between the parts.
fn trigonometry(code: &Code<'_>, plan: &Plan, text: &mut Text) {
    let p = code.program;
    if p.angles.is_empty() {
        return;
    }
    let angle = |&o: &Operand| match o {
        Operand::Input(argument, k) => format!("{}[{k}]", argument.name()),
        Operand::Value(v) => {
            let slot = plan.angles.iter().find(|slot| slot.value == v).expect("angles have places");
            format!("w[{}]", slot.place)
        }
        Operand::Constant(x) => constant(x),
        Operand::Sin(_) | Operand::Cos(_) => unreachable!("angles come before all sines and cosines"),
    };
    let angles: Vec<String> = p.angles.iter().map(angle).collect();
    let operands = p.instructions.iter().flat_map(Instruction::operands);
    let reads = Reads::of(operands.chain(p.outputs.iter().copied()));
    let sin = if reads.any_sine() { "sin" } else { "_" };
    let cos = if reads.any_cosine() { "cos" } else { "_" };
    text.list(&format!("let ({sin}, {cos}) = R::sin_cos_all(["), &angles, "]);");
}

/// The program as parts of at most `limit` instructions, and the function that calls them in turn, whose head is given.
pub fn program(code: Code<'_>, f: &Function, limit: usize, head: Head<'_>, text: &mut Text) {
    let code = &storing(code, f);
    let plan = Plan::new(code.program, limit, code.pairs);
    let calls: Vec<String> = (0..plan.parts.len()).map(|k| part(code, f, &plan, k, text)).collect();
    let (before, after) = calls.split_at(plan.before);
    let open = head.open_dispatched(12 * code.program.angles.len(), "#[inline]", text);
    if plan.places > 0 {
        text.line(&format!("let mut w = [R::constant(0.0); {}];", plan.places));
    }
    before.iter().for_each(|call| text.line(call));
    trigonometry(code, &plan, text);
    after.iter().for_each(|call| text.line(call));
    open.close(text);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::Purpose;
    use bipedc_runtime::{Argument, Arguments};

    /// Every value is used by its neighbour and by one far away; angles and outputs are computed.
    fn program() -> Program {
        let value = Operand::Value;
        let first = Operand::Input(Argument::Q, 0);
        let instructions = (0..200u32).map(|k| match k {
            0 => Instruction::Neg(first),
            10 => Instruction::Add(Operand::Sin(1), value(9)),
            _ => Instruction::Mul(value(k - 1), value(k.saturating_sub(k * 7 % 90 + 1).min(k - 1))),
        });
        Program {
            angles: vec![value(3), value(9), first],
            angles_ready: 10,
            instructions: instructions.collect(),
            purposes: vec![Purpose::default(); 200],
            outputs: vec![value(5), Operand::Constant(0.0), value(199), Operand::Cos(0), value(5)],
            arguments: Arguments::of(&[Argument::Q]),
        }
    }

    fn check(limit: usize) {
        let p = program();
        let plan = Plan::new(&p, limit, &[]);
        let mut workspace = vec![u32::MAX; plan.places];
        let (mut next, mut written) = (0, Vec::new());
        for (k, part) in plan.parts.iter().enumerate() {
            assert!(part.instructions.len() <= limit && part.instructions.start == next);
            next = part.instructions.end;
            if k == plan.before {
                assert_eq!((next > 10, plan.angles.len()), (true, 2));
                assert!(plan.angles.iter().all(|slot| workspace[slot.place] == slot.value));
            }
            for slot in &part.loads {
                assert_eq!(workspace[slot.place], slot.value, "part {k} of limit {limit}");
            }
            for value in values(operands(&p, &part.instructions)) {
                let own = part.instructions.contains(&(value as usize));
                assert!(own || part.loads.iter().any(|slot| slot.value == value));
            }
            part.stores.iter().for_each(|slot| workspace[slot.place] = slot.value);
            written.extend(&part.outputs);
        }
        written.sort_unstable();
        assert_eq!((next, written), (200, vec![0, 1, 2, 3, 4]));
        assert!(plan.places < 120, "places are used again: {}", plan.places);
    }

    #[test]
    fn parts_find_their_values_in_the_workspace() {
        [1, 2, 3, 7, 10, 50, 199].into_iter().for_each(check);
    }
}
