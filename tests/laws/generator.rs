//! Random robots as URDF and `biped.toml`, so that the reader is exercised too.
use bipedc_compiler::Robot;
use bipedc_compiler::description::SourceFiles;
use std::f64::consts::PI;
use std::fmt::Write as _;

/// SplitMix64: the same numbers on every machine.
pub struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    /// Between -1 and 1.
    pub fn symmetric(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
    pub fn vector(&mut self, n: usize, scale: f64) -> Vec<f64> {
        (0..n).map(|_| scale * self.symmetric()).collect()
    }
    fn three(&mut self, scale: f64) -> [f64; 3] {
        [0, 1, 2].map(|_| scale * self.symmetric())
    }
}

/// What the tree hangs on; the feet are on the last two links, the base is link 0 (of a pivot: the foot).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Floating,
    /// Everything turns about y and slides in the x-z plane.
    Planar,
    Fixed,
    /// About an edge of the sole.
    Pivot,
}

pub const KINDS: [Kind; 4] = [Kind::Floating, Kind::Planar, Kind::Fixed, Kind::Pivot];

/// How exactly right angles and coordinate axes are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Digits {
    /// To the last digit.
    All,
    /// As exporters write them: 1.57079633, or an axis `0 1 -3.2e-12`.
    Some,
}

/// The robot of this seed: 2 to 12 links in a tree of revolute, continuous, prismatic and fixed joints.
pub fn robot(seed: u64, kind: Kind, digits: Digits) -> Robot {
    let mut random = Random(seed);
    let links = 2 + random.below(11);
    let sources = SourceFiles {
        urdf_path: format!("random_{seed}.urdf").into(),
        urdf_text: urdf(&mut random, links, kind == Kind::Planar, digits),
        toml_path: format!("random_{seed}.toml").into(),
        toml_text: description(&mut random, links, kind),
    };
    let (description, warnings) =
        sources.parse().unwrap_or_else(|e| panic!("{e}\n{}\n{}", sources.urdf_text, sources.toml_text));
    Robot { description, warnings, sources }
}

fn text([x, y, z]: [f64; 3]) -> String {
    format!("{x} {y} {z}")
}

fn urdf(random: &mut Random, links: usize, planar: bool, digits: Digits) -> String {
    let mut out = String::from("<robot name=\"random\">\n");
    for k in 0..links {
        out += &link(random, k);
    }
    for k in 1..links {
        out += &joint(random, k, planar, digits);
    }
    out + "</robot>\n"
}

/// A box-like body: its principal moments satisfy the triangle inequality, its axes point anywhere.
fn link(random: &mut Random, k: usize) -> String {
    let [a, b, c] = random.three(0.1).map(f64::abs);
    let (com, rpy) = (text(random.three(0.2)), text(random.three(PI)));
    format!(
        "<link name=\"l{k}\"><inertial><origin xyz=\"{com}\" rpy=\"{rpy}\"/><mass value=\"{}\"/>\
         <inertia ixx=\"{}\" ixy=\"0\" ixz=\"0\" iyy=\"{}\" iyz=\"0\" izz=\"{}\"/></inertial></link>\n",
        1.5 + random.symmetric(),
        0.01 + b + c,
        0.01 + c + a,
        0.01 + a + b,
    )
}

fn joint(random: &mut Random, k: usize, planar: bool, digits: Digits) -> String {
    // The first joint moves, so that no robot is one rigid body.
    let kind = match random.below(8) {
        0 if k > 1 => "fixed",
        1 | 2 => "prismatic",
        3..=5 => "continuous",
        _ => "revolute",
    };
    // Near the end of the list more often than not: long legs, and branches.
    let parent = k - 1 - if random.below(3) == 0 { random.below(k) } else { 0 };
    let (mut rpy, mut axis) = if planar { in_plane(random, kind) } else { in_space(random) };
    if digits == Digits::Some {
        // A planar robot stays exactly in its plane.
        rpy = [0, 1, 2].map(|k| if planar && k != 1 { rpy[k] } else { shortened(random, rpy[k]) });
        axis = if planar { axis } else { axis.map(|x| if x == 0.0 { offset(random) } else { x }) };
    }
    let xyz = if random.below(4) == 0 { [0.0; 3] } else { random.three(0.4) };
    format!(
        "<joint name=\"j{k}\" type=\"{kind}\"><parent link=\"l{parent}\"/><child link=\"l{k}\"/>\
         <origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"{}\"/>\
         <limit lower=\"-3\" upper=\"3\" effort=\"100\" velocity=\"10\"/></joint>\n",
        text(xyz),
        text(rpy),
        text(axis),
    )
}

fn sign(random: &mut Random) -> f64 {
    if random.below(2) == 0 { 1.0 } else { -1.0 }
}

fn in_plane(random: &mut Random, kind: &str) -> ([f64; 3], [f64; 3]) {
    let pitch = [0.0, PI / 2.0, PI * random.symmetric()][random.below(3)];
    let axis = match (kind, random.below(2)) {
        ("prismatic", 0) => [sign(random), 0.0, 0.0],
        ("prismatic", _) => [random.symmetric(), 0.0, 0.3],
        _ => [0.0, sign(random), 0.0],
    };
    ([0.0, pitch, 0.0], axis)
}

fn in_space(random: &mut Random) -> ([f64; 3], [f64; 3]) {
    let rpy = match random.below(4) {
        0 => random.three(PI),
        1 => [0, 1, 2].map(|_| [0.0, PI / 2.0, -PI / 2.0, PI][random.below(4)]),
        _ => [0.0; 3],
    };
    let mut axis = [0.0; 3];
    if random.below(3) == 0 {
        axis = random.three(1.0).map(|x| x + 0.01);
    } else {
        axis[random.below(3)] = sign(random);
    }
    (rpy, axis)
}

/// A multiple of π/2 with 6 to 15 decimals; 0 and other angles as they are, or off by as much.
fn shortened(random: &mut Random, angle: f64) -> f64 {
    if angle == 0.0 || random.below(3) == 0 {
        return angle + offset(random);
    }
    let places = 6 + random.below(10);
    format!("{angle:.places$}").parse().unwrap()
}

/// Zero or ±1e-15 … ±1e-7.
fn offset(random: &mut Random) -> f64 {
    let size = 10.0_f64.powi(-7 - random.below(9) as i32);
    [0.0, size, -size][random.below(3)] * (1.5 + random.symmetric())
}

fn description(random: &mut Random, links: usize, kind: Kind) -> String {
    let mut out = match kind {
        Kind::Floating => "[base]\nkind = \"floating\"\nroot = \"l0\"\n",
        Kind::Planar => "[base]\nkind = \"planar\"\nroot = \"l0\"\n",
        Kind::Fixed => "[base]\nkind = \"fixed\"\nlink = \"l0\"\n",
        Kind::Pivot => "[base]\nkind = \"pivot\"\nabout = \"right_foot/front\"\n",
    }
    .to_owned();
    for (side, link) in [("right", links - 1), ("left", links - 2)] {
        let _ = write!(out, "[feet.{side}_foot]\nlink = \"l{link}\"\nside = \"{side}\"\n");
        let [x, y, z] = random.three(0.05);
        let mut point = |name: &str, dx: f64, dy: f64| {
            let _ = writeln!(out, "points.{name} = [{}, {}, {z}]", x + dx, y + dy);
        };
        if kind == Kind::Planar {
            point("heel", -0.1, 0.0);
            point("toe", 0.15, 0.0);
        } else {
            point("front_left", 0.15, 0.06);
            point("front_right", 0.15, -0.06);
            point("rear_left", -0.1, 0.06);
            point("rear_right", -0.1, -0.06);
            // Stated: a sole that does not lie level has no edges that could be told by themselves.
            out += "edges.front = [\"front_left\", \"front_right\"]\n";
        }
    }
    out + "[[phase]]\nname = \"single_support\"\ncontacts = [\"right_foot\"]\nnext = \"swing\"\n\
           impact = [\"left_foot\"]\n\
           [[phase]]\nname = \"swing\"\ncontacts = []\nnext = \"single_support\"\n"
}
