//! One function: its public faces on nalgebra's matrices, by value and in place.
use super::program::{program, program_name};
use crate::compile::{CompiledModel, Function};
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

pub fn ident(name: &str) -> Ident {
    // Names of functions and arguments come from link names: a keyword gets an underscore.
    if syn::parse_str::<Ident>(name).is_ok() {
        Ident::new(name, Span::call_site())
    } else {
        format_ident!("{name}_")
    }
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
    for note in &function.notes {
        lines.push(String::new());
        lines.push(format!(" {note}"));
    }
    lines
}

/// The program and its public functions on nalgebra's static matrices.
pub fn function(model: &CompiledModel, f: &Function, limit: usize) -> TokenStream {
    let (name, into, program_name) = (ident(&f.name), format_ident!("{}_into", f.name), program_name(f));
    let docs = documentation(f);
    let into_doc = format!(
        " [`{name}`], written in place: large results are costly to move, and the compiler moves those returned by value."
    );
    let (rows, columns) =
        (Literal::usize_unsuffixed(f.rows.len()), Literal::usize_unsuffixed(f.columns.len()));
    let arguments: Vec<TokenStream> = f
        .program
        .arguments()
        .map(|argument| {
            let name = ident(argument.name());
            let n = Literal::usize_unsuffixed(model.argument_length(argument));
            quote!(#name: &::bipedc_runtime::nalgebra::SVector<R, #n>)
        })
        .collect();
    let passed: Vec<TokenStream> = f
        .program
        .arguments()
        .map(|argument| {
            let name = ident(argument.name());
            quote!(&#name.data.0[0],)
        })
        .collect();
    let body = program(model, f, limit);
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
        #[doc = #into_doc]
        #[inline]
        pub fn #into<R: ::bipedc_runtime::Real>(
            #(#arguments,)*
            out: &mut ::bipedc_runtime::nalgebra::SMatrix<R, #rows, #columns>,
        ) {
            #program_name(#(#passed)* &mut out.data.0);
        }
        #body
    }
}
