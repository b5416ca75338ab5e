//! A robot whose samples are computed instead of measured.
use crate::identify::support::project;
use bipedc::identification::base_regressor;
use bipedc::robot::{ProgramRegressor, joint_layout, link_inertias};
use bipedc_analysis::identify::{BaseSet, Design, Extra, Law, Settings, Sums, fold};
use bipedc_analysis::measure::Recording;
use bipedc_analysis::robot::Trajectory;
use bipedc_analysis::robot::{BaseKind, JointLayout, LinkInertias};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::nalgebra::DVector;
use bipedc_runtime::{Argument, Model, State};

/// Stretches into which samples are cut.
pub const CELLS: usize = 20;

pub struct Simulated {
    pub layout: JointLayout,
    pub link_inertias: LinkInertias,
    pub base: BaseSet,
    pub regressor: ProgramRegressor,
    pub rows: Vec<usize>,
    pub model: ProgramModel,
}

/// Numbers that look random and are always the same.
pub struct Noise(pub u64);

impl Noise {
    /// Even between 0 and 1.
    pub fn even(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    /// Normal, variance 1.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.even().max(1e-300).ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos()
    }
}

impl Simulated {
    /// A robot of `robots/` on a base.
    pub fn new(name: &str, base: &str) -> Self {
        let robot = Robot::read(&project().join("robots").join(name)).unwrap();
        let robot = robot.with_base(base, None).unwrap().without_effects();
        let tree = robot.tree().unwrap();
        let layout = joint_layout(&tree).unwrap();
        let rows: Vec<usize> = (0..tree.nv).collect();
        let (base, regressor) = base_regressor(&robot.description, &tree, &rows).unwrap();
        let request = FunctionRequest::of_robot("inverse_dynamics");
        let model = ProgramModel::new(robot.compile_only(&[request]).unwrap());
        Self { layout, link_inertias: link_inertias(&robot.description, &tree), base, regressor, rows, model }
    }

    pub fn design(&self, extras: Vec<Extra>) -> Design<'_> {
        Design::new(&self.layout, &self.base, &self.regressor, extras, &self.rows)
    }

    /// Joints that swing by sums of sines over `seconds`, at 100 Hz; `seed` chooses the motion, `size` how far.
    pub fn motion(&self, seconds: f64, seed: u64, size: f64) -> Recording {
        let (nb, joints) = (self.layout.base.nv(), self.layout.joints.len());
        let mut noise = Noise(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let waves: Vec<[[f64; 3]; 3]> = (0..joints + nb)
            .map(|_| {
                [0.0; 3].map(|_: f64| {
                    [size * (0.2 + 0.3 * noise.even()), 1.0 + 6.0 * noise.even(), 6.3 * noise.even()]
                })
            })
            .collect();
        let count = (100.0 * seconds) as usize;
        let mut r = Recording {
            step: 0.01,
            segments: std::iter::once(0..count).collect(),
            trajectory: Trajectory::new(&self.layout),
            ..Recording::default()
        };
        for i in 0..count {
            let t = 0.01 * i as f64;
            r.time.push(t);
            let at = |wave: &[[f64; 3]; 3], order: usize| -> f64 {
                wave.iter()
                    .map(|[size, w, phase]| {
                        let x = w * t + phase;
                        size * [x.sin(), w * x.cos(), -w * w * x.sin()][order]
                    })
                    .sum()
            };
            self.base_position(&mut r.trajectory.q, &waves, &at);
            r.trajectory.q.extend(waves[nb..].iter().map(|wave| at(wave, 0)));
            r.trajectory.v.extend(waves.iter().map(|wave| at(wave, 1)));
            r.trajectory.a.extend(waves.iter().map(|wave| at(wave, 2)));
        }
        r.effort = vec![Some(Vec::new()); joints];
        r
    }

    /// Any orientation will do: its derivative is not asked for.
    fn base_position(
        &self,
        q: &mut Vec<f64>,
        waves: &[[[f64; 3]; 3]],
        at: &dyn Fn(&[[f64; 3]; 3], usize) -> f64,
    ) {
        match self.layout.base {
            BaseKind::Floating => {
                let angles = [3, 4, 5].map(|k: usize| at(&waves[k], 0));
                let raw = [angles[0], angles[1], angles[2], 1.0];
                let length = raw.iter().map(|x| x * x).sum::<f64>().sqrt();
                q.extend([0, 1, 2].map(|k: usize| at(&waves[k], 0)));
                q.extend(raw.map(|x| x / length));
            }
            BaseKind::Planar => q.extend([0, 1, 2].map(|k: usize| at(&waves[k], 0))),
            BaseKind::Fixed | BaseKind::Pivot => {}
        }
    }

    /// Generalised forces at a sample of a motion by the model's own inverse dynamics (not by its regressor).
    pub fn forces(&self, r: &Recording, i: usize) -> Vec<f64> {
        let (nq, nv) = (r.trajectory.q.len() / r.time.len(), r.trajectory.v.len() / r.time.len());
        let state = State::new()
            .with(Argument::Q, &r.trajectory.q[i * nq..(i + 1) * nq])
            .with(Argument::V, &r.trajectory.v[i * nv..(i + 1) * nv])
            .with(Argument::A, &r.trajectory.a[i * nv..(i + 1) * nv]);
        let mut tau = vec![0.0; nv];
        Model::<f64>::evaluate(&self.model, 0, &state, &mut tau).unwrap();
        tau
    }

    /// Efforts of the described bodies and of friction, with noise.
    pub fn measure(&self, r: &mut Recording, extras: &[(Extra, f64)], noise: &mut dyn FnMut(usize) -> f64) {
        let nb = self.layout.base.nv();
        let nv = nb + self.layout.joints.len();
        let extras: Vec<_> = extras.iter().map(|(extra, x)| (extra.torque(), x)).collect();
        for i in 0..r.time.len() {
            let tau = self.forces(r, i);
            let (v, a) = (
                r.trajectory.v[i * nv + nb..(i + 1) * nv].to_vec(),
                r.trajectory.a[i * nv + nb..(i + 1) * nv].to_vec(),
            );
            for (j, effort) in r.effort.iter_mut().enumerate() {
                let friction: f64 = extras.iter().filter_map(|(e, x)| Some(*x * e.on(j, &v, &a)?)).sum();
                effort.as_mut().unwrap().push(tau[nb + j] + friction + noise(j));
            }
        }
    }

    pub fn sums(&self, design: &Design<'_>, r: &Recording) -> Sums {
        let mut parts = vec![Sums::new(design, CELLS); 2];
        let length = r.time.last().unwrap() * 1.000_001;
        let cell = |time: f64| (time / length * CELLS as f64) as usize;
        fold(design, r, &cell, &Settings { threads: 2, ..Settings::default() }, None, &mut parts);
        let mut sums = parts.remove(0);
        sums.add(&parts[0]);
        sums
    }

    /// Unknowns of the description, with these extras.
    pub fn truth(&self, design: &Design<'_>, extras: &[(Extra, f64)]) -> DVector<f64> {
        let parameters = self.link_inertias.parameters();
        let value = |sum: &[(bipedc_analysis::identify::Summand, f64)]| -> f64 {
            sum.iter()
                .map(|(part, factor)| match part {
                    bipedc_analysis::identify::Summand::Inertial(k) => factor * parameters[*k],
                    bipedc_analysis::identify::Summand::Extra(k) => {
                        let wanted = design.extras[*k];
                        factor * extras.iter().find(|(e, _)| *e == wanted).map_or(0.0, |(_, x)| *x)
                    }
                })
                .sum()
        };
        DVector::from_iterator(design.unknowns.len(), design.sums().map(value))
    }
}

/// The same three laws at every joint.
pub fn friction(joints: usize) -> Vec<(Extra, f64)> {
    let laws = [(Law::VISCOUS, 0.3), (Law::COULOMB, 0.5), (Law::OFFSET, -0.2)];
    (0..joints)
        .flat_map(|joint| {
            laws.map(|(law, x)| (Extra { law, joint, other: joint }, x * (1.0 + 0.1 * joint as f64)))
        })
        .collect()
}
