//! `#[derive(Biped)]`.
