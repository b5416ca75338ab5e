//! Forces of the ground as a log has them: means over the time that a row stands for.
//!
//! Where a corner touches down or lifts off, the force of one step can be many times that of its neighbours: hard ground changes a velocity at
//! once. A row with the force of its own step alone would say that of all steps up to the next row: in a standing robot's log of every tenth
//! step the ground then pushed by up to 4 N more or less than it did. Real sensors are filtered before they are sampled, for the same reason.
//! A mean keeps the impulse, and takes 0.4 % off what swings at a twentieth of the rows' rate.

/// Sums the forces on contact points from the middle between two rows to the next middle.
#[derive(Debug, Clone)]
pub(super) struct MeanForces {
    /// Steps from row to row.
    every: usize,
    /// N times steps, by point.
    sum: Vec<[f64; 3]>,
    /// Steps in the sum; the one in the middle between two rows is half in either.
    steps: f64,
}

impl MeanForces {
    pub fn new(every: usize, points: usize) -> Self {
        Self { every: every.max(1), sum: vec![[0.0; 3]; points], steps: 0.0 }
    }

    /// Adds the forces of a step (N, by point). If a row's time ends with it, `mean` becomes that row's and true is returned.
    pub fn add(&mut self, step: usize, forces: &[[f64; 3]], mean: &mut Vec<[f64; 3]>) -> bool {
        let middle = self.every / 2;
        let is_odd = self.every % 2 == 1;
        let ends = step % self.every == if is_odd { middle } else { middle - 1 };
        let part = if ends && is_odd { 0.5 } else { 1.0 };
        self.sum_up(forces, part);
        if ends {
            self.close(mean);
            if is_odd {
                self.sum_up(forces, part);
            }
        }
        ends
    }

    /// The mean so far, of a row whose time was cut off.
    pub fn close(&mut self, mean: &mut Vec<[f64; 3]>) {
        mean.clear();
        mean.extend(self.sum.iter().map(|sum| sum.map(|sum| sum / self.steps)));
        self.sum.fill([0.0; 3]);
        self.steps = 0.0;
    }

    fn sum_up(&mut self, forces: &[[f64; 3]], part: f64) {
        for (sum, force) in self.sum.iter_mut().zip(forces) {
            (0..3).for_each(|axis| sum[axis] += part * force[axis]);
        }
        self.steps += part;
    }
}

#[cfg(test)]
mod tests {
    use super::MeanForces;

    /// Rows with the mean of one force along a few steps.
    fn rows(every: usize, forces: &[f64]) -> Vec<f64> {
        let (mut means, mut mean, mut rows) = (MeanForces::new(every, 1), Vec::new(), Vec::new());
        for (step, force) in forces.iter().enumerate() {
            if means.add(step, &[[0.0, 0.0, *force]], &mut mean) {
                rows.push(mean[0][2]);
            }
        }
        rows
    }

    #[test]
    fn rows_stand_for_the_time_around_them() {
        let forces = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
        // Each row lies between two steps.
        assert_eq!(rows(1, &forces), [1.0, 1.5, 3.0, 6.0, 12.0, 24.0, 48.0]);
        assert_eq!(rows(2, &forces), [1.0, 3.0, 12.0, 48.0]);
        assert_eq!(rows(3, &forces), [(1.0 + 1.0) / 1.5, (1.0 + 4.0 + 8.0 + 8.0) / 3.0]);
        assert_eq!(rows(4, &forces), [1.5, (4.0 + 8.0 + 16.0 + 32.0) / 4.0]);
    }

    #[test]
    fn impulses_are_kept() {
        for every in 1..9 {
            let mut forces = vec![0.0; 8 * every];
            forces[3 * every + every / 3] = 24.0;
            let total: f64 = rows(every, &forces).iter().sum();
            assert!((total * every as f64 - 24.0).abs() < 1e-12, "{every} {total}");
        }
    }
}
