//! The keys of `#[biped(…)]` with the places where they stand.
use super::attribute::without_prefix;
use super::{Request, unknown_functions};
use crate::description::source::suggest;
use bipedc_effects::diagnostic::Diagnostics;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::spanned::Spanned;
use syn::{Attribute, Error, Expr, ExprLit, Lit, LitStr, Meta, Token};

const KEYS: [&str; 9] =
    ["description", "base", "root", "functions", "split_above", "limbs_apart", "gait", "urdf", "toml"];
const EXAMPLE: &str = "write `#[biped(description = \"robots/my_robot\")]` below the derive";

/// Where the description stands.
pub enum DescriptionSource {
    /// In files: the path as written.
    Files(LitStr),
    /// In the attribute itself.
    Inline { urdf: LitStr, toml: Option<LitStr> },
}

/// What the attribute says.
pub struct Keys {
    pub source: DescriptionSource,
    pub request: Request,
}

/// `key = value` with any expression, so that a wrong value is our message and not the parser's.
struct Entries(Punctuated<syn::MetaNameValue, Token![,]>);

impl Parse for Entries {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        Punctuated::parse_terminated(input).map(Self)
    }
}

impl Keys {
    /// Reads the one `biped` attribute among `attributes`; `whole` is where its absence is reported.
    pub fn read(attributes: &[Attribute], whole: &dyn quote::ToTokens) -> syn::Result<Self> {
        let mut ours = attributes.iter().filter(|a| a.path().is_ident("biped"));
        let Some(attribute) = ours.next() else {
            return Err(Error::new_spanned(
                whole,
                format!("the attribute `biped` is missing: which robot?\nhelp: {EXAMPLE}"),
            ));
        };
        if let Some(second) = ours.next() {
            return Err(Error::new_spanned(second, "there is one robot, and so one attribute `biped`"));
        }
        let Meta::List(list) = &attribute.meta else {
            return Err(Error::new_spanned(attribute, format!("`biped` needs keys\nhelp: {EXAMPLE}")));
        };
        let Entries(entries) = list.parse_args().map_err(|e| {
            Error::new(e.span(), format!("{e}; `biped` holds `key = value` pairs\nhelp: {EXAMPLE}"))
        })?;
        Self::from_entries(&entries, attribute)
    }

    fn from_entries(
        entries: &Punctuated<syn::MetaNameValue, Token![,]>,
        attribute: &Attribute,
    ) -> syn::Result<Self> {
        let (mut request, mut seen) = (Request::default(), Vec::new());
        let (mut description, mut urdf, mut toml) = (None, None, None);
        for entry in entries {
            let key = entry.path.get_ident().map(ToString::to_string).unwrap_or_default();
            if seen.contains(&key) {
                return Err(Error::new_spanned(&entry.path, format!("`{key}` stands here twice")));
            }
            match key.as_str() {
                "description" => description = Some(text(&entry.value, &key)?),
                "urdf" => urdf = Some(text(&entry.value, &key)?),
                "toml" => toml = Some(text(&entry.value, &key)?),
                "base" => request.base = Some(text(&entry.value, &key)?.value()),
                "root" => request.root = Some(text(&entry.value, &key)?.value()),
                "functions" => request.functions = names(&entry.value)?,
                "gait" => request.gait = Some(text(&entry.value, &key)?.value()),
                "split_above" => request.split_above = Some(number(&entry.value, &key)?),
                "limbs_apart" => request.limbs_apart = truth(&entry.value, &key)?,
                _ => return Err(unknown(&entry.path)),
            }
            seen.push(key);
        }
        Ok(Self { source: source(description, urdf, toml, attribute)?, request })
    }

    /// The literal that names the description: where its errors are shown.
    pub fn place(&self) -> &LitStr {
        match &self.source {
            DescriptionSource::Files(path) => path,
            DescriptionSource::Inline { urdf, .. } => urdf,
        }
    }
}

fn source(
    description: Option<LitStr>,
    urdf: Option<LitStr>,
    toml: Option<LitStr>,
    attribute: &Attribute,
) -> syn::Result<DescriptionSource> {
    match (description, urdf, toml) {
        (Some(path), None, None) => Ok(DescriptionSource::Files(path)),
        (None, Some(urdf), toml) => Ok(DescriptionSource::Inline { urdf, toml }),
        (Some(path), ..) => Err(Error::new(
            path.span(),
            "`description` names files and `urdf`, `toml` are texts: give one or the other",
        )),
        (None, None, _) => Err(Error::new_spanned(
            attribute,
            format!("`description` is missing: which robot?\nhelp: {EXAMPLE}"),
        )),
    }
}

fn unknown(path: &syn::Path) -> Error {
    let written = path.segments.iter().map(|s| s.ident.to_string()).collect::<Vec<_>>().join("::");
    let help = suggest(&written, KEYS, "keys");
    Error::new_spanned(path, format!("`biped` has no key `{written}`\nhelp: {help}"))
}

fn text(value: &Expr, key: &str) -> syn::Result<LitStr> {
    match value {
        Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Ok(text.clone()),
        other => Err(Error::new(other.span(), format!("`{key}` is a text in quotes"))),
    }
}

fn number(value: &Expr, key: &str) -> syn::Result<usize> {
    match value {
        Expr::Lit(ExprLit { lit: Lit::Int(number), .. }) => number.base10_parse(),
        other => Err(Error::new(other.span(), format!("`{key}` is a whole number"))),
    }
}

fn truth(value: &Expr, key: &str) -> syn::Result<bool> {
    match value {
        Expr::Lit(ExprLit { lit: Lit::Bool(truth), .. }) => Ok(truth.value),
        other => Err(Error::new(other.span(), format!("`{key}` is `true` or `false`"))),
    }
}

fn names(value: &Expr) -> syn::Result<Vec<String>> {
    let Expr::Array(list) = value else {
        return Err(Error::new(
            value.span(),
            "`functions` is a list of texts: `[\"mass_matrix\", \"bias\"]`",
        ));
    };
    let names: Vec<String> = list
        .elems
        .iter()
        .map(|name| text(name, "functions").map(|t| t.value()))
        .collect::<syn::Result<_>>()?;
    match unknown_functions(&names) {
        wrong if wrong.is_empty() => Ok(names),
        wrong => Err(Error::new(value.span(), without_prefix(&Diagnostics(wrong)))),
    }
}
