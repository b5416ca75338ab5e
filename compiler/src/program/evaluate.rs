//! Running a program in process, on any scalar: one state, or several in lanes.
use super::{Instruction, Operand, Program};
use crate::expression::Call;
use crate::tree::Twins;
use bipedc_runtime::lanes::F64x8;
use bipedc_runtime::math::sin_cos;
use bipedc_runtime::{Argument, Real, State};
use rustc_hash::FxHashMap;
use std::ops::Range;
use std::sync::Arc;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Code {
    Add,
    Sub,
    Mul,
    Div,
    Neg,
    Sqrt,
    Call(Call),
    Larger,
    /// a·b + c and its three signed forms
    Fused,
    FusedMinusProduct,
    FusedMinusAddend,
    FusedMinusBoth,
}

/// An operation's places in the workspace.
#[derive(Debug, Clone, Copy)]
struct Step {
    to: u32,
    a: u32,
    b: u32,
    c: u32,
}

/// Steps of one operation after the other: it is looked up once for all of them.
#[derive(Debug, Clone)]
struct Run {
    code: Code,
    steps: Vec<Step>,
}

/// A program with every operand resolved to a place in one workspace.
#[derive(Debug, Clone)]
pub struct Evaluator {
    constants: Vec<f64>,
    /// (place, argument, element)
    inputs: Vec<(u32, Argument, u32)>,
    angles: Vec<u32>,
    first_sine: usize,
    before_angles: Vec<Run>,
    after_angles: Vec<Run>,
    outputs: Vec<u32>,
    workspace: usize,
    often: Arc<super::often::Often>,
}

/// Gives out places in the workspace and takes them back after the last use.
struct Places {
    of_value: Vec<u32>,
    free: Vec<u32>,
    next: u32,
}

impl Places {
    fn take(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.next += 1;
            self.next - 1
        })
    }
}

impl Evaluator {
    /// Resolves the operands of `program`.
    pub fn new(program: &Program) -> Self {
        Self::of_limbs(program, None)
    }

    /// The same of a robot with limbs of the same make: as machine code it computes for both at once, which changes no bit.
    pub fn with_twins(program: &Program, twins: &Arc<Twins>) -> Self {
        Self::of_limbs(program, Some(twins))
    }

    fn of_limbs(program: &Program, twins: Option<&Arc<Twins>>) -> Self {
        let mut layout = Layout::new(program);
        let (before, after) = (0..program.angles_ready, program.angles_ready..program.instructions.len());
        let order: Vec<usize> =
            [before, after].into_iter().flat_map(|range| grouped(program, range)).collect();
        let mut last_use = last_uses(program, &order);
        let mut places =
            Places { of_value: vec![0; program.instructions.len()], free: Vec::new(), next: layout.size };
        let mut runs = [Vec::new(), Vec::new()];
        for &index in &order {
            let instruction = &program.instructions[index];
            let at = |operand| layout.place(&places, operand);
            let operands: Vec<u32> = instruction.operands().map(at).collect();
            for operand in instruction.operands() {
                if let Operand::Value(k) = operand
                    && last_use[k as usize] == index
                {
                    places.free.push(places.of_value[k as usize]);
                    // An operand may stand twice in one instruction; its place is free once.
                    last_use[k as usize] = usize::MAX;
                }
            }
            let to = places.take();
            places.of_value[index] = to;
            let operand = |k: usize| operands.get(k).copied().unwrap_or(0);
            let step = Step { to, a: operand(0), b: operand(1), c: operand(2) };
            let half: &mut Vec<Run> = &mut runs[usize::from(index >= program.angles_ready)];
            match half.last_mut() {
                Some(run) if run.code == code(instruction) => run.steps.push(step),
                _ => half.push(Run { code: code(instruction), steps: vec![step] }),
            }
        }
        let [before_angles, after_angles] = runs;
        Self {
            angles: program.angles.iter().map(|&o| layout.place(&places, o)).collect(),
            first_sine: layout.first_sine as usize,
            before_angles,
            after_angles,
            outputs: program.outputs.iter().map(|&o| layout.place(&places, o)).collect(),
            workspace: places.next as usize,
            constants: std::mem::take(&mut layout.constants),
            often: Arc::new(super::often::Often::new(program, &layout.inputs, twins)),
            inputs: layout.inputs,
        }
    }

    /// A workspace for repeated calls.
    pub fn workspace<R: Real>(&self) -> Vec<R> {
        let mut workspace = vec![R::constant(0.0); self.workspace];
        for (place, &value) in workspace.iter_mut().zip(&self.constants) {
            *place = R::constant(value);
        }
        workspace
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Runs the program on one state, with a workspace of its own: as machine code once it was called so often that making that pays. Lengths as below.
    pub fn run_one(&self, state: &State<'_, f64>, output: &mut [f64]) {
        if self.often.run(state, output) {
            return;
        }
        self.run(state, &mut self.workspace(), output);
    }

    /// The same on eight states side by side.
    pub fn run_eight(&self, state: &State<'_, F64x8>, output: &mut [F64x8]) {
        if !self.often.run_eight(state, output) {
            self.run(state, &mut self.workspace(), output);
        }
    }

    /// Whether [`Self::run_one`] runs machine code by now.
    pub fn is_machine_code(&self) -> bool {
        self.often.is_made()
    }

    /// Bytes that the machine code takes with its constants and the memory of a call; 0 as long as it is interpreted.
    pub fn machine_code_bytes(&self) -> usize {
        self.often.bytes()
    }

    /// Runs the program on `count` states, where that pays as machine code: `input` gives an element of an argument of a state, `output` takes eight states'
    /// values of each output from a state on. `false`: nothing was done.
    pub(super) fn run_many(
        &self,
        count: usize,
        input: impl Fn(usize, Argument, usize) -> f64,
        mut output: impl FnMut(usize, usize, &[f64; 8]),
    ) -> bool {
        let Some(native) = self.often.of_eight(count) else { return false };
        let places = self.often.places();
        let mut memory = vec![[0.0; 8]; native.memory()];
        let mut results = vec![[0.0; 8]; self.outputs.len()];
        for first in (0..count).step_by(8) {
            for (place, (argument, element)) in memory.iter_mut().zip(&places) {
                // The last state fills lanes that would be empty.
                *place =
                    std::array::from_fn(|i| input((first + i).min(count - 1), *argument, *element as usize));
            }
            native.run_eight(&mut memory, &mut results);
            results.iter().enumerate().for_each(|(k, result)| output(first, k, result));
        }
        true
    }

    /// Runs the program. The slices of `state` must be as long as the model says, `output` as long as
    /// [`Self::outputs`], and `workspace` from [`Self::workspace`].
    pub fn run<R: Real>(&self, state: &State<'_, R>, workspace: &mut [R], output: &mut [R]) {
        for &(place, argument, element) in &self.inputs {
            workspace[place as usize] = state.get(argument)[element as usize];
        }
        run_steps(&self.before_angles, workspace);
        for (k, &angle) in self.angles.iter().enumerate() {
            let ([sine], [cosine]) = R::sin_cos_all([workspace[angle as usize]]);
            workspace[self.first_sine + 2 * k] = sine;
            workspace[self.first_sine + 2 * k + 1] = cosine;
        }
        run_steps(&self.after_angles, workspace);
        for (out, &place) in output.iter_mut().zip(&self.outputs) {
            *out = workspace[place as usize];
        }
    }
}

fn run_steps<R: Real>(runs: &[Run], w: &mut [R]) {
    for Run { code, steps } in runs {
        match *code {
            Code::Add => each(steps, w, |a, b, _| a + b),
            Code::Sub => each(steps, w, |a, b, _| a - b),
            Code::Mul => each(steps, w, |a, b, _| a * b),
            Code::Div => each(steps, w, |a, b, _| a / b),
            Code::Neg => each(steps, w, |a, _, _| -a),
            Code::Sqrt => each(steps, w, |a, _, _| a.sqrt()),
            Code::Call(function) => each(steps, w, |a, _, _| call(function, a)),
            Code::Larger => each(steps, w, |a, b, _| a.larger(b)),
            Code::Fused => each(steps, w, |a, b, c| R::fused(a, b, c)),
            Code::FusedMinusProduct => each(steps, w, |a, b, c| R::fused(-a, b, c)),
            Code::FusedMinusAddend => each(steps, w, |a, b, c| R::fused(a, b, -c)),
            Code::FusedMinusBoth => each(steps, w, |a, b, c| R::fused(-a, b, -c)),
        }
    }
}

#[inline(always)]
fn each<R: Real>(steps: &[Step], w: &mut [R], operation: impl Fn(R, R, R) -> R) {
    for step in steps {
        w[step.to as usize] = operation(w[step.a as usize], w[step.b as usize], w[step.c as usize]);
    }
}

fn call<R: Real>(call: Call, x: R) -> R {
    match call {
        Call::Exp => x.exp(),
        Call::Tanh => x.tanh(),
        Call::Abs => x.abs(),
        Call::Sign => x.sign(),
        Call::Sin => sin_cos(x).0,
        Call::Cos => sin_cos(x).1,
    }
}

fn code(instruction: &Instruction) -> Code {
    match instruction {
        Instruction::Add(..) => Code::Add,
        Instruction::Sub(..) => Code::Sub,
        Instruction::Mul(..) => Code::Mul,
        Instruction::Div(..) => Code::Div,
        Instruction::Neg(_) => Code::Neg,
        Instruction::Sqrt(_) => Code::Sqrt,
        Instruction::Call(call, _) => Code::Call(*call),
        Instruction::Larger(..) => Code::Larger,
        Instruction::Fused { minus_product, minus_addend, .. } => match (minus_product, minus_addend) {
            (false, false) => Code::Fused,
            (true, false) => Code::FusedMinusProduct,
            (false, true) => Code::FusedMinusAddend,
            (true, true) => Code::FusedMinusBoth,
        },
    }
}

/// The instructions of a range in another order that computes the same: equal operations after one another as far as
/// operands allow.
fn grouped(program: &Program, range: Range<usize>) -> Vec<usize> {
    let values = |index: usize| {
        program.instructions[index].operands().filter_map(|operand| match operand {
            Operand::Value(k) => Some(k as usize),
            _ => None,
        })
    };
    let mut missing = vec![0; range.len()];
    let mut users = vec![Vec::new(); range.len()];
    for index in range.clone() {
        for value in values(index).filter(|value| range.contains(value)) {
            missing[index - range.start] += 1;
            users[value - range.start].push(index);
        }
    }
    let mut ready: Vec<(Code, Vec<usize>)> = Vec::new();
    let add = |ready: &mut Vec<(Code, Vec<usize>)>, index: usize| {
        let code = code(&program.instructions[index]);
        match ready.iter_mut().find(|(other, _)| *other == code) {
            Some((_, list)) => list.push(index),
            None => ready.push((code, vec![index])),
        }
    };
    range.clone().filter(|index| missing[index - range.start] == 0).for_each(|index| add(&mut ready, index));
    let mut order = Vec::with_capacity(range.len());
    while let Some(most) =
        (0..ready.len()).max_by_key(|&k| ready[k].1.len()).filter(|&k| !ready[k].1.is_empty())
    {
        // What becomes ready meanwhile and is of the same kind joins the run.
        while !ready[most].1.is_empty() {
            for index in std::mem::take(&mut ready[most].1) {
                order.push(index);
                for user in std::mem::take(&mut users[index - range.start]) {
                    missing[user - range.start] -= 1;
                    if missing[user - range.start] == 0 {
                        add(&mut ready, user);
                    }
                }
            }
        }
    }
    order
}

/// The instruction that uses each value last in this order; outputs and angles are never given up.
fn last_uses(program: &Program, order: &[usize]) -> Vec<usize> {
    let mut last = vec![usize::MAX; program.instructions.len()];
    for &index in order {
        for operand in program.instructions[index].operands() {
            if let Operand::Value(k) = operand {
                last[k as usize] = index;
            }
        }
    }
    for operand in program.outputs.iter().chain(&program.angles) {
        if let Operand::Value(k) = operand {
            last[*k as usize] = usize::MAX;
        }
    }
    last
}

/// Places of everything that is not computed: constants first, then inputs, then sines and cosines.
struct Layout {
    constants: Vec<f64>,
    constant_places: FxHashMap<u64, u32>,
    inputs: Vec<(u32, Argument, u32)>,
    input_places: FxHashMap<(Argument, u32), u32>,
    first_sine: u32,
    size: u32,
}

impl Layout {
    fn new(program: &Program) -> Self {
        let mut layout = Self {
            constants: Vec::new(),
            constant_places: FxHashMap::default(),
            inputs: Vec::new(),
            input_places: FxHashMap::default(),
            first_sine: 0,
            size: 0,
        };
        let operands: Vec<Operand> = program
            .instructions
            .iter()
            .flat_map(Instruction::operands)
            .chain(program.outputs.iter().copied())
            .chain(program.angles.iter().copied())
            .collect();
        for operand in &operands {
            if let Operand::Constant(x) = operand {
                let next = layout.constants.len() as u32;
                if *layout.constant_places.entry(x.to_bits()).or_insert(next) == next {
                    layout.constants.push(*x);
                }
            }
        }
        layout.size = layout.constants.len() as u32;
        for operand in &operands {
            if let Operand::Input(argument, element) = *operand {
                let next = layout.size;
                if *layout.input_places.entry((argument, element)).or_insert(next) == next {
                    layout.inputs.push((next, argument, element));
                    layout.size += 1;
                }
            }
        }
        layout.first_sine = layout.size;
        layout.size += 2 * program.angles.len() as u32;
        layout
    }

    fn place(&self, places: &Places, operand: Operand) -> u32 {
        match operand {
            Operand::Constant(x) => self.constant_places[&x.to_bits()],
            Operand::Input(argument, element) => self.input_places[&(argument, element)],
            Operand::Sin(k) => self.first_sine + 2 * k,
            Operand::Cos(k) => self.first_sine + 2 * k + 1,
            Operand::Value(k) => places.of_value[k as usize],
        }
    }
}
