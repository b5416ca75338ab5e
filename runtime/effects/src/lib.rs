//! Physical effects that a model may lack, each defined once; the drive of a joint, kinds of bases, points of feet; and what
//! answers text from outside: diagnostics with places, limits of magnitude, files read and written; random numbers; names that are
//! nearly right.
pub mod base;
pub mod diagnostic;
pub mod drive;
pub mod effect;
pub mod feet;
pub mod files;
pub mod input;
pub mod magnitude;
pub mod random;
pub mod spelling;
