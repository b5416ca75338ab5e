//! A regressor of many states at once, without its zeros: for parameters from logs.
use bipedc_analysis::compare::Batch;
use bipedc_analysis::identify::BatchRegressor;
use bipedc_compiler::program::{Evaluator, Instruction, Operand, Program};
use bipedc_runtime::lanes::F64x8;
use bipedc_runtime::{Argument, Real, State};

/// Chosen columns of a compiled regressor.
pub struct ProgramRegressor {
    evaluator: Evaluator,
    pattern: Vec<Vec<usize>>,
    nq: usize,
    nv: usize,
}

impl ProgramRegressor {
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
}

/// The program without instructions that no output needs.
fn alive(program: &Program) -> Program {
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
    let kept = program.instructions.iter().zip(&needed).filter(|(_, needed)| **needed);
    Program {
        angles: program.angles.iter().map(|&o| renamed(o)).collect(),
        angles_ready: program.angles_ready,
        instructions: kept.map(|(instruction, _): (&Instruction, _)| instruction.renamed(renamed)).collect(),
        outputs: program.outputs.iter().map(|&o| renamed(o)).collect(),
        arguments: program.arguments,
    }
}

impl BatchRegressor for ProgramRegressor {
    fn nq(&self) -> usize {
        self.nq
    }
    fn nv(&self) -> usize {
        self.nv
    }
    fn pattern(&self) -> &[Vec<usize>] {
        &self.pattern
    }
    fn evaluate(&self, batch: &Batch<'_>, out: &mut [f64]) {
        // More states than a register holds: what interpreting a step costs is shared by all of them.
        const LANES: usize = 8;
        let mut workspace = self.evaluator.workspace::<F64x8>();
        let zero = F64x8::constant(0.0);
        let mut lanes = [vec![zero; self.nq], vec![zero; self.nv], vec![zero; self.nv]];
        let mut results = vec![zero; self.evaluator.outputs()];
        for first in (0..batch.count).step_by(LANES) {
            let count = LANES.min(batch.count - first);
            for (lanes, values) in lanes.iter_mut().zip([batch.q, batch.v, batch.a]) {
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
                out[k * batch.count + first..][..count].copy_from_slice(&values[..count]);
            }
        }
    }
}
