//! Contacts, constrained dynamics, impacts, relabelling and drive trains.
#![allow(missing_docs)]
mod drives;
mod impacts;
mod oracle;
mod roots;
mod rows;
mod support;
