//! The contact problem of a step: what is closed, how fast it would move, what gives way.
use super::{MotionState, RowSource, Stepper, within_limits};
use crate::simulate::dense::{self, row_length};
use crate::simulate::implicit::Relaxed;
use crate::simulate::problem::{Block, Law};
use crate::simulate::proximal::Solved;
use std::ops::Range;

/// Softness of friction at points that come down, as a part of their own: while a sole tilts its corners cannot all stick, and what would tell
/// which of them slips are forces between them that the motion does not feel.
const DRAG: f64 = 1e-3;

/// Softness along the normal at such points, as a part of the least one: corners of a sole that come down together would share their load by how
/// their heights are rounded.
const GIVE: f64 = 1e-6;

/// From this height on (m) friction's is all of that; on the ground nothing gives way.
const LOOSE: f64 = 1e-8;

/// What it becomes, one after the other, where impulses are not found.
const LOOSER: [f64; 2] = [1e-2, 1e-1];

/// A change of impulses from step to step that may go on, as a part of them.
const STEADY: f64 = 0.25;

impl Stepper<'_> {
    /// Finds the points and limits that are closed at the midpoint or could close in this step, and makes place for them.
    pub(super) fn close(&mut self, motion: &MotionState, time: f64) {
        self.mechanics.distances(&motion.q, &mut self.gaps);
        if let Some(terrain) = &mut self.terrain {
            self.mechanics.positions(&motion.q, &mut terrain.places);
            terrain.lower(&mut self.gaps);
        }
        self.sources.clear();
        let reach = self.reach(time);
        self.look_down(motion, reach, time);
        let mut rows = self.touch();
        let first = motion.q.len() - self.joints.len();
        let before = self.sources.len();
        for (j, joint) in self.joints.iter().enumerate() {
            let q = motion.q[first + j];
            let near = |upper: bool| joint.way(upper, q).is_some_and(|way| way <= reach);
            let closed = [
                (joint.dry != [0.0; 2] && !self.sticking.joints.contains(&j), RowSource::Dry(j)),
                (near(false), RowSource::Lower(j)),
                (near(true), RowSource::Upper(j)),
            ];
            self.sources.extend(closed.into_iter().filter(|(closed, _)| *closed).map(|(_, source)| source));
        }
        for (k, motor) in self.motors.laws.iter().enumerate() {
            let (axis, plays) = (self.joints.len() + k, motor.gap > 0.0);
            let closed = [
                (motor.dry != [0.0; 2], RowSource::Dry(axis)),
                (plays, RowSource::Lower(axis)),
                (plays, RowSource::Upper(axis)),
            ];
            self.sources.extend(closed.into_iter().filter(|(closed, _)| *closed).map(|(_, source)| source));
        }
        let limited = (0..self.servos.len()).filter(|servo| self.within.has_row(*servo));
        self.sources.extend(limited.map(RowSource::Servo));
        rows += self.sources.len() - before;
        self.problem.clear(rows);
    }

    /// Delassus' matrix, free velocities, laws and the guess.
    pub(super) fn assemble(&mut self, motion: &MotionState, time: f64) {
        let (n, rows) = (self.size(), self.problem.rows());
        self.directions.resize(n * row_length(rows), 0.0);
        self.by_row.resize(rows * row_length(n), 0.0);
        if self.sources.first().is_some_and(RowSource::is_normal) {
            self.point_directions(&motion.q);
            if !self.soles.points.is_empty() {
                self.mechanics.positions(&motion.q, &mut self.soles.places);
            }
        }
        let mut row = 0;
        for index in 0..self.sources.len() {
            let source = self.sources[index];
            let law = self.law(source, time);
            self.direct(source, row);
            let block = Block { first: row, law };
            let slot = self.slot(source);
            self.guess(slot, row..row + block.size());
            self.problem.blocks.push(block);
            row += block.size();
        }
        dense::transpose(&self.by_row, [rows, n], &mut self.directions);
        self.free_velocities();
        dense::gram(&self.directions, self.problem.rows(), &self.filled, &mut self.problem.delassus);
        self.soften(motion, time);
    }

    /// Impulses of the last step, and how they changed in it if that was little: what strikes or lets go does not go on.
    fn guess(&mut self, slot: usize, rows: Range<usize>) {
        let (last, earlier) = (&self.memory[slot..slot + rows.len()], &self.earlier[slot..slot + rows.len()]);
        let change = last.iter().zip(earlier).map(|(last, earlier)| (last - earlier) * (last - earlier));
        let size = last.iter().map(|last| last * last);
        if change.sum::<f64>() <= STEADY * STEADY * size.sum::<f64>() {
            let trend = self.problem.trend[rows.clone()].iter_mut().zip(last).zip(earlier);
            trend.for_each(|((trend, last), earlier)| *trend = last - earlier);
        }
        self.problem.impulse[rows].copy_from_slice(last);
    }

    fn free_velocities(&mut self) {
        let (n, rows) = (self.size(), self.problem.rows());
        self.before.clear();
        self.before.resize(rows, 0.0);
        dense::add_rows(&self.directions, &self.speed, &mut self.before);
        self.mean.clear();
        self.mean.extend_from_slice(&self.before);
        self.take_sticking_out_of_rows();
        dense::survey(&self.directions, rows, &mut self.filled);
        dense::forward(self.within.factor_or(&self.mass), n, &mut self.directions, rows, &mut self.filled);
        self.problem.free.copy_from_slice(&self.mean);
        dense::add_rows(&self.directions, &self.drive, &mut self.problem.free);
        if self.ground.compliance.is_some() {
            return;
        }
        let [normal, tangential] = [self.ground.normal_restitution, self.ground.tangential_restitution];
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            let (first, size) = (block.first, block.size());
            // Where the tangential rows begin.
            let slides = match source {
                RowSource::Point(_) | RowSource::Normal(_) => {
                    self.problem.free[first] += normal * self.before[first];
                    first + 1
                }
                RowSource::Sole(_) => first,
                _ => continue,
            };
            for row in slides..first + size {
                self.problem.free[row] += tangential * self.before[row];
            }
        }
    }

    /// Relaxed rows: soft ground, springs behind play, servos.
    ///
    /// Spring and damper below each corner are taken at the end of the step: `λ = −k (κ_M + ½ h γ⁺) − d γ⁺`, written as
    /// `γ⁺ + Λ/(h (½ h k + d)) + k κ_M/(½ h k + d) = 0`, the relaxed constraint of (4.17). And hard ground: the
    /// way down to it, or the recovery from penetration.
    fn soften(&mut self, motion: &MotionState, time: f64) {
        let (joints, length) = (self.joints.len(), row_length(self.problem.rows()));
        let (q, v) = (&motion.q[motion.q.len() - joints..], &motion.v[motion.v.len() - joints..]);
        let least = self.least_normal();
        for (block, source) in self.problem.blocks.iter_mut().zip(&self.sources) {
            let row = block.first;
            let relaxed = match *source {
                RowSource::Point(point) | RowSource::Normal(point) => {
                    let drag = 1.0 + drag(self.gaps[point].min(self.near));
                    give_way(&mut self.problem.delassus, length, row + 1..row + block.size(), drag);
                    let mut relaxed = self.ground.relaxed(self.gaps[point], time);
                    if self.near > 0.0 && relaxed.offset > 0.0 {
                        relaxed.softness = GIVE * least;
                    }
                    Some(relaxed)
                }
                RowSource::Lower(axis) | RowSource::Upper(axis) if axis >= joints => {
                    self.motors.stop(axis - joints, matches!(source, RowSource::Upper(_)), q, v)
                }
                // The way that is left would last as long as a step: as at the ends of play, see `Motors::stop`. A joint that is
                // beyond is held where it is; pushed out it would rebound.
                RowSource::Lower(axis) | RowSource::Upper(axis) => {
                    let way = self.joints[axis].way(matches!(source, RowSource::Upper(_)), q[axis]);
                    way.map(|way| Relaxed { softness: 0.0, offset: way.max(0.0) / time })
                }
                RowSource::Servo(index) => {
                    let servo = &self.servos[index];
                    let relaxed = within_limits::relaxed(servo, &self.motors, (q, v), &self.inertia, time);
                    self.asked[servo.axis] = relaxed.map_or(0.0, |relaxed| relaxed.softness);
                    if relaxed.is_none() {
                        // Without gains what is left is constant.
                        let given = time * servo.bias.max(servo.limits[0]).min(servo.limits[1]);
                        block.law = Law::Limited { low: given, high: given };
                    }
                    relaxed
                }
                _ => None,
            };
            if let Some(relaxed) = relaxed {
                self.problem.delassus[row * length + row] += relaxed.softness;
                self.problem.free[row] += relaxed.offset;
            }
        }
    }

    /// The least of what normals give way by themselves, 1/kg.
    fn least_normal(&self) -> f64 {
        let length = row_length(self.problem.rows());
        let normals = self.sources.iter().zip(&self.problem.blocks).filter(|(source, _)| source.is_normal());
        let own = normals.map(|(_, block)| self.problem.delassus[block.first * (length + 1)]);
        own.filter(|own| *own > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// The impulses. Where points come down, friction gives way more if that is what it takes.
    pub(super) fn solve(&mut self) -> Solved {
        let mut solved = self.solver.solve(&mut self.problem, &self.tolerance);
        for drag in LOOSER {
            if solved.converged || !self.loosen(drag) {
                break;
            }
            let before = solved;
            solved = self.solver.solve(&mut self.problem, &self.tolerance);
            solved.sweeps += before.sweeps;
            solved.newton += before.newton;
        }
        solved
    }

    /// Makes friction at points that come down softer by this part of its own; false: none comes down.
    fn loosen(&mut self, drag: f64) -> bool {
        let length = row_length(self.problem.rows());
        let mut any = false;
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            if matches!(*source, RowSource::Point(point) if self.near > 0.0 && self.gaps[point] > 0.0) {
                any = true;
                let tangential = block.first + 1..block.first + block.size();
                give_way(&mut self.problem.delassus, length, tangential, 1.0 + drag);
            }
        }
        any
    }
}

/// Makes rows softer by a factor.
fn give_way(delassus: &mut [f64], length: usize, rows: Range<usize>, factor: f64) {
    rows.for_each(|row| delassus[row * (length + 1)] *= factor);
}

/// What is added to the softness of friction at this height above the ground (m), as a part of it.
fn drag(gap: f64) -> f64 {
    DRAG * (gap / LOOSE).clamp(0.0, 1.0)
}
