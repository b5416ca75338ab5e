//! Machine code on processors for which we write none.
use super::{Paired, Program};
use bipedc_runtime::Argument;

/// There is none.
#[derive(Debug)]
pub(super) enum Native {}

impl Native {
    pub fn of_one(_: &Paired, _: &[(Argument, u32)]) -> Option<Self> {
        None
    }

    pub fn of_eight(_: &Program, _: &[(Argument, u32)]) -> Option<Self> {
        None
    }

    pub fn memory(&self) -> usize {
        match *self {}
    }

    pub fn bytes(&self) -> usize {
        match *self {}
    }

    pub fn run(&self, _: &mut [f64], _: &mut [f64]) {
        match *self {}
    }

    pub fn run_eight(&self, _: &mut [[f64; 8]], _: &mut [[f64; 8]]) {
        match *self {}
    }
}
