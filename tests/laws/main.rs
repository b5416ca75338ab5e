//! Laws of mechanics in random states of random trees and of the six robots, through the in-process
//! evaluator. `subject::SEED` makes the trees and states; every failure names the seed of its tree.
#![allow(missing_docs)]
use crate::support;

mod contacts;
mod dynamics;
mod generator;
mod lagrangian;
mod momentum;
mod precision;
mod regressors;
mod rerooting;
mod subject;
