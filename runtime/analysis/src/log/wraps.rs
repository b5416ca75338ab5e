//! Angles that were wrapped: a joint that turns through ±π goes on, while its logged angle jumps by a whole turn.
use super::names::joint_of;
use std::f64::consts::TAU;

/// A jump this near a whole turn is one, rad; so slow, per sample, is a joint otherwise.
const NEAR: f64 = 0.25;

/// Whether an angle that changes by so much from one sample to the next was wrapped there.
pub(super) fn is_turn(jump: f64) -> bool {
    (jump.abs() - TAU).abs() < NEAR
}

/// Whole turns that were added to an angle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unwrapped {
    /// Name of the column.
    pub column: String,
    /// How often it jumped.
    pub times: usize,
    /// The first such line in the file, from 1.
    pub line: usize,
}

/// The angles of a log, row by row in the order of time.
#[derive(Debug, Default)]
pub(super) struct Wraps {
    angles: Vec<Angle>,
}

#[derive(Debug)]
struct Angle {
    /// Its place in a row.
    place: usize,
    /// As it was logged last, and by how much it had changed where it did not jump; NaN where that is not known.
    last: f64,
    change: f64,
    /// What is added, rad.
    turns: f64,
    found: Unwrapped,
}

impl Wraps {
    /// For rows of these columns.
    pub fn of<'n>(names: impl Iterator<Item = &'n str>) -> Self {
        let is_angle = |name: &str| {
            (name.ends_with("/position") || name.ends_with("/motor_position")) && joint_of(name).is_some()
        };
        let angle = |(place, name): (usize, &str)| Angle {
            place,
            last: f64::NAN,
            change: f64::NAN,
            turns: 0.0,
            found: Unwrapped { column: name.to_owned(), times: 0, line: 0 },
        };
        Self { angles: names.enumerate().filter(|(_, name)| is_angle(name)).map(angle).collect() }
    }

    /// Adds whole turns to the angles of the next row.
    pub fn unwrap(&mut self, line: usize, row: &mut [f64]) {
        for angle in &mut self.angles {
            let Some(x) = row.get_mut(angle.place).filter(|x| x.is_finite()) else { continue };
            let jump = *x - angle.last;
            // A motor that turns fast makes as much from one sample to the next, again and again.
            if is_turn(jump) && angle.change.abs() < NEAR {
                angle.turns -= TAU * jump.signum();
                if angle.found.times == 0 {
                    angle.found.line = line;
                }
                angle.found.times += 1;
            } else {
                angle.change = jump;
            }
            angle.last = *x;
            *x += angle.turns;
        }
    }

    /// What was done so far.
    pub fn found(&self) -> impl Iterator<Item = &Unwrapped> {
        self.angles.iter().map(|angle| &angle.found).filter(|found| found.times > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unwrapped(angles: &[f64]) -> (Vec<f64>, usize) {
        let mut wraps = Wraps::of(["time", "hip/position"].into_iter());
        let row = |(k, x): (usize, &f64)| {
            let mut row = [k as f64, *x];
            wraps.unwrap(k + 2, &mut row);
            row[1]
        };
        let values = angles.iter().enumerate().map(row).collect();
        (values, wraps.found().map(|found| found.times).sum())
    }

    #[test]
    fn a_joint_that_goes_on_through_half_a_turn_goes_on() {
        let truth: Vec<f64> = (0..400).map(|k| 5.0 * (0.02 * f64::from(k)).sin()).collect();
        let logged: Vec<f64> = truth.iter().map(|x| x.sin().atan2(x.cos())).collect();
        let (found, times) = unwrapped(&logged);
        assert!(found.iter().zip(&truth).all(|(a, b)| (a - b).abs() < 1e-12) && times >= 4, "{times}");
    }

    #[test]
    fn a_motor_that_makes_a_turn_per_sample_is_left_as_it_is() {
        let fast: Vec<f64> = (0..200).map(|k| 6.2 * f64::from(k)).collect();
        assert_eq!(unwrapped(&fast), (fast, 0));
        let sways: Vec<f64> = (0..200).map(|k| 3.0 * (0.05 * f64::from(k)).sin()).collect();
        assert_eq!(unwrapped(&sways), (sways, 0));
    }

    #[test]
    fn fields_that_are_empty_stay_so() {
        let (found, times) = unwrapped(&[3.0, 3.1, f64::NAN, -3.1, -3.0]);
        assert!(found[2].is_nan() && times == 1 && (found[4] - (TAU - 3.0)).abs() < 1e-12, "{found:?}");
    }
}
