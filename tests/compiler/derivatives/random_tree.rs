//! Random robots: revolute, prismatic and fixed joints, crooked and right angles, parallel neighbours.
use bipedc_compiler::description::model::{
    Base, Generate, Inertial, Joint, JointKind, Link, Pose, RobotDescription,
};
use std::f64::consts::{FRAC_PI_2, PI};

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    /// Between -1 and 1.
    pub fn symmetric(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn vector(&mut self, n: usize, scale: f64) -> Vec<f64> {
        (0..n).map(|_| scale * self.symmetric()).collect()
    }
    pub fn three(&mut self, scale: f64) -> [f64; 3] {
        [0, 1, 2].map(|_| scale * self.symmetric())
    }
}

fn inertial(random: &mut Random) -> Inertial {
    let [x, y, z] = random.three(0.1).map(f64::abs);
    Inertial {
        mass: 1.5 + random.symmetric(),
        origin: Pose { xyz: random.three(0.2), rpy: random.three(3.0) },
        inertia: [0.01 + y + z, 0.0, 0.0, 0.01 + z + x, 0.0, 0.01 + x + y],
    }
}

fn axis(random: &mut Random) -> [f64; 3] {
    if random.below(3) > 0 {
        let mut axis = [0.0; 3];
        axis[random.below(3)] = if random.below(3) == 0 { -1.0 } else { 1.0 };
        return axis;
    }
    let x = random.three(1.0).map(|x| x + 1e-3);
    let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    x.map(|x| x / length)
}

fn joint(random: &mut Random, index: usize, parent_axis: [f64; 3]) -> Joint {
    let rpy = match random.below(4) {
        0 => random.three(3.0),
        1 => [0, 1, 2].map(|_| [0.0, FRAC_PI_2, PI][random.below(3)]),
        // As exporters write right angles: with 6 to 15 decimals, or a little off.
        2 => [0, 1, 2].map(|_| {
            let angle = [0.0, FRAC_PI_2, -FRAC_PI_2, PI][random.below(4)];
            let (places, off) = (6 + random.below(10), 10.0_f64.powi(-7 - random.below(9) as i32));
            format!("{angle:.places$}").parse::<f64>().unwrap() + [0.0, off, -off][random.below(3)]
        }),
        _ => [0.0; 3],
    };
    let kind = match random.below(8) {
        0 => JointKind::Fixed,
        1 | 2 => JointKind::Prismatic,
        _ => JointKind::Revolute,
    };
    let parallel = random.below(2) == 0;
    let own = axis(random);
    Joint {
        name: format!("joint{index}"),
        kind,
        parent: format!("link{}", index.saturating_sub(random.below(3))),
        child: format!("link{}", index + 1),
        origin: Pose { xyz: if random.below(3) == 0 { [0.0; 3] } else { random.three(0.4) }, rpy },
        axis: if parallel { parent_axis } else { own },
        position_limits: None,
        velocity_limit: None,
        effort_limit: None,
    }
}

/// A robot with the given number of joints.
pub fn robot(random: &mut Random, joints: usize) -> RobotDescription {
    let links =
        (0..=joints).map(|k| Link { name: format!("link{k}"), inertial: Some(inertial(random)) }).collect();
    let mut list: Vec<Joint> = Vec::new();
    for index in 0..joints {
        let before = list.last().map_or([0.0, 1.0, 0.0], |joint| joint.axis);
        list.push(joint(random, index, before));
    }
    let root = "link0".to_owned();
    RobotDescription {
        name: "random".to_owned(),
        links,
        joints: list,
        root_link: root.clone(),
        base: Base::Floating { root },
        gravity: random.three(10.0),
        feet: Vec::new(),
        symmetric_joints: Vec::new(),
        actuated_joints: Vec::new(),
        motor_encoders: Vec::new(),
        drives: Vec::new(),
        phases: Vec::new(),
        effects: Vec::new(),
        generate: Generate::default(),
    }
}
