//! One program on arrays: arguments in, columns of the result out.
use super::names::Names;
use super::sizes::Size;
use super::split;
use super::statements::{Code, Reads};
use super::text::{Text, WIDTH, harmless};
use crate::compile::{CompiledModel, Function};
use crate::program::{Instruction, Operand, Pair};
use crate::tree::Twins;
use bipedc_runtime::Argument;

/// How a function begins.
pub struct Head<'a> {
    /// With a space behind it, or nothing.
    pub visibility: &'a str,
    pub name: &'a str,
    pub parameters: Vec<String>,
    /// ` -> R`, or nothing.
    pub result: &'a str,
}

impl Head<'_> {
    /// On one line, or with a line for each parameter.
    pub fn open(&self, text: &mut Text) {
        let Self { visibility, name, parameters, result } = self;
        let start = format!("{visibility}fn {name}<R: Real>(");
        let line = format!("{start}{}){result} {{", parameters.join(", "));
        if line.len() <= WIDTH {
            return text.open(&line);
        }
        text.open(&start);
        parameters.iter().for_each(|parameter| text.line(&format!("{parameter},")));
        text.close(&format!("){result} {{"));
        text.indent();
    }

    /// The same of a function that is compiled at all levels of its target, see `bipedc_runtime::dispatch`, if it has enough
    /// `operations` for that to pay. `inline` is the attribute in front of it.
    pub fn open_dispatched(self, operations: usize, inline: &str, text: &mut Text) -> Dispatched {
        let dispatched = Dispatched(operations >= WORTH_CHOOSING);
        if !dispatched.0 {
            text.line(inline);
            self.open(text);
            return dispatched;
        }
        let Self { visibility, name, mut parameters, .. } = self;
        let result = if parameters.last().is_some_and(|parameter| parameter == STORES) {
            parameters.pop();
            " storing set"
        } else {
            ""
        };
        text.line("::bipedc_runtime::dispatched! {");
        text.line(inline);
        Head { visibility, name, parameters, result }.open(text);
        dispatched
    }
}

/// Of an open function: whether it stands in the macro.
#[must_use]
pub struct Dispatched(bool);

impl Dispatched {
    /// The end of the function.
    pub fn close(&self, text: &mut Text) {
        text.close("}");
        if self.0 {
            text.line("}");
        }
    }
}

/// Operations from which on asking for the processor's level costs little beside them; a sine and cosine count as a dozen.
const WORTH_CHOOSING: usize = 24;

/// The parameter that stores results.
const STORES: &str = "mut set: impl FnMut(usize, R)";

/// `q: &[R; NQ]` for each argument.
pub fn parameters(model: &CompiledModel, arguments: impl Iterator<Item = Argument>) -> Vec<String> {
    arguments.map(|a| format!("{}: &[R; {}]", a.name(), Size::of(model, a))).collect()
}

/// Where results go, as a parameter and as an argument of a part: `out: &mut [[R; ROWS]; COLUMNS]`, or a function that stores an entry.
pub fn output_parameter(model: &CompiledModel, function: &Function) -> (String, &'static str) {
    if function.packed {
        return (STORES.to_owned(), "&mut set");
    }
    let (rows, columns) = Size::of_result(model, function);
    (format!("out: &mut [[R; {rows}]; {columns}]"), "out")
}

/// How programs become text.
#[derive(Debug, Clone, Copy)]
pub struct Way<'a> {
    pub names: &'a Names,
    /// Limbs that are computed at once.
    pub twins: &'a Twins,
    /// Instructions in one function.
    pub limit: usize,
}

/// The program as one function, or as several when it has more instructions than the limit; `pairs`: of each instruction.
pub fn program(model: &CompiledModel, way: &Way<'_>, f: &Function, pairs: &[Option<Pair>], text: &mut Text) {
    let (code, p) = (Code::new(model, way.names, &f.program, pairs), &f.program);
    let mut parameters = parameters(model, p.arguments());
    parameters.push(output_parameter(model, f).0);
    let name = format!("{}_program", f.name);
    let head = Head { visibility: "pub(super) ", name: &name, parameters, result: "" };
    if p.instructions.len() > way.limit {
        return split::program(code, f, way.limit, head, text);
    }
    let at_once = stores_at_once(f);
    let code = if at_once { storing(code, f) } else { code };
    let operands = p.instructions.iter().flat_map(Instruction::operands);
    let reads = Reads::of(operands.chain(p.outputs.iter().copied()).chain(p.angles.iter().copied()));
    let open = head.open_dispatched(p.instructions.len() + 12 * p.angles.len(), "#[inline]", text);
    // What only comes behind the sines is read there: they need the registers of x86-64-v3 for themselves.
    let before = p.instructions.iter().take(p.angles_ready).flat_map(Instruction::operands);
    let before = Reads::of(before.chain(p.angles.iter().copied()));
    before.name_inputs(&code, text);
    code.statements(text, 0..p.angles_ready);
    reads.sines_and_cosines(&code, text);
    reads.without(&before).name_inputs(&code, text);
    code.statements(text, p.angles_ready..p.instructions.len());
    if at_once {
        others(&code, 0..p.outputs.len(), text)
    } else if stores_by_twos(f) {
        outputs_by_twos(&code, f, text)
    } else {
        outputs(&code, f, text)
    }
    open.close(text);
}

/// So many computed entries would not stay in registers until the end.
const MANY: usize = 40;

/// Whether entries of the result are stored as soon as they are known.
fn stores_at_once(f: &Function) -> bool {
    let computed = f.program.outputs.iter().filter(|output| matches!(output, Operand::Value(_)));
    f.packed || computed.count() >= MANY
}

/// The code that stores them.
pub fn storing<'a>(code: Code<'a>, f: &Function) -> Code<'a> {
    code.storing((!f.packed).then(|| f.rows.len().max(1)))
}

/// Elements of the result that no instruction computes.
pub fn others(code: &Code<'_>, places: impl IntoIterator<Item = usize>, text: &mut Text) {
    let given = places.into_iter().filter(|place| !matches!(code.program.outputs[*place], Operand::Value(_)));
    given.for_each(|place| text.line(&code.store(place)));
}

/// So many values with a zero beside them are stored together with it.
const MANY_ZEROS: usize = 3;

/// Whether entries of the result are stored two by two: many are a value and a zero, and none are of two columns, which to bring together takes as long as to store
/// both.
fn stores_by_twos(f: &Function) -> bool {
    let zero = |o: &Operand| *o == Operand::Constant(0.0);
    let twos = f.program.outputs.chunks_exact(2);
    let mixed = twos.filter(|two| zero(&two[0]) != zero(&two[1])).count();
    !f.rows.is_empty() && f.rows.len().is_multiple_of(2) && mixed >= MANY_ZEROS
}

/// `store(out, 4, two(…, …));`, two elements after two: as many stores as values take that long.
fn outputs_by_twos(code: &Code<'_>, f: &Function, text: &mut Text) {
    let rows = f.rows.len();
    for (at, pair) in (0..).step_by(2).zip(code.program.outputs.chunks_exact(2)) {
        if let Some(name) = f.columns.get(at / rows).filter(|_| at % rows == 0) {
            text.filled(("// ", "// "), harmless(name).split(' ').map(str::to_owned));
        }
        let [a, b] = [0, 1].map(|k| code.operand(pair[k]));
        let values = if pair[0] == pair[1] { format!("both({a})") } else { format!("two({a}, {b})") };
        text.line(&format!("store(out, {at}, {values});"));
    }
}

/// `*out = [[…], …];`, a line for each column with its name behind.
fn outputs(code: &Code<'_>, f: &Function, text: &mut Text) {
    let elements = |column: &[Operand]| -> Vec<String> {
        // Regressors have many columns without entries.
        if column.len() > 1 && column.iter().all(|&o| o == Operand::Constant(0.0)) {
            return vec![format!("R::constant(0.0); {}", Size::of_result(code.model, f).0)];
        }
        column.iter().map(|&o| code.operand(o)).collect()
    };
    let columns: Vec<Vec<String>> = code.program.outputs.chunks(f.rows.len().max(1)).map(elements).collect();
    if let [column] = columns.as_slice() {
        return text.list("*out = [[", column, "]];");
    }
    text.open("*out = [");
    for (column, name) in columns.iter().zip(&f.columns) {
        let line = format!("[{}], // {}", column.join(", "), harmless(name));
        if text.fits(&line) {
            text.line(&line);
            continue;
        }
        text.filled(("// ", "// "), harmless(name).split(' ').map(str::to_owned));
        text.list("[", column, "],");
    }
    text.close("];");
}
