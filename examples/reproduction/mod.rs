//! What the reproductions share: TUlip, a TUlip whose parameters are others, postures, and numbers that look random.
#![allow(dead_code)]
use bipedc::feet;
use bipedc::identification::standing::StandingRobot;
use bipedc_analysis::robot::{BaseKind, Foot, Joint, JointLayout, Robot as Parts};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::Foot as Described;
use bipedc_effects::diagnostic::Diagnostics;
use std::path::Path;

/// Whatever went wrong, in words.
pub type Failure = Box<dyn std::error::Error>;

/// Several diagnostics as one failure.
pub fn said(found: Diagnostics) -> Failure {
    found.0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n").into()
}

/// A diagnostic as a failure.
pub fn one(found: bipedc_effects::diagnostic::Diagnostic) -> Failure {
    found.to_string().into()
}

/// TUlip, third version.
pub fn tulip() -> Result<Robot, Failure> {
    Robot::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tulip")).map_err(said)
}

/// The same robot with other parameters: masses by up to 15 %, centres by up to 12 mm, inertias by up to 30 %.
pub fn other(robot: &Robot, seed: u64) -> Robot {
    let (mut random, mut other) = (Noise(seed), robot.clone());
    for inertial in other.description.links.iter_mut().filter_map(|link| link.inertial.as_mut()) {
        inertial.mass *= 1.0 + 0.15 * random.even();
        inertial.origin.xyz.iter_mut().for_each(|x| *x += 0.012 * random.even());
        let factor = 1.0 + 0.3 * random.even();
        inertial.inertia.iter_mut().for_each(|x| *x *= factor);
    }
    other
}

/// Numbers that depend on the seed alone.
pub struct Noise(pub u64);

impl Noise {
    /// Even between -1 and 1 (SplitMix64).
    pub fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
    /// Normal with variance 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let (u, v) = (0.5 + 0.5 * self.even(), 0.5 + 0.5 * self.even());
        (-2.0 * u.max(1e-300).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}

/// Functions of a robot on its standing foot, and what measurements know of it.
pub struct Stood {
    pub rooted: StandingRobot,
    pub model: ProgramModel,
    pub layout: JointLayout,
    pub feet: Vec<Foot>,
}

impl Stood {
    /// Compiles what posture tables and logs with ground forces need.
    pub fn new(rooted: StandingRobot) -> Result<Self, Failure> {
        let rigid = rooted.robot.clone().without_effects();
        let names = [
            "inverse_dynamics",
            "inverse_dynamics_regressor",
            "center_of_mass_regressor",
            "center_of_mass",
            "center_of_mass_jacobian",
        ];
        let mut requests: Vec<FunctionRequest> = names.map(FunctionRequest::of_robot).to_vec();
        for Described { link, .. } in &rigid.description.feet {
            let of =
                |family: &str| FunctionRequest { family: family.to_owned(), subject: Some(link.clone()) };
            requests.extend(["position", "rotation", "jacobian"].map(of));
        }
        let model = ProgramModel::new(rigid.compile_only(&requests).map_err(one)?);
        let joints = rooted.tree.joints.iter().map(|j| Joint {
            name: j.name.clone(),
            prismatic: j.prismatic,
            limits: None,
        });
        let layout = JointLayout { joints: joints.collect(), base: BaseKind::Floating };
        Ok(Self { feet: feet(&rigid.description), rooted, model, layout })
    }

    /// As experiments want it.
    pub fn robot(&self) -> Parts<'_> {
        Parts {
            model: &self.model,
            layout: &self.layout,
            link_inertias: &self.rooted.link_inertias,
            feet: &self.feet,
            effects: &[],
        }
    }
}
