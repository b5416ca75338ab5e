//! Rows of the contact problem: which there are, along which directions, under which laws.
use super::{MotionState, ROWS_OF_AXIS, RowSource, Stepper};
use crate::simulate::dense::{dot, row_length};
use crate::simulate::problem::Law;

/// How many times farther than at the present speed a joint or a point may come in a step.
const REACH: f64 = 4.0;

/// A point this much above hard ground (m) that carries something is on it: curved ways end so far from where a step looks ahead to.
pub(in crate::simulate) const CLOSED: f64 = 1e-5;

/// Points are within this distance of the axes that move them, m: as far as it matters for what is left out unseen.
const ARM: f64 = 1.0;

impl Stepper<'_> {
    /// How far from its stop a joint must be so as not to come there in this step, rad: with a multiple of the fastest speed
    /// now or without contact, since impacts make other coordinates fast.
    pub(super) fn reach(&self, time: f64) -> f64 {
        let speeds = self.speed.iter().zip(&self.middle);
        let fastest =
            speeds.fold(0.0, |most: f64, (now, middle)| most.max(now.abs()).max((2.0 * middle - now).abs()));
        REACH * time * fastest
    }

    /// How far above the ground a point must be so as not to come down in this step, m: with a multiple of the fastest point now
    /// or without contact, since impacts make other points fast. Zero where forces are those of a depth, where a rebound needs
    /// the whole speed at once, and in the plane, where no sole rocks on three corners: an impact that takes two steps is a worse one.
    pub(super) fn look_down(&mut self, motion: &MotionState, reach: f64, time: f64) {
        (self.near, self.directed) = (0.0, false);
        let (far, ground) = (ARM * reach, &self.ground);
        let above = self.gaps.iter().any(|gap| *gap > 0.0 && *gap <= far);
        let apart = self.mechanics.tangents() < 2 || ground.restores() || ground.compliance.is_some();
        if !above || apart {
            return;
        }
        self.point_directions(&motion.q);
        let nv = self.mechanics.nv();
        let fastest = self.normal.chunks_exact(nv).fold(0.0, |most: f64, normal| {
            let (now, middle) = (dot(normal, &self.speed[..nv]), dot(normal, &self.middle[..nv]));
            most.max(now.abs()).max((2.0 * middle - now).abs())
        });
        self.near = REACH * time * fastest;
    }

    /// Directions of the points, once in a step.
    pub(super) fn point_directions(&mut self, q: &[f64]) {
        if !self.directed {
            self.mechanics.directions(q, &mut self.normal, &mut self.tangential);
            self.directed = true;
        }
    }

    /// Whether a point was on the ground in the last step, or came down in it.
    pub(in crate::simulate) fn touches(&self, point: usize) -> bool {
        self.gaps[point] <= 0.0 || self.memory[self.slot(RowSource::Point(point))] > 0.0
    }

    /// Lists the points that are closed or could close: how many rows they have.
    pub(super) fn touch(&mut self) -> usize {
        let size = 1 + self.mechanics.tangents();
        let (mut rows, mut point) = (0, 0);
        while point < self.gaps.len() {
            if let Some(sole) = self.soles.flat(point, &self.gaps, self.near.min(CLOSED)) {
                let points = self.soles.points[sole].clone();
                point = points.end;
                let near = points.filter(|point| self.gaps[*point] <= self.near);
                let before = self.sources.len();
                self.sources.extend(near.map(RowSource::Normal));
                self.sources.push(RowSource::Sole(sole));
                rows += self.sources.len() - before + 2;
                continue;
            }
            if self.gaps[point] <= self.near {
                self.sources.push(RowSource::Point(point));
                rows += size;
            }
            point += 1;
        }
        rows
    }

    pub(super) fn law(&self, source: RowSource, time: f64) -> Law {
        match source {
            RowSource::Point(_) => Law::Contact {
                friction: self.ground.friction,
                tangents: self.mechanics.tangents(),
                cone: self.ground.cone,
            },
            RowSource::Dry(axis) => {
                let joints = self.joints.len();
                let [positive, negative] =
                    if axis < joints { self.joints[axis].dry } else { self.motors.laws[axis - joints].dry };
                Law::Limited { low: -time * positive, high: time * negative }
            }
            RowSource::Normal(_) | RowSource::Lower(_) | RowSource::Upper(_) => Law::Unilateral,
            RowSource::Sole(sole) => {
                let points = self.soles.points[sole].clone();
                Law::Sole {
                    friction: self.ground.friction,
                    turning: self.soles.turning,
                    normals: self.gaps[points].iter().filter(|gap| **gap <= self.near).count(),
                    cone: self.ground.cone,
                }
            }
            RowSource::Servo(index) => {
                let [low, high] = self.servos[index].limits;
                Law::Limited { low: time * low, high: time * high }
            }
        }
    }

    /// Writes the directions of a source into the rows from `row` on.
    pub(super) fn direct(&mut self, source: RowSource, row: usize) {
        let (nv, tangents, length) =
            (self.mechanics.nv(), self.mechanics.tangents(), row_length(self.size()));
        let mut rows = self.by_row[row * length..].chunks_exact_mut(length);
        match source {
            RowSource::Point(point) => {
                let normal = &self.normal[point * nv..][..nv];
                let tangential = self.tangential[point * tangents * nv..][..tangents * nv].chunks_exact(nv);
                for (own, along) in rows.zip(std::iter::once(normal).chain(tangential)) {
                    own[..nv].copy_from_slice(along);
                    own[nv..].fill(0.0);
                }
            }
            RowSource::Normal(point) => {
                let Some(own) = rows.next() else { return };
                own[..nv].copy_from_slice(&self.normal[point * nv..][..nv]);
                own[nv..].fill(0.0);
            }
            RowSource::Sole(sole) => {
                for (k, own) in rows.take(3).enumerate() {
                    own.fill(0.0);
                    for (point, parts) in self.soles.parts(sole) {
                        let along = |axis: usize| &self.tangential[(2 * point + axis) * nv..][..nv];
                        for ((own, x), y) in own.iter_mut().zip(along(0)).zip(along(1)) {
                            *own += parts[k][0] * x + parts[k][1] * y;
                        }
                    }
                }
            }
            RowSource::Dry(axis) => self.direct_axis(axis, 1.0, row),
            RowSource::Servo(index) => self.direct_axis(self.servos[index].axis, 1.0, row),
            RowSource::Lower(axis) => self.direct_axis(axis, 1.0, row),
            RowSource::Upper(axis) => self.direct_axis(axis, -1.0, row),
        }
        // Play lies between a motor and its joint.
        if let RowSource::Lower(axis) | RowSource::Upper(axis) = source
            && let Some(k) = axis.checked_sub(self.joints.len())
        {
            let joint = self.coordinate(self.motors.laws[k].joint);
            self.by_row[row * length + joint] = -self.by_row[row * length + self.coordinate(axis)];
        }
    }

    /// The row of one coordinate.
    fn direct_axis(&mut self, axis: usize, sign: f64, row: usize) {
        let (coordinate, length) = (self.coordinate(axis), row_length(self.size()));
        let own = &mut self.by_row[row * length..][..length];
        own.fill(0.0);
        own[coordinate] = sign;
    }

    /// Spreads the friction of flat soles over their corners, for those who ask for the forces on points.
    pub(super) fn share(&mut self) {
        for &source in &self.sources {
            let RowSource::Sole(sole) = source else { continue };
            let slot = self.slot(source);
            let friction = [self.memory[slot], self.memory[slot + 1]];
            let points = self.soles.points[sole].clone();
            let touching = points.clone().filter(|point| self.touches(*point)).count() as f64;
            for point in points {
                if self.touches(point) {
                    self.memory[3 * point + 1] = friction[0] / touching;
                    self.memory[3 * point + 2] = friction[1] / touching;
                }
            }
        }
    }

    /// A row of a servo or of the play of a motor.
    pub(super) fn is_drive(&self, source: RowSource) -> bool {
        match source {
            RowSource::Servo(_) => true,
            RowSource::Lower(axis) | RowSource::Upper(axis) => axis >= self.joints.len(),
            RowSource::Point(_) | RowSource::Normal(_) | RowSource::Sole(_) | RowSource::Dry(_) => false,
        }
    }

    /// Where a source's impulses are remembered.
    pub(super) fn slot(&self, source: RowSource) -> usize {
        match source {
            RowSource::Point(point) | RowSource::Normal(point) => point * (1 + self.mechanics.tangents()),
            RowSource::Sole(sole) => self.slot_of_axis(self.inertia.len()) + 3 * sole,
            RowSource::Dry(axis) => self.slot_of_axis(axis),
            RowSource::Lower(axis) => self.slot_of_axis(axis) + 1,
            RowSource::Upper(axis) => self.slot_of_axis(axis) + 2,
            RowSource::Servo(index) => self.slot_of_axis(self.servos[index].axis) + 3,
        }
    }

    pub(super) fn slot_of_axis(&self, axis: usize) -> usize {
        self.mechanics.points() * (1 + self.mechanics.tangents()) + ROWS_OF_AXIS * axis
    }

    /// Motors follow the joints, which are the last coordinates of the model.
    pub(super) fn coordinate(&self, axis: usize) -> usize {
        self.mechanics.nv() - self.joints.len() + axis
    }
}
