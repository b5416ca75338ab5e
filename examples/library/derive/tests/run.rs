//! This crate is what README.md prints, and it runs.
#[path = "../../readme.rs"]
mod readme;

#[test]
fn it_is_what_the_readme_prints_and_runs() {
    readme::prints(env!("CARGO_MANIFEST_DIR"), &[0, 2], 3, None);
    readme::runs(env!("CARGO_BIN_EXE_library-derive"));
}
