//! The derive macro's work, on tokens that tests can make too.
use super::keys::{DescriptionSource, Keys};
use super::{items_for, module};
use crate::description::SourceFiles;
use bipedc_effects::diagnostic::Diagnostics;
use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};
use std::path::{Path, PathBuf};
use syn::{Data, DeriveInput, Error, Fields, LitStr};

/// Expands `#[derive(Biped)]` on a struct; relative paths are relative to `folder`.
///
/// On a mistake the output holds one error, at the attribute, and stands for the items that the user will
/// name, so that nothing else is reported.
pub fn expand(input: TokenStream, folder: &Path) -> TokenStream {
    let input: DeriveInput = match syn::parse2(input) {
        Ok(input) => input,
        Err(error) => return error.into_compile_error(),
    };
    robot(&input, folder).unwrap_or_else(|error| placeholder(&input, &error))
}

fn robot(input: &DeriveInput, folder: &Path) -> syn::Result<TokenStream> {
    check_shape(input)?;
    let mut keys = Keys::read(&input.attrs, &input.ident)?;
    if let Some(file) = keys.request.gait.as_mut().filter(|name| name.ends_with(".toml")) {
        *file = folder.join(&*file).to_string_lossy().into_owned();
    }
    let failed = |error: Diagnostics| Error::new(keys.place().span(), without_prefix(&error));
    let sources = sources(&keys.source, folder).map_err(failed)?;
    let robot = keys.request.robot(sources).map_err(failed)?;
    let compiled = robot.compile().map_err(|error| failed(Diagnostics(vec![error])))?;
    let gait = keys.request.gait(&robot).map_err(failed)?;
    let file = gait.as_ref().map(|(_, file)| file);
    let tracked = tracked(&keys.source, &robot.sources, file);
    let gait: TokenStream =
        gait.map_or_else(String::new, |(code, _)| code.inline()).parse().expect("emitted text is Rust");
    let (visibility, name) = (&input.vis, &input.ident);
    let items: TokenStream =
        items_for(&compiled, &name.to_string(), &keys.request).parse().expect("emitted text is Rust");
    let content = quote! {
        use super::#name;
        #tracked
        #items
        #gait
    };
    let doc = format!(" Robot `{}`: its functions and constants.", compiled.name);
    Ok(module(&quote!(#visibility), &module_name(name), &doc, &content))
}

fn check_shape(input: &DeriveInput) -> syn::Result<()> {
    let unit = matches!(&input.data, Data::Struct(data) if matches!(data.fields, Fields::Unit));
    if !unit || !input.generics.params.is_empty() {
        let message = format!("a robot is a struct without fields: `struct {};`", input.ident);
        return Err(Error::new(input.ident.span(), message));
    }
    Ok(())
}

fn sources(source: &DescriptionSource, folder: &Path) -> Result<SourceFiles, Diagnostics> {
    match source {
        DescriptionSource::Files(path) => SourceFiles::load(&folder.join(path.value())),
        DescriptionSource::Inline { urdf, toml } => Ok(SourceFiles {
            urdf_path: PathBuf::from("urdf"),
            urdf_text: urdf.value(),
            toml_path: PathBuf::from("toml"),
            toml_text: toml.as_ref().map(LitStr::value).unwrap_or_default(),
        }),
    }
}

/// rustc runs the macro again when a file changes that the output includes.
fn tracked(source: &DescriptionSource, sources: &SourceFiles, gait: Option<&PathBuf>) -> TokenStream {
    let mut paths = vec![&sources.urdf_path, &sources.toml_path];
    if matches!(source, DescriptionSource::Inline { .. }) {
        paths.clear();
    }
    paths.dedup();
    paths.extend(gait);
    // A path that is not Unicode cannot be written in source text: then only the rebuild is lost.
    let paths = paths.into_iter().filter_map(|path| path.to_str());
    quote!(#(const _: &[u8] = ::core::include_bytes!(#paths);)*)
}

/// rustc writes "error: " before the message itself.
pub(super) fn without_prefix(error: &Diagnostics) -> String {
    let text = error.to_string();
    text.strip_prefix("error: ").map(str::to_owned).unwrap_or(text)
}

/// The error inside the module: rustc then reports no missing names in it. The trait is there, empty.
fn placeholder(input: &DeriveInput, error: &Error) -> TokenStream {
    let (visibility, name, error) = (&input.vis, &input.ident, error.to_compile_error());
    let module = module(&quote!(#visibility), &module_name(name), " Nothing: see the error.", &error);
    if !input.generics.params.is_empty() {
        return module;
    }
    let none = quote!(::core::option::Option::None);
    quote! {
        #module
        impl<R: ::bipedc_runtime::Real> ::bipedc_runtime::Model<R> for #name {
            fn nq(&self) -> usize { 0 }
            fn nv(&self) -> usize { 0 }
            fn joint_name(&self, _: usize) -> ::core::option::Option<&str> { #none }
            fn joints(&self) -> usize { 0 }
            fn signature(&self, _: usize) -> ::core::option::Option<::bipedc_runtime::Signature<'_>> { #none }
            fn argument_length(&self, _: ::bipedc_runtime::Argument) -> usize { 0 }
            fn evaluate(
                &self,
                _: usize,
                _: &::bipedc_runtime::State<'_, R>,
                _: &mut [R],
            ) -> ::core::result::Result<(), ::bipedc_runtime::CallError> {
                ::core::result::Result::Err(::bipedc_runtime::CallError::UnknownFunction)
            }
        }
    }
}

/// `TulipV1Leg` → `tulip_v1_leg`, `HTTPRobot` → `http_robot`.
fn module_name(name: &Ident) -> Ident {
    let letters: Vec<char> = name.to_string().trim_start_matches("r#").chars().collect();
    let mut out = String::new();
    for (k, &letter) in letters.iter().enumerate() {
        let after_small = k > 0 && !letters[k - 1].is_uppercase() && letters[k - 1] != '_';
        let before_small =
            k > 0 && letters[k - 1] != '_' && letters.get(k + 1).is_some_and(|c| c.is_lowercase());
        if letter.is_uppercase() && (after_small || before_small) {
            out.push('_');
        }
        out.extend(letter.to_lowercase());
    }
    // A struct whose own name is small would meet its module.
    if *name == out { format_ident!("{out}_model") } else { crate::emit::ident(&out) }
}
