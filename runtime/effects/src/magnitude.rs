//! How large and how small numbers from outside may be, in SI units.
//!
//! Nothing that walks has a metre, kilogram, newton or second beyond these bounds: such a number is a slip, and sums,
//! squares and products of what is within them stay far from where arithmetic ends.

/// Largest size of a number.
pub const LARGEST: f64 = 1e12;
/// Smallest size of a number that is not 0.
pub const SMALLEST: f64 = 1e-100;

/// What is wrong with the size of a number, and what to do; `None`: nothing.
pub fn refusal(x: f64) -> Option<(&'static str, &'static str)> {
    let size = x.abs();
    if size > LARGEST {
        return Some(("is too large", "numbers in SI units are at most 1e12 in size: is the unit right?"));
    }
    (size > 0.0 && size < SMALLEST)
        .then_some(("is too small", "numbers in SI units are 0 or at least 1e-100 in size: write 0"))
}
