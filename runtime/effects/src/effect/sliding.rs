//! Quantities of sliding joints: those of turning ones, on a wheel that rolls along.

/// Radius of the wheel, m: what is usual at a turning joint is usual, so scaled, at a sliding one.
const RADIUS: f64 = 0.1;

/// The unit that a quantity of turning joints has at sliding ones, and a usual value there for the value 1. The same for
/// quantities that have nothing to do with the joint's motion.
pub(super) fn at_sliding(unit: &'static str) -> (&'static str, f64) {
    let (unit, power) = match unit {
        "rad" => ("m", 1),
        "rad/s" => ("m/s", 1),
        "N m" => ("N", -1),
        "N m s/rad" => ("N s/m", -2),
        "N m/rad" => ("N/m", -2),
        "kg m²" => ("kg", -2),
        "N m s²/rad²" => ("N s²/m²", -3),
        other => (other, 0),
    };
    (unit, RADIUS.powi(power))
}

#[cfg(test)]
mod tests {
    use super::at_sliding;

    #[test]
    fn power_is_power() {
        // Torque times speed, and what makes a torque of a motion: N m rad/s = W, and so for N and m/s.
        let factor = |unit| at_sliding(unit).1;
        assert!((factor("N m") * factor("rad/s") - 1.0).abs() < 1e-12);
        assert!((factor("N m s/rad") * factor("rad/s") - factor("N m")).abs() < 1e-12);
        assert!((factor("N m s²/rad²") * factor("rad/s").powi(2) - factor("N m")).abs() < 1e-9);
        assert_eq!(at_sliding("1"), ("1", 1.0));
    }
}
