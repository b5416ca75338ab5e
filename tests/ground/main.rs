//! Parameters from the forces of the ground: static postures and motions on one foot, and postures designed for it.
#![allow(missing_docs)]
use crate::{cli, support};
mod design;
mod misuse;
mod motion;
mod postures;
mod real;
mod stood;
