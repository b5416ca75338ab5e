//! Very long programs as several functions.
//!
//! rustc takes more than linear time for a function: 30 000 instructions on end cost minutes. Parts of a few
//! thousand, never inlined, hand values on through a workspace; every operation stays as it was, so the
//! results have the same bits.
use super::function::ident;
use super::program::{
    Reads, bindings, constant, operand, output_parameter, parameters, program_name, statements,
};
use crate::compile::{CompiledModel, Function};
use crate::program::{Instruction, Operand, Program};
use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};
use std::ops::Range;

/// A value and its place in the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Slot {
    value: u32,
    place: usize,
}

#[derive(Debug, Clone, PartialEq)]
struct Part {
    instructions: Range<usize>,
    /// Values of earlier parts that it needs.
    loads: Vec<Slot>,
    /// Values that later parts need.
    stores: Vec<Slot>,
    /// Indices of the outputs it writes.
    outputs: Vec<usize>,
}

struct Plan {
    parts: Vec<Part>,
    /// How many parts run before the sines and cosines.
    before: usize,
    /// Places of the angles that are computed.
    angles: Vec<Slot>,
    /// Length of the workspace.
    places: usize,
}

/// Cuts `range` into pieces of nearly equal length, none longer than `limit`.
fn cut(range: Range<usize>, limit: usize) -> Vec<Range<usize>> {
    let count = range.len().div_ceil(limit.max(1));
    let at = |k: usize| range.start + k * range.len() / count;
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
    fn new(p: &Program, limit: usize) -> Self {
        let mut ranges = cut(0..p.angles_ready, limit);
        let before = ranges.len();
        ranges.extend(cut(p.angles_ready..p.instructions.len(), limit));
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
            self.parts.push(Part { instructions: range, loads, stores, outputs });
        }
    }
}

/// The names a part may take besides the robot's arguments.
fn extras(p: &Program, part: &Part, reads: &Reads) -> (bool, bool, bool, bool) {
    let workspace = !part.loads.is_empty() || !part.stores.is_empty();
    (reads.any_sine() && !p.angles.is_empty(), reads.any_cosine(), workspace, !part.outputs.is_empty())
}

/// One part as a function, and the call of it.
fn part(model: &CompiledModel, f: &Function, plan: &Plan, index: usize) -> (TokenStream, TokenStream) {
    let (p, part) = (&f.program, &plan.parts[index]);
    let reads = Reads::of(operands(p, &part.instructions).chain(part.outputs.iter().map(|&o| p.outputs[o])));
    let (sines, cosines, workspace, out) = extras(p, part, &reads);
    let (mut taken, mut passed, mut opened) = (Vec::new(), Vec::new(), Vec::new());
    let count = p.angles.len();
    let length = Literal::usize_unsuffixed(count);
    if sines {
        let pattern = reads.sine_pattern(count);
        taken.push(quote!(sin: &[R; #length]));
        passed.push(quote!(&sin));
        opened.push(quote!(let &#pattern = sin;));
    }
    if cosines {
        let pattern = reads.cosine_pattern(count);
        taken.push(quote!(cos: &[R; #length]));
        passed.push(quote!(&cos));
        opened.push(quote!(let &#pattern = cos;));
    }
    if workspace {
        let places = Literal::usize_unsuffixed(plan.places);
        taken.push(quote!(w: &mut [R; #places]));
        passed.push(quote!(&mut w));
    }
    if out {
        taken.push(output_parameter(f));
        passed.push(quote!(out));
    }
    let name = format_ident!("{}_part_{index}", f.name);
    let parameters = parameters(model, reads.arguments());
    let arguments = reads.arguments().map(|a| ident(a.name()));
    let (inputs, body) = (reads.destructured(model), part_body(f, part));
    let function = quote! {
        #[inline(never)]
        fn #name<R: ::bipedc_runtime::Real>(#parameters #(#taken),*) {
            #inputs
            #(#opened)*
            #body
        }
    };
    (function, quote!(#name(#(#arguments,)* #(#passed),*);))
}

fn part_body(f: &Function, part: &Part) -> TokenStream {
    let p = &f.program;
    let place = |slot: &Slot| (operand(Operand::Value(slot.value)), Literal::usize_unsuffixed(slot.place));
    let loads: Vec<(TokenStream, TokenStream)> = part
        .loads
        .iter()
        .map(|slot| {
            let (name, place) = place(slot);
            (name, quote!(w[#place]))
        })
        .collect();
    let (loads, statements) = (bindings(&loads), statements(p, part.instructions.clone()));
    let stores = part.stores.iter().map(|slot| {
        let (name, place) = place(slot);
        quote!(w[#place] = #name;)
    });
    let rows = f.rows.len().max(1);
    let outputs = part.outputs.iter().map(|&o| {
        let (value, row, column) =
            (operand(p.outputs[o]), Literal::usize_unsuffixed(o % rows), Literal::usize_unsuffixed(o / rows));
        quote!(out[#column][#row] = #value;)
    });
    quote! {
        #loads
        #statements
        #(#stores)*
        #(#outputs)*
    }
}

/// Sines and cosines between the parts.
fn trigonometry(p: &Program, plan: &Plan, used: (bool, bool)) -> TokenStream {
    if p.angles.is_empty() {
        return TokenStream::new();
    }
    let angles = p.angles.iter().map(|&o| match o {
        Operand::Input(argument, k) => {
            let (name, k) = (ident(argument.name()), Literal::u32_unsuffixed(k));
            quote!(#name[#k])
        }
        Operand::Value(v) => {
            let slot = plan.angles.iter().find(|slot| slot.value == v).expect("angles have places");
            let place = Literal::usize_unsuffixed(slot.place);
            quote!(w[#place])
        }
        Operand::Constant(x) => constant(x),
        Operand::Sin(_) | Operand::Cos(_) => unreachable!("angles come before all sines and cosines"),
    });
    let sin = if used.0 { quote!(sin) } else { quote!(_) };
    let cos = if used.1 { quote!(cos) } else { quote!(_) };
    quote!(let (#sin, #cos) = R::sin_cos_all([#(#angles),*]);)
}

/// The program as parts of at most `limit` instructions, and the function that calls them in turn.
pub fn program(model: &CompiledModel, f: &Function, limit: usize) -> TokenStream {
    let p = &f.program;
    let plan = Plan::new(p, limit);
    let (functions, calls): (Vec<TokenStream>, Vec<TokenStream>) =
        (0..plan.parts.len()).map(|k| part(model, f, &plan, k)).unzip();
    let (before, after) = calls.split_at(plan.before);
    let everything =
        || operands(p, &(0..p.instructions.len())).chain(p.outputs.iter().copied()).collect::<Vec<_>>();
    let reads = Reads::of(everything().into_iter());
    let trigonometry = trigonometry(p, &plan, (reads.any_sine(), reads.any_cosine()));
    let workspace = if plan.places > 0 {
        let places = Literal::usize_unsuffixed(plan.places);
        quote!(let mut w = [R::constant(0.0); #places];)
    } else {
        TokenStream::new()
    };
    let (name, parameters, out) = (program_name(f), parameters(model, p.arguments()), output_parameter(f));
    quote! {
        #(#functions)*
        #[inline]
        pub(super) fn #name<R: ::bipedc_runtime::Real>(#parameters #out) {
            #workspace
            #(#before)*
            #trigonometry
            #(#after)*
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
            outputs: vec![value(5), Operand::Constant(0.0), value(199), Operand::Cos(0), value(5)],
            arguments: Arguments::of(&[Argument::Q]),
        }
    }

    fn check(limit: usize) {
        let p = program();
        let plan = Plan::new(&p, limit);
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
