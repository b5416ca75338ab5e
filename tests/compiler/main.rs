//! The compiler from outside: descriptions, expressions and programs.
mod asked_for;
#[path = "contacts/main.rs"]
mod contacts;
#[path = "derivatives/main.rs"]
mod derivatives;
#[path = "description/main.rs"]
mod description;
#[path = "effects/main.rs"]
mod effects;
mod locked;
#[path = "regressors/main.rs"]
mod regressors;
