//! All functions of a robot, its constants, and its implementation of [`bipedc_runtime::Model`].
use super::function::{function, ident};
use super::program::program_name;
use crate::compile::{CompiledModel, Function, distinct, identifier};
use bipedc_runtime::Argument;
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

/// What the emitted items look like.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Name of the type that stands for the robot.
    pub type_name: String,
    /// Programs with more instructions are split: rustc takes more than linear time for long functions.
    pub split_above: usize,
}

impl Options {
    /// Instructions in one emitted function; measured in `emit/split.rs`.
    pub const SPLIT_ABOVE: usize = 4000;

    /// The usual form, for this type.
    pub fn new(type_name: &str) -> Self {
        Self { type_name: type_name.to_owned(), split_above: Self::SPLIT_ABOVE }
    }
}

/// The modules of a model, by name: one per family of functions, then `layout` and the trait.
pub struct Model {
    /// (module name, items), in order.
    pub modules: Vec<(String, TokenStream)>,
    /// Constants and `impl Model` for the type.
    pub items: TokenStream,
}

/// Emits a model; `struct #type_name;` itself is the caller's.
pub fn model(compiled: &CompiledModel, options: &Options) -> Model {
    let mut modules: Vec<(String, TokenStream)> = Vec::new();
    for f in &compiled.functions {
        let tokens = function(compiled, f, options.split_above);
        match modules.last_mut() {
            Some((name, items)) if name == f.family => items.extend(tokens),
            _ => modules.push((f.family.to_owned(), tokens)),
        }
    }
    let names: Vec<Ident> = modules.iter().map(|(name, _)| ident(name)).collect();
    let layout = layout(compiled);
    let implementation = implementation(compiled, options);
    let items = quote! {
        #(pub use self::#names::*;)*
        #layout
        #implementation
    };
    Model { modules, items }
}

fn layout(compiled: &CompiledModel) -> TokenStream {
    let tree = &compiled.tree;
    let (nq, nv) = (Literal::usize_unsuffixed(tree.nq), Literal::usize_unsuffixed(tree.nv));
    let joints: Vec<&str> = tree.joints.iter().map(|j| j.name.as_str()).collect();
    let count = Literal::usize_unsuffixed(joints.len());
    let base_nq = tree.nq - joints.len();
    let names = distinct(tree.joints.iter().map(|joint| identifier(&joint.name).to_uppercase()));
    let indices = tree.joints.iter().zip(names).enumerate().map(|(k, (joint, name))| {
        let name = ident(&name);
        let (q, v) = (Literal::usize_unsuffixed(base_nq + k), Literal::usize_unsuffixed(joint.v_index));
        let doc = format!(" Index of joint `{}` in (`q`, `v`).", joint.name);
        quote! {
            #[doc = #doc]
            pub const #name: (usize, usize) = (#q, #v);
        }
    });
    quote! {
        /// Length of the configuration `q`.
        pub const NQ: usize = #nq;
        /// Length of the velocity `v`.
        pub const NV: usize = #nv;
        /// Joints, in their order in `q` and `v` after the base.
        pub const JOINTS: [&str; #count] = [#(#joints),*];
        /// Where each joint stands in `q` and in `v`.
        pub mod joint {
            #(#indices)*
        }
    }
}

fn signature(f: &Function) -> TokenStream {
    let name = &f.name;
    let (rows, columns) =
        (Literal::usize_unsuffixed(f.rows.len()), Literal::usize_unsuffixed(f.columns.len()));
    let arguments = f.program.arguments().map(|a| format_ident!("{a:?}"));
    quote! {
        ::bipedc_runtime::Signature {
            name: #name,
            arguments: ::bipedc_runtime::Arguments::of(&[#(::bipedc_runtime::Argument::#arguments),*]),
            rows: #rows,
            columns: #columns,
        }
    }
}

fn arm(index: usize, f: &Function) -> TokenStream {
    let (index, program) = (Literal::usize_unsuffixed(index), program_name(f));
    let (family, columns) = (ident(f.family), Literal::usize_unsuffixed(f.columns.len()));
    let arguments = f.program.arguments().map(|a| {
        let variant = format_ident!("{a:?}");
        quote!(::bipedc_runtime::model::argument(state, ::bipedc_runtime::Argument::#variant)?,)
    });
    quote! {
        #index => #family::#program(#(#arguments)* ::bipedc_runtime::model::columns::<R, _, #columns>(output)?)
    }
}

fn implementation(compiled: &CompiledModel, options: &Options) -> TokenStream {
    let type_name = ident(&options.type_name);
    let count = Literal::usize_unsuffixed(compiled.functions.len());
    let signatures = compiled.functions.iter().map(signature);
    let arms = compiled.functions.iter().enumerate().map(|(k, f)| arm(k, f));
    let lengths = Argument::ALL.map(|a| Literal::usize_unsuffixed(compiled.argument_length(a)));
    let arguments = Argument::COUNT;
    // Where nothing moves no function takes anything.
    let takes = compiled.functions.iter().any(|f| f.program.arguments().next().is_some());
    let unused = (!takes).then(|| quote!(let _ = (&state, &output);));
    quote! {
        /// All functions, in the order of their index in the `Model` trait.
        pub const SIGNATURES: [::bipedc_runtime::Signature<'static>; #count] = [#(#signatures),*];
        const ARGUMENT_LENGTHS: [usize; #arguments] = [#(#lengths),*];
        impl<R: ::bipedc_runtime::Real> ::bipedc_runtime::Model<R> for #type_name {
            fn nq(&self) -> usize {
                NQ
            }
            fn nv(&self) -> usize {
                NV
            }
            fn joint_name(&self, index: usize) -> ::core::option::Option<&str> {
                JOINTS.get(index).copied()
            }
            fn joints(&self) -> usize {
                JOINTS.len()
            }
            fn signature(&self, index: usize) -> ::core::option::Option<::bipedc_runtime::Signature<'_>> {
                SIGNATURES.get(index).copied()
            }
            fn argument_length(&self, argument: ::bipedc_runtime::Argument) -> usize {
                ARGUMENT_LENGTHS[argument as usize]
            }
            fn evaluate(
                &self,
                function: usize,
                state: &::bipedc_runtime::State<'_, R>,
                output: &mut [R],
            ) -> ::core::result::Result<(), ::bipedc_runtime::CallError> {
                #unused
                match function {
                    #(#arms,)*
                    _ => return ::core::result::Result::Err(::bipedc_runtime::CallError::UnknownFunction),
                }
                ::core::result::Result::Ok(())
            }
        }
    }
}

/// The whole model as items, its families as inline modules: what the derive macro and build scripts emit.
pub fn items(compiled: &CompiledModel, options: &Options) -> TokenStream {
    let Model { modules, items } = model(compiled, options);
    let modules = modules.into_iter().map(|(name, tokens)| {
        let name = ident(&name);
        quote! {
            #[rustfmt::skip]
            mod #name {
                #tokens
            }
        }
    });
    quote! {
        #(#modules)*
        #items
    }
}
