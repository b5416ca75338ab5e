//! A program over many states at once: in lanes, or one after the other in one workspace.
use super::{Evaluator, Instruction, Operand, Program};
use bipedc_runtime::lanes::F64x8;
use bipedc_runtime::{Argument, Real, State};

/// Chosen columns of a compiled regressor, without their zeros.
pub struct BatchColumns {
    evaluator: Evaluator,
    pattern: Vec<Vec<usize>>,
    nq: usize,
    nv: usize,
}

impl BatchColumns {
    /// The columns `chosen` of `program`, which has `nv` rows and gives them column after column.
    pub fn new(program: &Program, (nq, nv): (usize, usize), chosen: &[usize]) -> Self {
        let at = |row: usize, column: usize| program.outputs[column * nv + row];
        let zero = |operand: Operand| matches!(operand, Operand::Constant(x) if x == 0.0);
        let pattern: Vec<Vec<usize>> =
            (0..nv).map(|row| (0..chosen.len()).filter(|&k| !zero(at(row, chosen[k]))).collect()).collect();
        let row_outputs = |(row, columns): (usize, &Vec<usize>)| {
            columns.iter().map(|&k| at(row, chosen[k])).collect::<Vec<_>>()
        };
        let outputs = pattern.iter().enumerate().flat_map(row_outputs).collect();
        let program = alive(&Program { outputs, ..program.clone() });
        Self { evaluator: Evaluator::new(&program), pattern, nq, nv }
    }

    /// Of each row, the chosen columns that are not always zero.
    pub fn pattern(&self) -> &[Vec<usize>] {
        &self.pattern
    }
    /// Numbers of coordinates of `q` and `v`.
    pub fn coordinates(&self) -> (usize, usize) {
        (self.nq, self.nv)
    }

    /// One row after the other, of each the columns of [`pattern`](Self::pattern), of each all states: `q` is `count × nq`, `v`
    /// and `a` are `count × nv`, state after state.
    pub fn evaluate(&self, total: usize, [q, v, a]: [&[f64]; 3], out: &mut [f64]) {
        // More states than a register holds: what interpreting a step costs is shared by all of them.
        const LANES: usize = 8;
        let element = |state: usize, argument: Argument, k: usize| match argument {
            Argument::Q => q[state * self.nq + k],
            Argument::V => v[state * self.nv + k],
            Argument::A => a[state * self.nv + k],
            _ => 0.0,
        };
        let write = |first: usize, k: usize, values: &[f64; LANES]| {
            let count = LANES.min(total - first);
            out[k * total + first..][..count].copy_from_slice(&values[..count]);
        };
        if self.evaluator.run_many(total, element, write) {
            return;
        }
        let mut workspace = self.evaluator.workspace::<F64x8>();
        let zero = F64x8::constant(0.0);
        let mut lanes = [vec![zero; self.nq], vec![zero; self.nv], vec![zero; self.nv]];
        let mut results = vec![zero; self.evaluator.outputs()];
        for first in (0..total).step_by(LANES) {
            let count = LANES.min(total - first);
            for (lanes, values) in lanes.iter_mut().zip([q, v, a]) {
                let width = lanes.len();
                for (k, lane) in lanes.iter_mut().enumerate() {
                    // The last sample fills lanes that would be empty.
                    *lane = F64x8::from_array(std::array::from_fn(|i| {
                        values[(first + i.min(count - 1)) * width + k]
                    }));
                }
            }
            let state = State::new()
                .with(Argument::Q, &lanes[0])
                .with(Argument::V, &lanes[1])
                .with(Argument::A, &lanes[2]);
            self.evaluator.run(&state, &mut workspace, &mut results);
            for (k, result) in results.iter().enumerate() {
                let values: [f64; LANES] = result.to_array();
                out[k * total + first..][..count].copy_from_slice(&values[..count]);
            }
        }
    }
}

/// The program without instructions that no output needs.
pub(super) fn alive(program: &Program) -> Program {
    let mut needed = vec![false; program.instructions.len()];
    // Angles are few, and their places are numbered: they stay.
    needed[..program.angles_ready].fill(true);
    for operand in program.outputs.iter().chain(&program.angles) {
        if let Operand::Value(k) = operand {
            needed[*k as usize] = true;
        }
    }
    for index in (0..needed.len()).rev().filter(|&i| i >= program.angles_ready) {
        if needed[index] {
            for operand in program.instructions[index].operands() {
                if let Operand::Value(k) = operand {
                    needed[k as usize] = true;
                }
            }
        }
    }
    let mut places = Vec::with_capacity(needed.len());
    let mut next = 0;
    for &needed in &needed {
        places.push(next);
        next += u32::from(needed);
    }
    let renamed = |operand: Operand| match operand {
        Operand::Value(k) => Operand::Value(places[k as usize]),
        other => other,
    };
    let purposes = program.purposes.iter().zip(&needed).filter(|(_, needed)| **needed);
    let kept = program.instructions.iter().zip(&needed).filter(|(_, needed)| **needed);
    Program {
        angles: program.angles.iter().map(|&o| renamed(o)).collect(),
        angles_ready: program.angles_ready,
        instructions: kept.map(|(instruction, _): (&Instruction, _)| instruction.renamed(renamed)).collect(),
        purposes: purposes.map(|(&purpose, _)| purpose).collect(),
        outputs: program.outputs.iter().map(|&o| renamed(o)).collect(),
        arguments: program.arguments,
    }
}

/// A program of q, v and a, evaluated in one workspace.
pub struct BatchStates {
    evaluator: Evaluator,
    nq: usize,
    nv: usize,
}

impl BatchStates {
    /// For a robot with so many coordinates in `q` and `v`.
    pub fn new(program: &Program, (nq, nv): (usize, usize)) -> Self {
        Self { evaluator: Evaluator::new(program), nq, nv }
    }
    /// Numbers of coordinates of `q` and `v`.
    pub fn coordinates(&self) -> (usize, usize) {
        (self.nq, self.nv)
    }
    /// The outputs, `nv` per state; `q` is `count × nq`, `v` and `a` are `count × nv`, state after state.
    pub fn evaluate(&self, count: usize, [q, v, a]: [&[f64]; 3], out: &mut [f64]) {
        let (nq, nv) = (self.nq, self.nv);
        let element = |state: usize, argument: Argument, k: usize| match argument {
            Argument::Q => q[state * nq + k],
            Argument::V => v[state * nv + k],
            Argument::A => a[state * nv + k],
            _ => 0.0,
        };
        let write = |first: usize, k: usize, values: &[f64; 8]| {
            let places = out[first * nv..count * nv].chunks_exact_mut(nv);
            places.zip(values).for_each(|(state, value)| state[k] = *value);
        };
        if self.evaluator.run_many(count, element, write) {
            return;
        }
        for (i, out) in out.chunks_exact_mut(nv.max(1)).enumerate().take(count) {
            let state = State::new()
                .with(Argument::Q, &q[i * nq..(i + 1) * nq])
                .with(Argument::V, &v[i * nv..(i + 1) * nv])
                .with(Argument::A, &a[i * nv..(i + 1) * nv]);
            self.evaluator.run_one(&state, out);
        }
    }
}
