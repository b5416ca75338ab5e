//! One file per mistake in the derive macro's attribute, with the message that the user sees.
//!
//! `TRYBUILD=overwrite cargo test --test ui` writes the messages anew.
#[test]
fn a_mistake_gives_one_error_at_its_place() {
    let cases = trybuild::TestCases::new();
    cases.pass("tests/ui/inline_model.rs");
    cases.compile_fail("tests/ui/fail_*.rs");
}
