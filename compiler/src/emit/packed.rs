//! Matrices of which most entries are always zero: the others alone, and the dense matrix on top of them.
use super::program::{Head, parameters};
use super::sizes::Size;
use super::text::Text;
use crate::compile::{CompiledModel, Function};
use crate::program::Operand;

/// The entries of a matrix that are not always zero, column after column.
pub struct Packed {
    /// They as a vector.
    pub entries: Function,
    /// Where each column begins among them, and how many there are.
    starts: Vec<usize>,
    /// The row of each.
    rows: Vec<usize>,
}

impl Packed {
    /// Of a function that is to be packed.
    pub fn of(f: &Function) -> Option<Self> {
        if !f.packed {
            return None;
        }
        let (mut starts, mut rows, mut outputs) = (vec![0], Vec::new(), Vec::new());
        for column in f.program.outputs.chunks(f.rows.len()) {
            let entries = column.iter().enumerate().filter(|(_, o)| **o != Operand::Constant(0.0));
            for (row, &operand) in entries {
                rows.push(row);
                outputs.push(operand);
            }
            starts.push(rows.len());
        }
        let mut entries = f.clone();
        entries.name = format!("{}_nonzeros", f.name);
        entries.rows = (0..rows.len()).map(|k| format!("entry {k}")).collect();
        entries.columns = vec!["value".to_owned()];
        entries.program.outputs = outputs;
        Some(Self { entries, starts, rows })
    }

    fn pattern(f: &Function) -> String {
        format!("{}_SPARSITY", f.name.to_uppercase())
    }

    /// What the vector of entries is.
    pub fn documentation(&self, f: &Function, text: &mut Text) {
        let (count, pattern) = (self.rows.len(), Self::pattern(f));
        let all = f.rows.len() * f.columns.len();
        text.doc("///", &format!("The {count} of {all} entries of [`{}`] that are not always zero.", f.name));
        text.doc("///", "");
        text.doc(
            "///",
            &format!("Column after column, in each by row: [`{pattern}`] says where each one stands."),
        );
        text.doc("///", &format!("{}.", f.operations));
    }

    /// `pub const …_SPARSITY: Sparsity = …;`
    pub fn sparsity(&self, model: &CompiledModel, f: &Function, text: &mut Text) {
        let (rows, columns) = Size::of_result(model, f);
        text.doc("///", &format!("Where the entries of [`{}`] stand.", self.entries.name));
        text.open(&format!("pub const {}: Sparsity<'static> = Sparsity {{", Self::pattern(f)));
        text.line(&format!("rows: {rows},"));
        text.line(&format!("columns: {columns},"));
        let numbers = |list: &[usize]| -> Vec<String> { list.iter().map(usize::to_string).collect() };
        text.list("column_starts: &[", &numbers(&self.starts), "],");
        text.list("row_indices: &[", &numbers(&self.rows), "],");
        text.close("};");
        text.line("");
    }

    /// The program of the dense matrix: that of the entries, which stores them elsewhere.
    pub fn dense(&self, model: &CompiledModel, f: &Function, text: &mut Text) {
        let (count, pattern) = (self.rows.len(), Self::pattern(f));
        let (rows, columns) = Size::of_result(model, f);
        let mut parameters = parameters(model, f.program.arguments());
        parameters.push(format!("out: &mut [[R; {rows}]; {columns}]"));
        let name = format!("{}_program", f.name);
        text.line("#[inline]");
        Head { visibility: "pub(super) ", name: &name, parameters, result: "" }.open(text);
        text.line(&format!("const POSITIONS: [u16; {count}] = {pattern}.positions();"));
        text.line("let out = out.as_flattened_mut();");
        text.line("out.fill(R::constant(0.0));");
        text.open("let set = |k: usize, x: R| {");
        text.open("if let Some(entry) = POSITIONS.get(k).and_then(|at| out.get_mut(usize::from(*at))) {");
        text.line("*entry = x;");
        text.close("}");
        text.close("};");
        let mut passed: Vec<String> = f.program.arguments().map(|a| a.name().to_owned()).collect();
        passed.push("set".to_owned());
        text.list(&format!("{}_program(", self.entries.name), &passed, ");");
        text.close("}");
        text.line("");
    }
}
