//! The rows of both regressions: motors (5.10) and joints (5.11), batch by batch.
use super::super::design::{Design, Work};
use super::super::unknowns::{ColumnSource, Law};
use super::driven::Driven;
use super::laws::Laws;
use super::signals::{Chunk, Motor};
use crate::robot::Batch;
use bipedc_effects::drive::{Drive, Transmission};
use std::ops::Range;

/// Columns of a motor's row: laws in their order, stiffness always among them.
pub fn motor_columns(drive: &Drive, motor: &Motor, laws: Laws, i: usize, out: &mut Vec<f64>) {
    let all = [
        (laws.viscous, motor.motion[i][1]),
        (laws.coulomb, motor.sign[i]),
        (true, drive.lever() * motor.elongation[i]),
        (laws.offset, 1.0),
    ];
    out.extend(all.iter().filter(|(wanted, _)| *wanted).map(|(_, x)| x));
}

/// Torque of a motor less what its rotor takes, N m: the right-hand side of (5.10).
pub fn motor_torque(drive: &Drive, motor: &Motor, i: usize) -> f64 {
    drive.torque_constant.unwrap_or(0.0) * motor.current[i] - drive.rotor_inertia * motor.motion[i][2]
}

/// The joints' rows of a piece of a chunk.
pub struct JointRows<'a, 'd> {
    pub design: &'a Design<'d>,
    pub drives: &'a [Driven<'a>],
    work: Work,
}

impl<'a, 'd> JointRows<'a, 'd> {
    pub fn new(design: &'a Design<'d>, drives: &'a [Driven<'a>]) -> Self {
        Self { design, drives, work: Work::default() }
    }

    /// Evaluates the regressor for these samples; channels are asked for after that.
    pub fn evaluate(&mut self, chunk: &Chunk, range: Range<usize>) -> Piece {
        let count = chunk.len().max(1);
        let part = |values: &[f64]| -> Vec<f64> {
            let width = values.len() / count;
            values[range.start * width..range.end * width].to_vec()
        };
        let piece = Piece { q: part(&chunk.q), v: part(&chunk.v), a: part(&chunk.a), range };
        self.design.evaluate(&piece.batch(), &mut self.work);
        piece
    }

    /// Regressor columns of a channel, column after column; friction of stiff drives as filtered as the current is.
    pub fn columns(&self, channel: usize, chunk: &Chunk, piece: &Piece, out: &mut Vec<f64>) {
        self.design.rows(channel, &piece.batch(), None, &self.work, out);
        let channel = &self.design.channels[channel];
        let Some(index) = self.drive(channel.joint) else { return };
        let count = piece.range.len();
        for (place, &unknown) in channel.places.iter().enumerate() {
            let ColumnSource::Extra(k) = self.design.unknowns[unknown].source else { continue };
            if self.design.extras[k].law == Law::COULOMB && self.drives[index].drive.has_motor() {
                let turns_back = self.drives[index].drive.gear_ratio.signum();
                let signs = &chunk.motors[index].sign[piece.range.clone()];
                let column = &mut out[place * count..(place + 1) * count];
                column.iter_mut().zip(signs).for_each(|(x, sign)| *x = turns_back * sign);
            }
        }
    }

    /// Index of the drive of a joint.
    pub fn drive(&self, joint: Option<usize>) -> Option<usize> {
        self.drives.iter().position(|driven| Some(driven.joint) == joint)
    }

    /// Known torque on the channel's joint, torque per stiffness of its spring (N m per N/m), and whether it counts.
    pub fn torque(&self, channel: usize, chunk: &Chunk, piece: &Piece, i: usize) -> ([f64; 2], bool) {
        let joint = self.design.channels[channel].joint;
        let Some(index) = self.drive(joint) else { return ([0.0; 2], false) };
        let (driven, motor) = (&self.drives[index], &chunk.motors[index]);
        let at = piece.range.start + i;
        match driven.drive.transmission {
            Transmission::SeriesElastic { load_pulley_radius, .. } => {
                ([0.0, load_pulley_radius * motor.elongation[at]], true)
            }
            Transmission::Stiff => {
                let torque = motor_torque(driven.drive, motor, at);
                ([driven.drive.gear_ratio * torque, 0.0], motor.turns[at])
            }
            Transmission::Passive { stiffness, damping } => {
                let joints = self.design.layout.joints.len();
                let base = self.design.layout.base;
                let q = piece.q[i * (base.nq() + joints) + base.nq() + driven.joint];
                let v = piece.v[i * (base.nv() + joints) + base.nv() + driven.joint];
                ([-(stiffness * q + damping * v), 0.0], true)
            }
        }
    }
}

/// States of some samples of a chunk.
pub struct Piece {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    pub range: Range<usize>,
}

impl Piece {
    fn batch(&self) -> Batch<'_> {
        Batch { count: self.range.len(), q: &self.q, v: &self.v, a: &self.a }
    }
}
