//! Sine, cosine, exp and tanh against exact values; the same bits in lanes, arrays and scalars.
#![allow(missing_docs)]
mod exponential;
mod lanes;
mod sin_cos;
