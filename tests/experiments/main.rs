//! Logs, postures and impacts as experiments: what effects would change in them, against independent computations.
#![allow(missing_docs)]
use crate::support;
mod contact_effects;
mod contact_log;
mod data_gate;
mod icub_walking;
mod impacts;
mod no_mix_ups;
mod postures;
