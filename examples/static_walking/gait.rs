//! Quasi-static gaits: the centre of mass goes over the foot that will stand, then the other foot steps.
use super::trials::Failure;
use super::trials::inverse::{Goal, holding, mechanics, reach};
use std::fmt::Write;

/// Height of the ankles' axes above the ground, m.
const ANKLE: f64 = 0.055;
/// Of the torso's frame, m: knees a little bent.
const HEIGHT: f64 = 0.655;
/// Half the distance of the feet, m.
const HALF: f64 = 0.0764;
/// From the ankle's axis to the middle of the sole, m.
const MIDDLE: f64 = 0.03;
/// How high a foot is lifted, m.
const LIFT: f64 = 0.03;
/// Of shifting the weight, and of a step, s.
pub const SHIFT: f64 = 1.5;
pub const STEP: f64 = 1.5;
/// Standing at the start and at the end, s.
const STAND: f64 = 1.0;
/// Of the controllers in the scenarios, N m/rad: references lie ahead of the wished angles by what holding the robot's weight takes.
const STIFFNESS: f64 = 1500.0;
/// Between rows of the trajectory, s.
const ROW: f64 = 0.1;

/// Where a foot steps to: index (0 right, 1 left), place (m), yaw (rad).
#[derive(Debug, Clone, Copy)]
pub struct Step {
    pub foot: usize,
    pub to: [f64; 2],
    pub yaw: f64,
}

/// Straight ahead by half a stride of this length (m) first, whole ones, half a one.
pub fn forward(steps: usize, stride: f64) -> Vec<Step> {
    (0..steps)
        .map(|k| {
            let foot = (k + 1) % 2;
            let ahead = if k + 1 == steps { k } else { k + 1 };
            Step { foot, to: [ahead as f64 * stride, side(foot)], yaw: 0.0 }
        })
        .collect()
}

/// To the left by this much (m) with each pair of steps.
pub fn sideways(steps: usize, stride: f64) -> Vec<Step> {
    (0..steps)
        .map(|k| {
            let foot = (k + 1) % 2;
            Step { foot, to: [0.0, side(foot) + stride * (k / 2 + 1) as f64], yaw: 0.0 }
        })
        .collect()
}

/// On the spot to the left by this angle (rad) with each pair of steps.
pub fn turning(steps: usize, angle: f64) -> Vec<Step> {
    (0..steps)
        .map(|k| {
            let (foot, yaw) = ((k + 1) % 2, angle * (k / 2 + 1) as f64);
            // About the middle between the soles.
            let at = [
                -MIDDLE * yaw.cos() - side(foot) * yaw.sin() + MIDDLE,
                -MIDDLE * yaw.sin() + side(foot) * yaw.cos(),
            ];
            Step { foot, to: at, yaw }
        })
        .collect()
}

fn side(foot: usize) -> f64 {
    if foot == 0 { -HALF } else { HALF }
}

/// Feet and centre of mass on their way.
struct Walk {
    feet: [([f64; 2], f64); 2],
    center: [f64; 2],
}

impl Walk {
    fn goal(&self, lifted: [f64; 2]) -> Goal {
        let foot = |k: usize| ([self.feet[k].0[0], self.feet[k].0[1], ANKLE + lifted[k]], self.feet[k].1);
        Goal {
            feet: [foot(0), foot(1)],
            center_of_mass: self.center,
            height: HEIGHT,
            yaw: 0.5 * (self.feet[0].1 + self.feet[1].1),
        }
    }

    /// Part of the weight on the left foot: how far the centre of mass is on the way from sole to sole.
    fn on_the_left(&self) -> f64 {
        let (right, left) = (self.sole(0), self.sole(1));
        let way = [left[0] - right[0], left[1] - right[1]];
        let along: f64 = (0..2).map(|i| way[i] * (self.center[i] - right[i])).sum();
        (along / (way[0] * way[0] + way[1] * way[1])).clamp(0.0, 1.0)
    }

    /// Middle of a sole.
    fn sole(&self, foot: usize) -> [f64; 2] {
        let ([x, y], yaw) = self.feet[foot];
        [x + MIDDLE * yaw.cos(), y + MIDDLE * yaw.sin()]
    }
}

/// A gait in rows of 0.1 s.
pub struct Trajectory {
    /// References of the controllers as CSV: wished angles and gravity compensation.
    pub text: String,
    /// Wished angles of all joints by row, rad.
    pub wished: Vec<Vec<f64>>,
}

/// The trajectory of a gait.
pub fn trajectory(steps: &[Step]) -> Result<Trajectory, Failure> {
    let start = [([0.0, -HALF], 0.0), ([0.0, HALF], 0.0)];
    let mut walk = Walk { feet: start, center: [MIDDLE, 0.0] };
    let mut table = Table::new()?;
    table.hold(&walk, STAND)?;
    for step in steps {
        let other = 1 - step.foot;
        let (from, to) = (walk.center, walk.sole(other));
        table.sweep(&mut walk, SHIFT, |walk, s| {
            walk.center = [0, 1].map(|i| from[i] + s * (to[i] - from[i]));
            [0.0; 2]
        })?;
        let (place, yaw) = walk.feet[step.foot];
        table.sweep(&mut walk, STEP, |walk, s| {
            let at = [0, 1].map(|i: usize| place[i] + s * (step.to[i] - place[i]));
            walk.feet[step.foot] = (at, yaw + s * (step.yaw - yaw));
            let mut lifted = [0.0; 2];
            lifted[step.foot] = LIFT * 16.0 * (s * (1.0 - s)).powi(2);
            lifted
        })?;
    }
    let from = walk.center;
    let to = [0, 1].map(|i: usize| 0.5 * (walk.sole(0)[i] + walk.sole(1)[i]));
    table.sweep(&mut walk, SHIFT, |walk, s| {
        walk.center = [0, 1].map(|i| from[i] + s * (to[i] - from[i]));
        [0.0; 2]
    })?;
    table.hold(&walk, STAND)?;
    Ok(Trajectory { text: table.text, wished: table.wished })
}

/// Rows of the trajectory.
struct Table {
    text: String,
    wished: Vec<Vec<f64>>,
    mechanics: bipedc_analysis::simulate::Mechanics<'static>,
    q: Vec<f64>,
    rows: usize,
}

impl Table {
    fn new() -> Result<Self, Failure> {
        use bipedc_runtime::Model;
        let mut q = vec![0.0; 19];
        (q[2], q[6]) = (HEIGHT, 1.0);
        for leg in [7, 13] {
            for (joint, angle) in [(2, -0.3), (3, 0.6), (4, -0.3)] {
                q[leg + joint] = angle;
            }
        }
        let mut text = "time".to_owned();
        for joint in 0..12 {
            let name = Model::<f64>::joint_name(&tulip::Tulip, joint).ok_or("no name")?;
            // Writing to a string cannot fail.
            let _ = write!(text, ",{name}/position");
        }
        text.push('\n');
        Ok(Self { text, wished: Vec::new(), mechanics: mechanics()?, q, rows: 0 })
    }

    fn hold(&mut self, walk: &Walk, time: f64) -> Result<(), Failure> {
        for _ in 0..(time / ROW).round() as usize {
            self.row(walk, [0.0; 2])?;
        }
        Ok(())
    }

    /// `change` sets feet and centre of mass at a part of the way and says how high the feet are.
    fn sweep(
        &mut self,
        walk: &mut Walk,
        time: f64,
        change: impl Fn(&mut Walk, f64) -> [f64; 2],
    ) -> Result<(), Failure> {
        let rows = (time / ROW).round() as usize;
        for row in 1..=rows {
            let t = row as f64 / rows as f64;
            // At rest at both ends, without acceleration.
            let s = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
            let lifted = change(walk, s);
            self.row(walk, lifted)?;
        }
        Ok(())
    }

    fn row(&mut self, walk: &Walk, lifted: [f64; 2]) -> Result<(), Failure> {
        reach(&self.mechanics, &mut self.q, &walk.goal(lifted))?;
        let held = [holding(&self.mechanics, &self.q, 0)?, holding(&self.mechanics, &self.q, 1)?];
        let left = walk.on_the_left();
        let _ = write!(self.text, "{:.1}", self.rows as f64 * ROW);
        for (j, angle) in self.q[7..].iter().enumerate() {
            let torque = (1.0 - left) * held[0][j] + left * held[1][j];
            let _ = write!(self.text, ",{:.6}", angle + torque / STIFFNESS + 0.0);
        }
        self.text.push('\n');
        self.wished.push(self.q[7..].to_vec());
        self.rows += 1;
        Ok(())
    }
}
