//! Base parameters in exact arithmetic.
mod arithmetic;
mod field;
mod fraction;
mod random;
