//! All tests of the compiler in one binary.
#![allow(missing_docs)]

#[path = "contacts/main.rs"]
mod contacts;
#[path = "derivatives/main.rs"]
mod derivatives;
#[path = "description/main.rs"]
mod description;
#[path = "effects/main.rs"]
mod effects;
#[path = "regressors/main.rs"]
mod regressors;
