//! One function: a program on arrays, and its public face on matrices.
use crate::compile::{CompiledModel, Function};
use crate::program::{Instruction, Operand, Program};
use bipedc_runtime::Argument;
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};
use std::collections::BTreeSet;

pub fn ident(name: &str) -> Ident {
    // Names of functions and arguments come from link names: a keyword gets an underscore.
    if syn::parse_str::<Ident>(name).is_ok() {
        Ident::new(name, Span::call_site())
    } else {
        format_ident!("{name}_")
    }
}

/// A number as `R::constant(…)`.
fn constant(x: f64) -> TokenStream {
    let literal = Literal::f64_unsuffixed(x.abs());
    if x.is_sign_negative() && x != 0.0 {
        quote!(R::constant(-#literal))
    } else {
        quote!(R::constant(#literal))
    }
}

fn operand(o: Operand) -> TokenStream {
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
        Instruction::Fused { a, b, c, minus_product, minus_addend } => {
            let (b, a, c) = (o(b), signed(a, minus_product), signed(c, minus_addend));
            quote!(R::fused(#a, #b, #c))
        }
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

/// Which elements of each argument the program reads.
fn reads(program: &Program) -> BTreeSet<(Argument, u32)> {
    let operands = program.instructions.iter().flat_map(Instruction::operands);
    operands
        .chain(program.outputs.iter().copied())
        .chain(program.angles.iter().copied())
        .filter_map(|o| match o {
            Operand::Input(argument, k) => Some((argument, k)),
            _ => None,
        })
        .collect()
}

/// `let &[q0, _, q2] = q;`
fn destructure(model: &CompiledModel, function: &Function) -> TokenStream {
    let read = reads(&function.program);
    let lines = function.program.arguments().map(|argument| {
        let elements = (0..model.argument_length(argument) as u32).map(|k| {
            if read.contains(&(argument, k)) { operand(Operand::Input(argument, k)) } else { quote!(_) }
        });
        let name = ident(argument.name());
        quote!(let &[#(#elements),*] = #name;)
    });
    quote!(#(#lines)*)
}

fn sines_and_cosines(program: &Program) -> TokenStream {
    if program.angles.is_empty() {
        return TokenStream::new();
    }
    let used: BTreeSet<(bool, u32)> = program
        .instructions
        .iter()
        .flat_map(Instruction::operands)
        .chain(program.outputs.iter().copied())
        .filter_map(|o| match o {
            Operand::Sin(k) => Some((true, k)),
            Operand::Cos(k) => Some((false, k)),
            _ => None,
        })
        .collect();
    let names = |sine: bool| {
        (0..program.angles.len() as u32)
            .map(|k| match (used.contains(&(sine, k)), sine) {
                (false, _) => quote!(_),
                (true, true) => operand(Operand::Sin(k)),
                (true, false) => operand(Operand::Cos(k)),
            })
            .collect::<Vec<_>>()
    };
    let (sines, cosines) = (names(true), names(false));
    let angles = program.angles.iter().map(|&o| operand(o));
    quote!(let ([#(#sines),*], [#(#cosines),*]) = R::sin_cos_all([#(#angles),*]);)
}

/// The program on arrays: arguments in, columns of the result out.
fn program(model: &CompiledModel, function: &Function) -> TokenStream {
    let p = &function.program;
    let name = program_name(function);
    let arguments = p.arguments().map(|argument| {
        let (name, length) =
            (ident(argument.name()), Literal::usize_unsuffixed(model.argument_length(argument)));
        quote!(#name: &[R; #length],)
    });
    let (rows, columns) =
        (Literal::usize_unsuffixed(function.rows.len()), Literal::usize_unsuffixed(function.columns.len()));
    let statements: Vec<TokenStream> = p
        .instructions
        .iter()
        .enumerate()
        .map(|(k, i)| {
            let (name, value) = (format_ident!("t{k}"), instruction(i));
            quote!(let #name = #value;)
        })
        .collect();
    let (before, after) = statements.split_at(p.angles_ready);
    let outputs = p.outputs.chunks(function.rows.len().max(1)).map(|column| {
        let elements = column.iter().map(|&o| operand(o));
        quote!([#(#elements),*])
    });
    let (inputs, trigonometry) = (destructure(model, function), sines_and_cosines(p));
    quote! {
        #[inline]
        pub(super) fn #name<R: ::bipedc_runtime::Real>(#(#arguments)* out: &mut [[R; #rows]; #columns]) {
            #inputs
            #(#before)*
            #trigonometry
            #(#after)*
            *out = [#(#outputs),*];
        }
    }
}

pub fn program_name(function: &Function) -> Ident {
    format_ident!("{}_program", function.name)
}

fn documentation(function: &Function) -> Vec<String> {
    let (rows, columns) = (function.rows.len(), function.columns.len());
    let mut lines = vec![format!(" {}", function.summary), String::new()];
    if let Some(subject) = &function.subject {
        lines.push(format!(" Of `{subject}`."));
        lines.push(String::new());
    }
    let units: Vec<&str> = {
        let mut units: Vec<&str> = function.row_units.iter().map(String::as_str).collect();
        units.dedup();
        units
    };
    lines.push(format!(
        " Shape {rows} × {columns}; rows in {}. Source: {}.",
        units.join(", then "),
        function.source
    ));
    lines.push(format!(" {}.", function.operations));
    lines
}

/// The program and the public function on nalgebra's static matrices.
pub fn function(model: &CompiledModel, f: &Function) -> TokenStream {
    let (name, program_name) = (ident(&f.name), program_name(f));
    let docs = documentation(f);
    let (rows, columns) =
        (Literal::usize_unsuffixed(f.rows.len()), Literal::usize_unsuffixed(f.columns.len()));
    let arguments = f.program.arguments().map(|argument| {
        let (name, n) = (ident(argument.name()), Literal::usize_unsuffixed(model.argument_length(argument)));
        quote!(#name: &::bipedc_runtime::nalgebra::SVector<R, #n>)
    });
    let passed = f.program.arguments().map(|argument| {
        let name = ident(argument.name());
        quote!(&#name.data.0[0],)
    });
    let body = program(model, f);
    quote! {
        #(#[doc = #docs])*
        #[inline]
        pub fn #name<R: ::bipedc_runtime::Real>(
            #(#arguments),*
        ) -> ::bipedc_runtime::nalgebra::SMatrix<R, #rows, #columns> {
            let mut out = [[R::constant(0.0); #rows]; #columns];
            #program_name(#(#passed)* &mut out);
            ::bipedc_runtime::nalgebra::SMatrix::from_array_storage(
                ::bipedc_runtime::nalgebra::ArrayStorage(out),
            )
        }
        #body
    }
}
