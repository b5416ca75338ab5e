//! Instructions as statements, with comments that say what they are for.
use super::names::{self, Names};
use super::text::{Text, WIDTH, harmless};
use crate::compile::CompiledModel;
use crate::expression::{Call, Purpose};
use crate::program::{Instruction, Operand, Pair, Program};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Values declared at once. Each `let` opens a scope within the scope before it, and LLVM's debug information
/// follows them by recursion: 4000 overflow its stack in a user's debug build.
const SCOPE: usize = 256;

/// So many instructions in a row for one purpose stand under a comment; fewer have it behind them.
const SECTION: usize = 4;

/// What the text of one program needs to know.
pub struct Code<'a> {
    pub model: &'a CompiledModel,
    pub names: &'a Names,
    pub program: &'a Program,
    /// Of each instruction that is computed together with the next one: how.
    pub pairs: &'a [Option<Pair>],
    angles: Vec<String>,
    stores: Stores,
}

/// Elements of the result that are written as soon as they are known.
#[derive(Debug, Default)]
struct Stores {
    /// Of a value, its places in the result.
    places: BTreeMap<usize, Vec<usize>>,
    /// Values that nothing else needs: they get no name.
    unnamed: BTreeSet<usize>,
    /// Rows of the matrix that is written into; `None`: a function stores them.
    rows: Option<usize>,
}

impl Stores {
    fn of(program: &Program, rows: Option<usize>) -> Self {
        let mut stores = Self { rows, ..Self::default() };
        for (place, &output) in program.outputs.iter().enumerate() {
            if let Operand::Value(k) = output {
                stores.places.entry(k as usize).or_default().push(place);
            }
        }
        let once = stores.places.iter().filter(|(_, places)| places.len() == 1);
        stores.unnamed = once.map(|(&k, _)| k).collect();
        let read = program.instructions.iter().flat_map(Instruction::operands);
        for operand in read.chain(program.angles.iter().copied()) {
            if let Operand::Value(k) = operand {
                stores.unnamed.remove(&(k as usize));
            }
        }
        stores
    }

    fn statement(&self, place: usize, value: &str) -> String {
        match self.rows {
            None => format!("set({place}, {value});"),
            Some(rows) => format!("out[{}][{}] = {value};", place / rows, place % rows),
        }
    }
}

impl<'a> Code<'a> {
    /// `pairs`: of each instruction of the program, or empty.
    pub fn new(
        model: &'a CompiledModel,
        names: &'a Names,
        program: &'a Program,
        pairs: &'a [Option<Pair>],
    ) -> Self {
        let angles = names::angles(names, &program.angles);
        Self { model, names, program, pairs, angles, stores: Stores::default() }
    }

    /// With each entry of the result stored as soon as it is known, into a matrix with so many `rows`, else by `set`: of many
    /// results most would wait in memory until all of them are.
    pub fn storing(self, rows: Option<usize>) -> Self {
        Self { stores: Stores::of(self.program, rows), ..self }
    }

    /// What stores an entry of the result that no instruction computes.
    pub fn store(&self, place: usize) -> String {
        self.stores.statement(place, &self.operand(self.program.outputs[place]))
    }

    pub fn operand(&self, operand: Operand) -> String {
        match operand {
            Operand::Constant(x) => constant(x),
            Operand::Input(argument, k) => self.names.input(argument, k).to_owned(),
            Operand::Sin(k) => format!("sin_{}", self.angles[k as usize]),
            Operand::Cos(k) => format!("cos_{}", self.angles[k as usize]),
            Operand::Value(k) => self.value(k as usize),
        }
    }

    /// Whether instruction `k` is computed together with the next one.
    pub fn is_first(&self, k: usize) -> bool {
        self.pairs.get(k).is_some_and(Option::is_some)
    }

    /// The instruction whose name holds the result of `k`: itself, or the one before that is its twin.
    pub fn declared(&self, k: usize) -> usize {
        k.checked_sub(1).filter(|&before| self.is_first(before)).unwrap_or(k)
    }

    /// The name of what instruction `k` declares.
    pub fn name(&self, k: usize) -> String {
        if self.is_first(k) { Self::pair_name(k) } else { format!("t{k}") }
    }

    fn value(&self, k: usize) -> String {
        let declared = self.declared(k);
        let half = match (self.is_first(declared), declared == k) {
            (false, _) => "",
            (true, true) => ".first()",
            (true, false) => ".second()",
        };
        format!("{}{half}", self.name(declared))
    }

    fn instruction(&self, instruction: &Instruction) -> String {
        let o = |operand| self.operand(operand);
        match *instruction {
            Instruction::Add(a, b) => format!("{} + {}", o(a), o(b)),
            Instruction::Sub(a, b) => format!("{} - {}", o(a), o(b)),
            Instruction::Mul(a, b) => format!("{} * {}", o(a), o(b)),
            Instruction::Div(a, b) => format!("{} / {}", o(a), o(b)),
            Instruction::Neg(a) => format!("-{}", o(a)),
            Instruction::Sqrt(a) => format!("R::sqrt({})", o(a)),
            Instruction::Call(call, a) => function(call, &o(a)),
            Instruction::Larger(a, b) => format!("R::larger({}, {})", o(a), o(b)),
            Instruction::Fused { a, b, c, minus_product, minus_addend } => {
                let (a, c) = (self.signed(a, minus_product), self.signed(c, minus_addend));
                format!("R::fused({a}, {}, {c})", o(b))
            }
        }
    }

    /// What an instruction is for, with its twin.
    fn work(&self, k: usize) -> Work {
        let first = self.declared(k);
        let purpose = self.program.purposes[first];
        if !self.is_first(first) {
            return Work { purpose, twin: None };
        }
        let other = self.program.purposes[first + 1];
        let (purpose, other) = if other.body < purpose.body { (other, purpose) } else { (purpose, other) };
        Work { purpose, twin: other.body.filter(|_| other.body != purpose.body) }
    }

    fn signed(&self, operand: Operand, minus: bool) -> String {
        match (operand, minus) {
            (Operand::Constant(value), true) => constant(-value),
            (_, true) => format!("-{}", self.operand(operand)),
            (_, false) => self.operand(operand),
        }
    }

    /// The instructions of a stretch of the program.
    pub fn statements(&self, text: &mut Text, range: Range<usize>) {
        let mut comments = Comments::new(self, &range);
        self.bindings(text, range, |this, text, k, start| {
            let pair = this.is_first(k);
            let behind = comments.before(this, text, k);
            let places = |k: usize| this.stores.places.get(&k).map_or(&[][..], Vec::as_slice);
            let statement = match places(k) {
                _ if pair => format!("{start}{} = {};", this.name(k), this.pair(k)),
                [place] if this.stores.unnamed.contains(&k) => {
                    this.stores.statement(*place, &this.instruction(&this.program.instructions[k]))
                }
                _ => {
                    format!("{start}{} = {};", this.name(k), this.instruction(&this.program.instructions[k]))
                }
            };
            match behind.map(|work| [comment(this.model, work), short_comment(this.model, work)]) {
                Some([long, _]) if text.fits(&format!("{statement} // {long}")) => {
                    text.line(&format!("{statement} // {long}"));
                }
                // Two at once are long, and the sections around them say where they belong.
                Some([_, short]) if !pair || text.fits(&format!("{statement} // {short}")) => {
                    text.line(&format!("{statement} // {short}"));
                }
                _ => text.line(&statement),
            }
            for k in k..=k + usize::from(pair) {
                let stored = places(k).iter().filter(|_| pair || !this.stores.unnamed.contains(&k));
                stored.for_each(|place| text.line(&this.stores.statement(*place, &this.value(k))));
            }
        });
    }

    /// `let t3 = …;` for each value; long lists declare first (`let (t0, t1);`) and assign then. `write` gets the value
    /// and what its statement begins with.
    pub fn bindings(
        &self,
        text: &mut Text,
        values: impl IntoIterator<Item = usize>,
        mut write: impl FnMut(&Self, &mut Text, usize, &str),
    ) {
        // Of two that are computed together the first stands for both.
        let values: Vec<usize> = values.into_iter().filter(|&k| self.declared(k) == k).collect();
        for chunk in values.chunks(SCOPE) {
            let named = chunk.iter().filter(|&k| self.is_first(*k) || !self.stores.unnamed.contains(k));
            let names: Vec<String> = named.map(|&k| self.name(k)).collect();
            let declared = values.len() > SCOPE && names.len() > 1;
            if declared {
                text.list("let (", &names, ");");
            }
            chunk.iter().for_each(|&k| write(self, text, k, if declared { "" } else { "let " }));
        }
    }
}

/// A number as `R::constant(…)`.
pub fn constant(x: f64) -> String {
    let digits = x.abs().to_string();
    let sign = if x.is_sign_negative() && x != 0.0 { "-" } else { "" };
    let point = if digits.contains('.') { "" } else { ".0" };
    format!("R::constant({sign}{digits}{point})")
}

fn function(call: Call, a: &str) -> String {
    match call {
        Call::Exp => format!("R::exp({a})"),
        Call::Tanh => format!("R::tanh({a})"),
        Call::Abs => format!("R::abs({a})"),
        Call::Sign => format!("R::sign({a})"),
        Call::Sin => format!("::bipedc_runtime::math::sin_cos({a}).0"),
        Call::Cos => format!("::bipedc_runtime::math::sin_cos({a}).1"),
    }
}

/// Says what the instructions of a stretch are for: a comment above those that follow one another, one behind those that
/// stand among others.
struct Comments {
    /// Of each instruction of the stretch: how many from it on have its purpose.
    runs: Vec<usize>,
    first: usize,
    section: Work,
    /// Instructions left of a run that is too short for a section.
    short: usize,
}

impl Comments {
    fn new(code: &Code<'_>, range: &Range<usize>) -> Self {
        let purposes: Vec<Work> = range.clone().map(|k| code.work(k)).collect();
        let mut runs = vec![1; purposes.len()];
        for k in (0..runs.len().saturating_sub(1)).rev() {
            if purposes[k] == purposes[k + 1] {
                runs[k] = runs[k + 1] + 1;
            }
        }
        Self { runs, first: range.start, section: Work::default(), short: 0 }
    }

    /// Writes the comment above the `k`-th instruction, or gives what one behind it has to say.
    fn before(&mut self, code: &Code<'_>, text: &mut Text, k: usize) -> Option<Work> {
        let (purpose, run) = (code.work(k), self.runs[k - self.first]);
        if purpose == self.section {
            return None;
        }
        if self.short == 0 && run < SECTION {
            self.short = run;
        }
        if self.short > 0 {
            // Two of a run are written at once.
            self.short = self.short.saturating_sub(1 + usize::from(code.is_first(k)));
            return Some(purpose);
        }
        self.section = purpose;
        text.line(&format!("// {}", comment(code.model, purpose)));
        None
    }
}

/// What an instruction, or two at once, are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Work {
    purpose: Purpose,
    /// The body of the other one.
    twin: Option<usize>,
}

/// `left_shank: wrench`; of two at once `left_shank, right_shank: wrench`
fn comment(model: &CompiledModel, work: Work) -> String {
    let quantity = if work.purpose.quantity.is_empty() { "other" } else { work.purpose.quantity };
    let bodies = bodies(model, work);
    if bodies.is_empty() { quantity.to_owned() } else { format!("{bodies}: {quantity}") }
}

/// The body alone: for lines that are long.
fn short_comment(model: &CompiledModel, work: Work) -> String {
    let bodies = bodies(model, work);
    if bodies.is_empty() { comment(model, work) } else { bodies }
}

fn bodies(model: &CompiledModel, work: Work) -> String {
    let bodies = [work.purpose.body, work.twin].into_iter().flatten();
    bodies.map(|body| harmless(&model.tree.bodies[body].name)).collect::<Vec<_>>().join(", ")
}

/// What a stretch of a program reads besides its own values.
#[derive(Debug, Default)]
pub struct Reads {
    inputs: BTreeSet<(bipedc_runtime::Argument, u32)>,
    sines: BTreeSet<u32>,
    cosines: BTreeSet<u32>,
}

impl Reads {
    pub fn of(operands: impl Iterator<Item = Operand>) -> Self {
        let mut reads = Self::default();
        for operand in operands {
            match operand {
                Operand::Input(argument, k) => drop(reads.inputs.insert((argument, k))),
                Operand::Sin(k) => drop(reads.sines.insert(k)),
                Operand::Cos(k) => drop(reads.cosines.insert(k)),
                Operand::Constant(_) | Operand::Value(_) => {}
            }
        }
        reads
    }

    /// The inputs that another stretch does not read.
    pub fn without(&self, other: &Self) -> Self {
        Self { inputs: &self.inputs - &other.inputs, ..Self::default() }
    }

    /// The arguments it reads, in the order in which functions take them.
    pub fn arguments(&self) -> impl Iterator<Item = bipedc_runtime::Argument> + '_ {
        let read = |a: &bipedc_runtime::Argument| self.inputs.iter().any(|(argument, _)| argument == a);
        bipedc_runtime::Argument::ALL.into_iter().filter(read)
    }

    pub fn any_sine(&self) -> bool {
        !self.sines.is_empty()
    }

    pub fn any_cosine(&self) -> bool {
        !self.cosines.is_empty()
    }

    /// `let q_left_knee = q[4];` for each input.
    pub fn name_inputs(&self, code: &Code<'_>, text: &mut Text) {
        for &(argument, k) in &self.inputs {
            text.line(&format!("let {} = {}[{k}];", code.names.input(argument, k), argument.name()));
        }
    }

    /// The same for sines and cosines that come as arrays.
    pub fn name_angles(&self, code: &Code<'_>, text: &mut Text) {
        for &k in &self.sines {
            text.line(&format!("let {} = sin[{k}];", code.operand(Operand::Sin(k))));
        }
        for &k in &self.cosines {
            text.line(&format!("let {} = cos[{k}];", code.operand(Operand::Cos(k))));
        }
    }

    /// `let ([sin_q_left_knee, …], [cos_q_left_knee, …]) = R::sin_cos_all([q_left_knee, …]);`
    pub fn sines_and_cosines(&self, code: &Code<'_>, text: &mut Text) {
        let order = code.angles_by_twins();
        if order.is_empty() {
            return;
        }
        let named = |read: &BTreeSet<u32>, name: fn(u32) -> Operand| -> Vec<String> {
            let one = |&k| if read.contains(&k) { code.operand(name(k)) } else { "_".to_owned() };
            order.iter().map(one).collect()
        };
        let (sines, cosines) = (named(&self.sines, Operand::Sin), named(&self.cosines, Operand::Cos));
        let angles: Vec<String> =
            order.iter().map(|&k| code.operand(code.program.angles[k as usize])).collect();
        let (s, c, a) = (sines.join(", "), cosines.join(", "), angles.join(", "));
        let line = format!("let ([{s}], [{c}]) = R::sin_cos_all([{a}]);");
        if line.len() + 8 <= WIDTH {
            text.line(&line);
            return;
        }
        text.open("let (");
        text.list("[", &sines, "],");
        text.list("[", &cosines, "],");
        text.unindent();
        text.list(") = R::sin_cos_all([", &angles, "]);");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Robot;
    use std::path::Path;

    /// Reads the comments as a reader does: above for what follows, behind for one line.
    fn claimed(text: &str) -> Vec<String> {
        let (mut section, mut claims) = (String::new(), Vec::new());
        for line in text.lines().map(str::trim_start) {
            if let Some(words) = line.strip_prefix("// ") {
                section = words.to_owned();
            } else if line.starts_with("let t") && line.contains(" = ")
                || line.starts_with('t') && line.contains(" = ")
            {
                let behind = line.split_once(" // ").map(|(_, words)| words.to_owned());
                claims.push(behind.unwrap_or_else(|| section.clone()));
            }
        }
        claims
    }

    fn check(robot: &str) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(robot);
        let model = Robot::read(&folder).unwrap().compile().unwrap();
        let names = Names::new(&model);
        for f in model.functions.iter().filter(|f| f.program.angles_ready < f.program.instructions.len()) {
            let (code, mut text) = (Code::new(&model, &names, &f.program, &[]), Text::default());
            let range = f.program.angles_ready..f.program.instructions.len();
            code.statements(&mut text, range.clone());
            let claims = claimed(&text.finish());
            assert_eq!(claims.len(), range.len(), "{}", f.name);
            for (claim, &purpose) in claims.iter().zip(&f.program.purposes[range]) {
                let work = Work { purpose, twin: None };
                let (long, short) = (comment(&model, work), short_comment(&model, work));
                let nothing = claim.is_empty() && purpose == Purpose::default();
                assert!(nothing || *claim == long || *claim == short, "{}: {claim}, is {long}", f.name);
            }
        }
    }

    #[test]
    fn comments_say_what_the_program_knows() {
        check("three_link");
        check("tulip_v1_leg");
    }

    /// Every instruction of the recursions has a body or a matrix that it belongs to.
    #[test]
    fn recursions_say_what_everything_is_for() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/tulip");
        let model = Robot::read(&folder).unwrap().compile().unwrap();
        for name in [
            "inverse_dynamics",
            "bias",
            "gravity",
            "mass_matrix",
            "coriolis_matrix",
            "center_of_mass",
            "momentum",
        ] {
            let f = model.functions.iter().find(|f| f.name == name).unwrap();
            let after = &f.program.purposes[f.program.angles_ready..];
            let unsaid = after.iter().filter(|purpose| purpose.quantity.is_empty()).count();
            assert_eq!(unsaid, 0, "{name} of {}", after.len());
        }
    }
}
