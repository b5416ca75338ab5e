//! The form of generated code, on which it and this runtime have to agree.

/// Of the code that this runtime goes with; it counts up when code of one form no longer works with the runtime of another.
pub const FORMAT: u32 = 7;

/// Stops the compilation of code that was generated in another form than this runtime's; generated code holds
/// `const _: () = require_format(…);`.
///
/// ```
/// const _: () = bipedc_runtime::require_format(bipedc_runtime::FORMAT);
/// ```
///
/// ```compile_fail
/// const _: () = bipedc_runtime::require_format(1);
/// ```
///
/// # Panics
/// On every other format: while the code is compiled, never on the robot.
pub const fn require_format(format: u32) {
    if format != FORMAT {
        panic!("{}", OTHER);
    }
}

const OTHER: &str = concat!(
    "this code was generated for another `bipedc-runtime` than version ",
    env!("CARGO_PKG_VERSION"),
    ", which is here: generate it again with `bipedc` ",
    env!("CARGO_PKG_VERSION"),
    ", or depend on the `bipedc-runtime` of the version in the first line of the generated files",
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_format_is_refused_in_words_that_help() {
        require_format(FORMAT);
        let refusal = std::panic::catch_unwind(|| require_format(FORMAT + 1)).unwrap_err();
        let words = refusal.downcast_ref::<String>().unwrap();
        let version = env!("CARGO_PKG_VERSION");
        assert!(words.contains(&format!("generate it again with `bipedc` {version}")), "{words}");
    }
}
