//! The `bipedc` command.
fn main() {}
