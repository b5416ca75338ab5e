//! The command line, the derive macro and the build script emit the same tokens; only the packaging differs.
use bipedc_compiler::emit::Options;
use bipedc_compiler::front::{Request, attribute};
use bipedc_compiler::{Robot, build, emit};
use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use std::path::{Path, PathBuf};
use syn::{File, Item};

const NAME: &str = "three_link";
const TYPE: &str = "ThreeLink";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(NAME)
}

fn robot() -> Robot {
    Robot::read(&folder()).unwrap_or_else(|e| panic!("{e}"))
}

/// Through the printer and back: it writes trailing commas, and doc comments instead of attributes.
fn printed(tokens: TokenStream) -> String {
    let file: File = syn::parse2(tokens).unwrap();
    parsed(&prettyplease::unparse(&file)).to_token_stream().to_string()
}

fn parsed(text: &str) -> File {
    syn::parse_file(text).unwrap()
}

fn items() -> String {
    let compiled = robot().compile().unwrap_or_else(|e| panic!("{e}"));
    unpacked(parsed(&emit::items(&compiled, &Options::new(TYPE))).items)
}

/// Without what only one of the front ends needs: the type, its import, the tracking of files (with all unnamed constants).
fn unpacked(items: Vec<Item>) -> String {
    let kept = items.into_iter().filter(|item| match item {
        Item::Struct(item) => item.ident != TYPE,
        Item::Use(item) => item.to_token_stream().to_string() != format!("use super :: {TYPE} ;"),
        Item::Const(item) => item.ident != "_",
        _ => true,
    });
    printed(quote!(#(#kept)*))
}

/// The items of the one inline module.
fn inside(items: Vec<Item>) -> Vec<Item> {
    match <[Item; 1]>::try_from(items) {
        Ok([Item::Mod(module)]) if module.ident == NAME => module.content.unwrap().1,
        _ => panic!("one module `{NAME}` expected"),
    }
}

#[test]
fn the_command_line_emits_the_items_in_files() {
    let package = robot().package("robots/three_link", "version = \"0.1\"").unwrap();
    let mut root = parsed(&package.files["src/lib.rs"]);
    for item in &mut root.items {
        if let Item::Mod(module) = item
            && module.content.is_none()
        {
            let file = parsed(&package.files[&format!("src/{}.rs", module.ident)]);
            module.attrs.extend(file.attrs);
            module.content = Some((syn::token::Brace::default(), file.items));
            module.semi = None;
        }
    }
    assert!(unpacked(root.items) == items());
}

/// The module of a gait: the same items in a file, behind the derive macro and from a build script.
#[test]
#[ignore = "takes long"]
fn a_gait_is_the_same_module_everywhere() {
    let found = robot().gait("thesis").unwrap_or_else(|e| panic!("{e}"));
    let code = found.code(None).unwrap();
    let compiled = robot().compile().unwrap();
    let package = robot().package_of(&compiled, Some(&code), "robots/three_link", "version = \"0.1\"");
    let in_file = unpacked(parsed(&package.files["src/gait_thesis.rs"]).items);
    let of_module = |items: Vec<Item>| {
        let module = items.into_iter().find_map(|item| match item {
            Item::Mod(module) if module.ident == "gait_thesis" => module.content,
            _ => None,
        });
        unpacked(module.unwrap().1)
    };
    let request = Request { gait: Some("thesis".to_owned()), ..Request::default() };
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("front_ends_gait");
    let written = build::write(&folder(), &request, &out).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(written.sources.last(), Some(&folder().join("gaits/thesis.toml")));
    let built = parsed(&std::fs::read_to_string(&written.file).unwrap());
    assert!(of_module(inside(built.items)) == in_file);
    let robot = quote!(
        #[biped(description = "robots/three_link", gait = "thesis")]
        struct ThreeLink;
    );
    let expanded = attribute::expand(robot, Path::new(env!("CARGO_MANIFEST_DIR")));
    assert!(of_module(inside(syn::parse2::<File>(expanded).unwrap().items)) == in_file);
    let wrong = quote!(
        #[biped(description = "robots/three_link", gait = "thesys")]
        struct ThreeLink;
    );
    let refused = attribute::expand(wrong, Path::new(env!("CARGO_MANIFEST_DIR"))).to_string();
    assert!(refused.contains("no gait `thesys`") && refused.contains("did you mean `thesis`?"), "{refused}");
}

#[test]
#[ignore = "takes long"]
fn the_build_script_emits_the_items_in_a_module() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("front_ends");
    let written = build::write(&folder(), &Request::default(), &out).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(written.file, out.join("three_link.rs"));
    assert_eq!(written.sources, [folder().join("robot.urdf"), folder().join("biped.toml")]);
    let file = parsed(&std::fs::read_to_string(&written.file).unwrap());
    assert!(unpacked(inside(file.items)) == items());
}

#[test]
#[ignore = "takes long"]
fn the_derive_macro_emits_the_items_in_a_module() {
    let input = quote! {
        #[biped(description = "robots/three_link")]
        struct ThreeLink;
    };
    let tokens = attribute::expand(input, Path::new(env!("CARGO_MANIFEST_DIR")));
    let file: File = syn::parse2(tokens).unwrap();
    assert!(unpacked(inside(file.items)) == items());
}

#[test]
fn the_derive_macro_depends_on_the_files() {
    let input = quote! {
        #[biped(description = "robots/three_link")]
        struct ThreeLink;
    };
    let text = attribute::expand(input, Path::new(env!("CARGO_MANIFEST_DIR"))).to_string();
    assert_eq!(text.matches("include_bytes !").count(), 2);
    assert!(text.contains("three_link/robot.urdf") && text.contains("three_link/biped.toml"));
}

#[test]
fn a_request_changes_base_and_functions() {
    let input = quote! {
        #[biped(description = "robots/three_link", base = "floating", functions = ["bias", "mass_matrix"])]
        struct ThreeLink;
    };
    let text = attribute::expand(input, Path::new(env!("CARGO_MANIFEST_DIR"))).to_string();
    assert!(text.contains("pub const NQ : usize = 9 ;"));
    assert!(text.contains("pub fn bias <") && text.contains("pub fn mass_matrix <"));
    assert!(!text.contains("pub fn gravity <"));
}

#[test]
fn a_failed_build_script_writes_nothing() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("front_ends_failed");
    let request =
        Request { functions: vec!["mass_matrx".into(), "bias".into(), "foo".into()], ..Request::default() };
    let error = build::write(&folder(), &request, &out).unwrap_err().to_string();
    assert!(error.contains("there is no function `mass_matrx`"), "{error}");
    assert!(error.contains("did you mean `mass_matrix`?") && error.contains("`foo`"), "{error}");
    assert!(!out.exists());
}

#[test]
#[ignore = "takes long"]
fn with_effects_the_front_ends_agree_too() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = root.join("tests/data/effects/five_link");
    let robot = Robot::read(&folder).unwrap_or_else(|e| panic!("{e}"));
    let functions = ["inverse_dynamics", "forward_dynamics", "inverse_dynamics_derivatives", "ground_wrench"]
        .map(str::to_owned);
    let request = Request { functions: functions.to_vec(), ..Request::default() };
    let compiled = request.compile(robot.sources).unwrap_or_else(|e| panic!("{e}"));
    let items = printed(emit::items(&compiled, &Options::new("FiveLink")).parse().unwrap());
    assert!(items.contains("R :: tanh") && items.contains("R :: exp") && items.contains("R :: larger"));
    let input = quote! {
        #[biped(
            description = "tests/data/effects/five_link",
            functions = ["inverse_dynamics", "forward_dynamics", "inverse_dynamics_derivatives", "ground_wrench"]
        )]
        struct FiveLink;
    };
    let derived: File = syn::parse2(attribute::expand(input, root)).unwrap();
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("front_ends_effects");
    let written = build::write(&folder, &request, &out).unwrap_or_else(|e| panic!("{e}"));
    let built = parsed(&std::fs::read_to_string(&written.file).unwrap());
    for file in [derived, built] {
        let module = file.items.into_iter().find_map(|item| match item {
            Item::Mod(module) => module.content,
            _ => None,
        });
        let kept =
            module.unwrap().1.into_iter().filter(|item| !matches!(item, Item::Struct(_) | Item::Use(_)));
        let kept: Vec<Item> = kept.filter(|item| !matches!(item, Item::Const(c) if c.ident == "_")).collect();
        let wanted = parsed(&emit::items(&compiled, &Options::new("FiveLink"))).items.into_iter();
        let wanted = wanted.filter(|item| !matches!(item, Item::Use(_)));
        let wanted: Vec<Item> =
            wanted.filter(|item| !matches!(item, Item::Const(c) if c.ident == "_")).collect();
        assert!(printed(quote!(#(#kept)*)) == printed(quote!(#(#wanted)*)));
    }
}
