//! One file per mistake in the derive macro's attribute, with the message that the user sees.
//!
//! It compiles everything once more, which takes minutes: by hand, `cargo test --workspace --test ui -- --ignored`.
//! `TRYBUILD=overwrite` before it writes the messages anew. The messages themselves are tested in process, in
//! `tests/compiled/front_ends.rs` of the project.
#[test]
#[ignore = "compiles everything once more"]
fn a_mistake_gives_one_error_at_its_place() {
    let cases = trybuild::TestCases::new();
    cases.compile_fail("tests/ui/fail_*.rs");
}
