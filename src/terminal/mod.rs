//! What all commands share: arguments, printing, pages, progress, Ctrl-C, failures.
pub mod arguments;
pub mod assignments;
pub mod failure;
pub mod interruption;
pub mod next;
pub mod output;
pub mod pages;
pub mod progress;
