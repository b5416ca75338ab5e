//! The front ends that stand in a user's build: the derive macro's attribute and the build script.
//!
//! Both emit [`crate::emit::items`], as the command line does; only the packaging differs.
pub mod attribute;
mod keys;

use crate::compile::{CompiledModel, catalogue, entry_and_subject};
use crate::description::SourceFiles;
use crate::description::model::Base;
use crate::description::source::suggest;
use crate::emit::{GaitCode, Options, items};
use crate::robot::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use proc_macro2::{Ident, TokenStream};
use quote::quote;
use std::path::PathBuf;

/// What a user may ask of a robot beyond its description; the same for all front ends.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Request {
    /// Another kind of base: `floating`, `planar`, `fixed`, `pivot`.
    pub base: Option<String>,
    /// Another root: a link or contact point.
    pub root: Option<String>,
    /// These functions instead of those that the description asks for; empty: as described.
    pub functions: Vec<String>,
    /// Programs with more instructions become several Rust functions; [`Options::SPLIT_ABOVE`] by default.
    pub split_above: Option<usize>,
    /// Limbs of the same make are computed one after the other, not at once; the bits are the same.
    pub limbs_apart: bool,
    /// A gait beside the robot: its name in `gaits/`, or a path.
    pub gait: Option<String>,
}

impl Request {
    /// Reads and compiles a robot as requested.
    ///
    /// # Errors
    /// Everything wrong with the description, or else everything wrong with the request.
    pub fn compile(&self, sources: SourceFiles) -> Result<CompiledModel, Diagnostics> {
        self.robot(sources)?.compile().map_err(|error| Diagnostics(vec![error]))
    }

    /// The gait of a robot, with the file where it stands.
    ///
    /// # Errors
    /// Everything wrong with the gait.
    pub(crate) fn gait(&self, robot: &Robot) -> Result<Option<(GaitCode, PathBuf)>, Diagnostics> {
        let Some(name) = &self.gait else { return Ok(None) };
        let found = robot.gait(name)?;
        let code = found.code(self.split_above).map_err(|error| Diagnostics(vec![error]))?;
        Ok(Some((code, found.file)))
    }

    /// Reads a robot as requested.
    pub(crate) fn robot(&self, sources: SourceFiles) -> Result<Robot, Diagnostics> {
        let (description, warnings) = sources.parse()?;
        let mut robot = Robot { description, warnings, sources };
        let mut wrong = unknown_functions(&self.functions);
        if !self.functions.is_empty() {
            robot.description.generate.functions.clone_from(&self.functions);
        }
        if self.base.is_some() || self.root.is_some() {
            let kind = self.base.clone().unwrap_or_else(|| base_kind(&robot.description.base).to_owned());
            match robot.clone().with_base(&kind, self.root.as_deref()) {
                Ok(changed) => robot = changed,
                Err(error) => wrong.push(error),
            }
        }
        if let Err(error) = robot.tree()
            && wrong.is_empty()
        {
            wrong.push(error);
        }
        if !wrong.is_empty() {
            return Err(Diagnostics(wrong));
        }
        Ok(robot)
    }
}

fn base_kind(base: &Base) -> &'static str {
    match base {
        Base::Floating { .. } => "floating",
        Base::Planar { .. } => "planar",
        Base::Fixed { .. } => "fixed",
        Base::Pivot { .. } => "pivot",
    }
}

fn unknown_functions(names: &[String]) -> Vec<Diagnostic> {
    let known: Vec<&str> = catalogue().iter().map(|entry| entry.name).collect();
    names
        .iter()
        .filter(|name| entry_and_subject(name).is_err())
        .map(|name| {
            Diagnostic::error(format!("there is no function `{name}`")).help(suggest(
                name,
                known.iter().copied(),
                "functions",
            ))
        })
        .collect()
}

/// Attributes of a module that lands in a user's crate: nobody uses all functions of a robot, and style is
/// not the user's concern there. Unused variables stay an error of ours.
pub(crate) const ATTRIBUTES: &str =
    "#[rustfmt::skip]\n#[allow(dead_code, unused_imports, clippy::all, clippy::pedantic)]";

/// A module that lands in a user's crate.
fn module(visibility: &TokenStream, name: &Ident, doc: &str, content: &TokenStream) -> TokenStream {
    let attributes: TokenStream = ATTRIBUTES.parse().expect("attributes are Rust");
    quote! {
        #[doc = #doc]
        #attributes
        #visibility mod #name {
            #content
        }
    }
}

/// The items of a robot for a type, as text.
pub(crate) fn items_for(compiled: &CompiledModel, type_name: &str, request: &Request) -> String {
    let usual = Options::new(type_name);
    let split_above = request.split_above.unwrap_or(usual.split_above);
    items(compiled, &Options { split_above, limbs_together: !request.limbs_apart, ..usual })
}
