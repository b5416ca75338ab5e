//! All functions of a robot, its constants, and its implementation of [`bipedc_runtime::Model`].
use super::function::{function, ident};
use super::layout;
use super::names::Names;
use super::packed::Packed;
use super::program::Way;
use super::sizes::Size;
use super::text::{Text, quoted};
use crate::compile::{CompiledModel, Function};
use crate::tree::Twins;
use bipedc_runtime::Argument;
use std::collections::BTreeSet;

/// What the emitted items look like.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Name of the type that stands for the robot.
    pub type_name: String,
    /// Programs with more instructions are split: rustc takes more than linear time for long functions.
    pub split_above: usize,
    /// What limbs of the same make have in common is computed for both at once; else for one after the other, with the same bits.
    pub limbs_together: bool,
}

impl Options {
    /// Instructions in one emitted function; measured in `emit/split.rs`.
    pub const SPLIT_ABOVE: usize = 4000;

    /// The usual form, for this type.
    pub fn new(type_name: &str) -> Self {
        Self { type_name: type_name.to_owned(), split_above: Self::SPLIT_ABOVE, limbs_together: true }
    }
}

/// A model as Rust. The type itself is the caller's.
pub struct Model {
    /// (module name, items), in order: one per family of functions, then the trait's.
    pub modules: Vec<(String, String)>,
    /// What stands beside the modules: constants, and what the modules hold for others.
    pub items: String,
}

/// The module with signatures and trait.
const TRAIT: &str = "model";

/// Emits a model; `struct #type_name;` itself is the caller's.
pub fn model(compiled: &CompiledModel, options: &Options) -> Model {
    let names = Names::new(compiled);
    let twins = if options.limbs_together { Twins::of(&compiled.tree) } else { Twins::none(&compiled.tree) };
    let way = Way { names: &names, twins: &twins, limit: options.split_above };
    let mut modules: Vec<(String, String)> = Vec::new();
    for family in compiled.functions.chunk_by(|f, g| f.family == g.family) {
        let (mut text, mut functions) = (Text::default(), Text::default());
        for f in family {
            functions.line("");
            function(compiled, &way, f, &mut functions);
        }
        let functions = functions.finish();
        imports(compiled, family, &functions, &mut text);
        text.lines(&functions);
        modules.push((family[0].family.to_owned(), text.finish()));
    }
    let mut text = Text::default();
    layout::constants(compiled, &mut text);
    text.line("");
    let mut public: Vec<String> = modules.iter().map(|(name, _)| format!("{name}::*")).collect();
    public.push(format!("{TRAIT}::SIGNATURES"));
    text.list("pub use self::{", &public, "};");
    text.line("");
    text.line("// Whether runtime and code are of one form.");
    text.line(&format!("const _: () = ::bipedc_runtime::require_format({});", bipedc_runtime::FORMAT));
    modules.push((TRAIT.to_owned(), implementation(compiled, options)));
    Model { modules, items: text.finish() }
}

/// What statements need that compute two values at once.
fn twin_imports(functions: &str, text: &mut Text) {
    let called = [("both", "both("), ("store", "store(out, "), ("two", "two(")];
    let used = called.into_iter().filter(|(_, call)| functions.contains(call)).map(|(name, _)| name);
    let uses_methods =
        ["first()", "second()", "swapped()", "R::Two::"].iter().any(|what| functions.contains(what));
    let names: Vec<&str> = uses_methods.then_some("Two").into_iter().chain(used).collect();
    match names.as_slice() {
        [] => {}
        [name] => text.line(&format!("use ::bipedc_runtime::lanes::{name};")),
        names => text.line(&format!("use ::bipedc_runtime::lanes::{{{}}};", names.join(", "))),
    }
}

/// What the functions of a family need from elsewhere, and nothing more.
fn imports(compiled: &CompiledModel, family: &[Function], functions: &str, text: &mut Text) {
    let mut sizes = BTreeSet::new();
    for f in family {
        let (rows, columns) = Size::of_result(compiled, f);
        sizes.extend([rows, columns]);
        sizes.extend(f.program.arguments().map(|a| Size::of(compiled, a)));
    }
    let mut lengths = Vec::new();
    if sizes.contains(&Size::Nq) {
        lengths.push("NQ".to_owned());
    }
    if sizes.iter().any(|size| matches!(size, Size::Nv(_))) {
        lengths.push("NV".to_owned());
    }
    if !lengths.is_empty() {
        text.list("use super::{", &lengths, "};");
    }
    let takes = family.iter().any(|f| f.program.arguments().next().is_some());
    let vector = if takes { ", SVector" } else { "" };
    let packed = family.iter().any(|f| Packed::of(f).is_some());
    text.line(if packed { "use ::bipedc_runtime::{Real, Sparsity};" } else { "use ::bipedc_runtime::Real;" });
    twin_imports(functions, text);
    text.line(&format!("use ::bipedc_runtime::nalgebra::{{ArrayStorage, SMatrix{vector}}};"));
}

fn implementation(compiled: &CompiledModel, options: &Options) -> String {
    let mut text = Text::default();
    let functions = &compiled.functions;
    let used: Vec<Argument> =
        Argument::ALL.into_iter().filter(|&a| functions.iter().any(|f| f.program.arguments.has(a))).collect();
    text.doc("//!", "All functions by index: their signatures, and the implementation of `Model`.");
    text.line("use super::{JOINTS, NQ, NV};");
    let variants: Vec<String> = used.iter().map(|a| format!("{a:?}")).collect();
    if !variants.is_empty() {
        text.list("use ::bipedc_runtime::Argument::{", &variants, "};");
        text.line("use ::bipedc_runtime::model::argument;");
    }
    if !functions.is_empty() {
        text.line("use ::bipedc_runtime::model::columns;");
    }
    text.line("use ::bipedc_runtime::{Argument, CallError, Model, Real, Signature, State};");
    text.line("");
    text.doc("///", "All functions, in the order of their index in the `Model` trait.");
    text.open(&format!("pub const SIGNATURES: [Signature<'static>; {}] = [", functions.len()));
    functions.iter().for_each(|f| text.line(&signature(compiled, f)));
    text.close("];");
    text.line("");
    let lengths = Argument::ALL.map(|a| Size::of(compiled, a).to_string());
    text.list("const ARGUMENT_LENGTHS: [usize; Argument::COUNT] = [", &lengths, "];");
    text.line("");
    text.open(&format!("impl<R: Real> Model<R> for super::{} {{", ident(&options.type_name)));
    text.lines(ACCESSORS);
    text.open("fn evaluate(&self, function: usize, state: &State<'_, R>, output: &mut [R]) -> Result<(), CallError> {");
    if used.is_empty() {
        // Where nothing moves no function takes anything.
        text.line("let _ = (&state, &output);");
    }
    text.open("match function {");
    functions.iter().enumerate().for_each(|(k, f)| arm(k, f, &mut text));
    text.line("_ => return Err(CallError::UnknownFunction),");
    text.close("}");
    text.line("Ok(())");
    text.close("}");
    text.close("}");
    text.finish()
}

/// What `Model` asks besides functions.
const ACCESSORS: &str = "\
fn nq(&self) -> usize {
    NQ
}
fn nv(&self) -> usize {
    NV
}
fn joint_name(&self, index: usize) -> Option<&str> {
    JOINTS.get(index).copied()
}
fn joints(&self) -> usize {
    JOINTS.len()
}
fn signature(&self, index: usize) -> Option<Signature<'_>> {
    SIGNATURES.get(index).copied()
}
fn argument_length(&self, argument: Argument) -> usize {
    ARGUMENT_LENGTHS[argument as usize]
}
";

fn signature(compiled: &CompiledModel, f: &Function) -> String {
    let arguments: Vec<String> = f.program.arguments().map(|a| format!("{a:?}")).collect();
    let (rows, columns) = Size::of_result(compiled, f);
    format!("Signature::new({}, &[{}], {rows}, {columns}),", quoted(&f.name), arguments.join(", "))
}

fn arm(index: usize, f: &Function, text: &mut Text) {
    let mut passed: Vec<String> = f.program.arguments().map(|a| format!("argument(state, {a:?})?")).collect();
    passed.push("columns(output)?".to_owned());
    text.list(&format!("{index} => super::{}::{}_program(", f.family, f.name), &passed, "),");
}

/// The whole model as items, its modules inline: what the derive macro and build scripts emit.
pub fn items(compiled: &CompiledModel, options: &Options) -> String {
    let Model { modules, items } = model(compiled, options);
    let mut text = Text::default();
    text.lines(&items);
    for (name, items) in &modules {
        text.line("");
        text.line("#[rustfmt::skip]");
        text.open(&format!("mod {name} {{"));
        text.lines(items);
        text.close("}");
    }
    text.finish()
}
