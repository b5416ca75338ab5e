//! One program on arrays: arguments in, columns of the result out.
use super::function::ident;
use super::split;
use crate::compile::{CompiledModel, Function};
use crate::expression::Call;
use crate::program::{Instruction, Operand, Program};
use bipedc_runtime::Argument;
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};
use std::collections::BTreeSet;

pub fn program_name(function: &Function) -> Ident {
    format_ident!("{}_program", function.name)
}

/// A number as `R::constant(…)`.
pub fn constant(x: f64) -> TokenStream {
    let literal = Literal::f64_unsuffixed(x.abs());
    if x.is_sign_negative() && x != 0.0 {
        quote!(R::constant(-#literal))
    } else {
        quote!(R::constant(#literal))
    }
}

pub fn operand(o: Operand) -> TokenStream {
    let name = match o {
        Operand::Constant(x) => return constant(x),
        Operand::Input(argument, k) => format_ident!("{}{k}", prefix(argument)),
        Operand::Sin(k) => format_ident!("sin{k}"),
        Operand::Cos(k) => format_ident!("cos{k}"),
        Operand::Value(k) => format_ident!("t{k}"),
    };
    quote!(#name)
}

/// Short names, so that long programs stay readable.
fn prefix(argument: Argument) -> &'static str {
    match argument {
        Argument::Q => "q",
        Argument::V => "v",
        Argument::A => "a",
        Argument::Tau => "tau",
        Argument::Forces => "f",
        Argument::Parameters => "p",
        Argument::MotorQ => "mq",
        Argument::MotorV => "mv",
        Argument::MotorA => "ma",
    }
}

fn instruction(i: &Instruction) -> TokenStream {
    let o = operand;
    match *i {
        Instruction::Add(a, b) => binary(o(a), quote!(+), o(b)),
        Instruction::Sub(a, b) => binary(o(a), quote!(-), o(b)),
        Instruction::Mul(a, b) => binary(o(a), quote!(*), o(b)),
        Instruction::Div(a, b) => binary(o(a), quote!(/), o(b)),
        Instruction::Neg(a) => {
            let a = o(a);
            quote!(-#a)
        }
        Instruction::Sqrt(a) => {
            let a = o(a);
            quote!(R::sqrt(#a))
        }
        Instruction::Call(function, a) => call(function, &o(a)),
        Instruction::Larger(a, b) => {
            let (a, b) = (o(a), o(b));
            quote!(R::larger(#a, #b))
        }
        Instruction::Fused { a, b, c, minus_product, minus_addend } => {
            let (b, a, c) = (o(b), signed(a, minus_product), signed(c, minus_addend));
            quote!(R::fused(#a, #b, #c))
        }
    }
}

fn call(call: Call, a: &TokenStream) -> TokenStream {
    match call {
        Call::Exp => quote!(R::exp(#a)),
        Call::Tanh => quote!(R::tanh(#a)),
        Call::Abs => quote!(R::abs(#a)),
        Call::Sign => quote!(R::sign(#a)),
        Call::Sin => quote!(::bipedc_runtime::math::sin_cos(#a).0),
        Call::Cos => quote!(::bipedc_runtime::math::sin_cos(#a).1),
    }
}

fn signed(x: Operand, minus: bool) -> TokenStream {
    match (x, minus) {
        (Operand::Constant(value), true) => constant(-value),
        (_, true) => {
            let x = operand(x);
            quote!(-#x)
        }
        (_, false) => operand(x),
    }
}

fn binary(a: TokenStream, operator: TokenStream, b: TokenStream) -> TokenStream {
    quote!(#a #operator #b)
}

/// What a stretch of a program reads besides its own values.
#[derive(Debug, Default)]
pub struct Reads {
    inputs: BTreeSet<(Argument, u32)>,
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

    /// The arguments it reads, in the order in which functions take them.
    pub fn arguments(&self) -> impl Iterator<Item = Argument> + '_ {
        Argument::ALL.into_iter().filter(|&a| self.inputs.iter().any(|&(read, _)| read == a))
    }

    pub fn any_sine(&self) -> bool {
        !self.sines.is_empty()
    }

    pub fn any_cosine(&self) -> bool {
        !self.cosines.is_empty()
    }

    /// `let &[q0, _, q2] = q;`
    pub fn destructured(&self, model: &CompiledModel) -> TokenStream {
        let lines = self.arguments().map(|argument| {
            let pattern = pattern(
                model.argument_length(argument),
                |k| Operand::Input(argument, k),
                |k| self.inputs.contains(&(argument, k)),
            );
            let name = ident(argument.name());
            quote!(let &#pattern = #name;)
        });
        quote!(#(#lines)*)
    }

    /// `[sin0, _, sin2]` of `count` angles.
    pub fn sine_pattern(&self, count: usize) -> TokenStream {
        pattern(count, Operand::Sin, |k| self.sines.contains(&k))
    }

    /// The same for cosines.
    pub fn cosine_pattern(&self, count: usize) -> TokenStream {
        pattern(count, Operand::Cos, |k| self.cosines.contains(&k))
    }
}

fn pattern(count: usize, name: impl Fn(u32) -> Operand, read: impl Fn(u32) -> bool) -> TokenStream {
    let names = (0..count as u32).map(|k| if read(k) { operand(name(k)) } else { quote!(_) });
    quote!([#(#names),*])
}

fn sines_and_cosines(program: &Program, reads: &Reads) -> TokenStream {
    let count = program.angles.len();
    if count == 0 {
        return TokenStream::new();
    }
    let (sines, cosines) = (reads.sine_pattern(count), reads.cosine_pattern(count));
    let angles = program.angles.iter().map(|&o| operand(o));
    quote!(let (#sines, #cosines) = R::sin_cos_all([#(#angles),*]);)
}

/// Values declared at once. Each `let` opens a scope within the scope before it, and LLVM's debug information
/// follows them by recursion: 4000 overflow its stack in a user's debug build.
const SCOPE: usize = 256;

/// `let t3 = t1 + t2;` for each pair; long lists declare first (`let (t0, t1);`) and assign then.
pub fn bindings(pairs: &[(TokenStream, TokenStream)]) -> TokenStream {
    let let_each = |pairs: &[(TokenStream, TokenStream)]| {
        let lines = pairs.iter().map(|(name, value)| quote!(let #name = #value;));
        quote!(#(#lines)*)
    };
    if pairs.len() <= SCOPE {
        return let_each(pairs);
    }
    let chunks = pairs.chunks(SCOPE).map(|chunk| {
        if chunk.len() == 1 {
            return let_each(chunk);
        }
        let names = chunk.iter().map(|(name, _)| name);
        let lines = chunk.iter().map(|(name, value)| quote!(#name = #value;));
        quote!(let (#(#names),*); #(#lines)*)
    });
    quote!(#(#chunks)*)
}

/// The instructions of a stretch of a program.
pub fn statements(p: &Program, range: std::ops::Range<usize>) -> TokenStream {
    let pairs: Vec<(TokenStream, TokenStream)> =
        range.map(|k| (operand(Operand::Value(k as u32)), instruction(&p.instructions[k]))).collect();
    bindings(&pairs)
}

/// `q: &[R; 19]` for each argument.
pub fn parameters(model: &CompiledModel, arguments: impl Iterator<Item = Argument>) -> TokenStream {
    let list = arguments.map(|argument| {
        let name = ident(argument.name());
        let length = Literal::usize_unsuffixed(model.argument_length(argument));
        quote!(#name: &[R; #length],)
    });
    quote!(#(#list)*)
}

/// `out: &mut [[R; ROWS]; COLUMNS]`
pub fn output_parameter(function: &Function) -> TokenStream {
    let rows = Literal::usize_unsuffixed(function.rows.len());
    let columns = Literal::usize_unsuffixed(function.columns.len());
    quote!(out: &mut [[R; #rows]; #columns])
}

/// The program as one function, or as several when it has more than `limit` instructions.
pub fn program(model: &CompiledModel, function: &Function, limit: usize) -> TokenStream {
    if function.program.instructions.len() > limit {
        return split::program(model, function, limit);
    }
    let p = &function.program;
    let name = program_name(function);
    let reads = Reads::of(
        p.instructions
            .iter()
            .flat_map(Instruction::operands)
            .chain(p.outputs.iter().copied())
            .chain(p.angles.iter().copied()),
    );
    let before = statements(p, 0..p.angles_ready);
    let after = statements(p, p.angles_ready..p.instructions.len());
    let outputs = p.outputs.chunks(function.rows.len().max(1)).map(|column| {
        // Regressors have many columns without entries.
        if column.len() > 1 && column.iter().all(|&o| o == Operand::Constant(0.0)) {
            let rows = Literal::usize_unsuffixed(column.len());
            return quote!([R::constant(0.0); #rows]);
        }
        let elements = column.iter().map(|&o| operand(o));
        quote!([#(#elements),*])
    });
    let (parameters, out) = (parameters(model, p.arguments()), output_parameter(function));
    let (inputs, trigonometry) = (reads.destructured(model), sines_and_cosines(p, &reads));
    quote! {
        #[inline]
        pub(super) fn #name<R: ::bipedc_runtime::Real>(#parameters #out) {
            #inputs
            #before
            #trigonometry
            #after
            *out = [#(#outputs),*];
        }
    }
}
