//! Machines that move from point to point, all of whose joints rub: together or one after the other, with rests between, large and small; made by a Newton–Euler
//! recursion of this file.
use crate::cli::{Run, bipedc, scratch, text};
use bipedc_effects::random::Random;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const GRAVITY: f64 = 9.81;

/// A joint and the link behind it.
struct Link {
    slides: bool,
    axis: [f64; 3],
    /// From the joint before, m.
    offset: [f64; 3],
    mass: f64,
    center: [f64; 3],
    /// About the centre, along the axes, kg m².
    inertia: [f64; 3],
    /// Dry and viscous friction, N m and N m s/rad (N and N s/m).
    friction: [f64; 2],
    /// Half of the range, rad or m.
    range: f64,
    /// Standard deviation of the effort's noise, N m (N).
    noise: f64,
}

fn urdf(links: &[Link]) -> String {
    let all = |x: &[f64; 3]| format!("{} {} {}", x[0], x[1], x[2]);
    let mut told = "<robot name=\"machine\"><link name=\"stand\"/>\n".to_owned();
    for (k, link) in links.iter().enumerate() {
        let parent = if k == 0 { "stand".to_owned() } else { format!("l{k}") };
        let [x, y, z] = link.inertia;
        writeln!(
            told,
            "<link name=\"l{}\"><inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia ixx=\"{x}\" iyy=\"{y}\" izz=\"{z}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n\
             <joint name=\"j{}\" type=\"{}\"><parent link=\"{parent}\"/><child link=\"l{}\"/><origin xyz=\"{}\"/><axis xyz=\"{}\"/>\
             <limit lower=\"-9\" upper=\"9\" effort=\"1e6\" velocity=\"100\"/></joint>",
            k + 1,
            all(&link.center),
            link.mass,
            k + 1,
            if link.slides { "prismatic" } else { "revolute" },
            k + 1,
            all(&link.offset),
            all(&link.axis)
        )
        .unwrap();
    }
    told + "</robot>\n"
}

/// Efforts that a motion needs without friction: Newton and Euler, in world axes.
fn efforts(links: &[Link], motion: &[[f64; 3]]) -> Vec<f64> {
    let mut turned = Rotation3::identity();
    let [mut spin, mut turning, mut place] = [Vector3::zeros(); 3];
    // Falling upwards instead of gravity.
    let mut lift = Vector3::new(0.0, 0.0, GRAVITY);
    let mut bodies = Vec::new();
    for (link, [q, v, a]) in links.iter().zip(motion) {
        let arm = turned * Vector3::from(link.offset);
        place += arm;
        lift += turning.cross(&arm) + spin.cross(&spin.cross(&arm));
        let axis = turned * Vector3::from(link.axis);
        if link.slides {
            let slid = axis * *q;
            place += slid;
            lift += turning.cross(&slid)
                + spin.cross(&spin.cross(&slid))
                + axis * *a
                + 2.0 * spin.cross(&axis) * *v;
        } else {
            turning += axis * *a + spin.cross(&axis) * *v;
            spin += axis * *v;
            turned *= Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::from(link.axis)), *q);
        }
        let center = turned * Vector3::from(link.center);
        let pulled = lift + turning.cross(&center) + spin.cross(&spin.cross(&center));
        let inertia =
            turned.matrix() * Matrix3::from_diagonal(&link.inertia.into()) * turned.matrix().transpose();
        let moment = inertia * turning + spin.cross(&(inertia * spin));
        bodies.push((axis, place, place + center, link.mass * pulled, moment));
    }
    let of_joint = |k: usize| {
        let (axis, here, ..) = &bodies[k];
        let carried = &bodies[k..];
        let force: Vector3<f64> = carried.iter().map(|body| body.3).sum();
        let moment: Vector3<f64> = carried.iter().map(|body| body.4 + (body.2 - here).cross(&body.3)).sum();
        axis.dot(if links[k].slides { &force } else { &moment })
    };
    (0..links.len()).map(of_joint).collect()
}

/// How a machine moves.
#[derive(Clone, Copy)]
struct Moves {
    together: bool,
    /// Longest rest between two moves, s.
    rest: f64,
    seconds: f64,
    rate: f64,
    /// Largest speed, in parts of half the range per second.
    speed: f64,
    /// Noise of the encoders, rad or m.
    encoder: f64,
}

/// Angle, velocity and acceleration of a move from one place to another in a time: a polynomial of the fifth order.
fn moved([from, to]: [f64; 2], seconds: f64, time: f64) -> [f64; 3] {
    let (x, far) = (time / seconds, to - from);
    [
        from + far * x.powi(3) * (10.0 - 15.0 * x + 6.0 * x * x),
        far * 30.0 * x * x * (1.0 - x).powi(2) / seconds,
        far * 60.0 * x * (1.0 - 3.0 * x + 2.0 * x * x) / seconds.powi(2),
    ]
}

/// A move of some joints, and the friction at which each sticks afterwards, as a part of its dry friction.
struct Segment {
    from: f64,
    seconds: f64,
    places: Vec<[f64; 2]>,
    stuck: Vec<f64>,
}

fn segments(links: &[Link], how: Moves, random: &mut Random) -> Vec<Segment> {
    let mut all: Vec<Segment> = Vec::new();
    let mut here: Vec<f64> = links.iter().map(|link| link.range * random.symmetric()).collect();
    let mut time = 0.2;
    while time < how.seconds {
        // The first joint every other time: it moves for half of a log.
        let turn = if all.len().is_multiple_of(2) { 0 } else { 1 + all.len() / 2 % (links.len() - 1).max(1) };
        let places: Vec<[f64; 2]> = (0..links.len())
            .map(|k| {
                let from = here[k];
                let far = links[k].range * (0.5 + 0.5 * random.unit()) * if from > 0.0 { -1.0 } else { 1.0 };
                [from, if how.together || k == turn { far } else { from }]
            })
            .collect();
        let farthest =
            places.iter().zip(links).map(|(p, link)| (p[1] - p[0]).abs() / link.range).fold(0.0, f64::max);
        let seconds = 1.9 * farthest / (how.speed * (0.5 + 0.5 * random.unit()));
        here = places.iter().map(|[_, to]| *to).collect();
        let stuck = links.iter().map(|_| random.symmetric()).collect();
        all.push(Segment { from: time, seconds, places, stuck });
        time += seconds + how.rest * (0.3 + 0.7 * random.unit());
    }
    all
}

/// What is done to efforts, by the motion.
type Change = dyn Fn(&mut [f64], &[[f64; 3]]);

/// A log of a machine; `change` does to efforts what else is hidden.
fn log(file: &Path, links: &[Link], how: Moves, seed: u64, change: &Change) {
    let mut random = Random::new(seed);
    let all = segments(links, how, &mut random);
    let mut table = "time".to_owned();
    for k in 1..=links.len() {
        write!(table, ",j{k}/position,j{k}/effort").unwrap();
    }
    for step in 0..(how.seconds * how.rate) as u32 {
        let time = f64::from(step) / how.rate;
        let last = all.iter().rev().find(|segment| segment.from <= time);
        let motion: Vec<[f64; 3]> = (0..links.len())
            .map(|k| match last {
                Some(s) if time < s.from + s.seconds => moved(s.places[k], s.seconds, time - s.from),
                Some(s) => [s.places[k][1], 0.0, 0.0],
                None => [all[0].places[k][0], 0.0, 0.0],
            })
            .collect();
        let mut torques = efforts(links, &motion);
        for (k, (torque, link)) in torques.iter_mut().zip(links).enumerate() {
            let [dry, viscous] = link.friction;
            let at_rest = last.map_or(0.0, |segment| segment.stuck[k]);
            let sign = if motion[k][1] == 0.0 { at_rest } else { motion[k][1].signum() };
            *torque += dry * sign + viscous * motion[k][1] + link.noise * random.normal();
        }
        change(&mut torques, &motion);
        write!(table, "\n{time:.4}").unwrap();
        for (torque, [q, ..]) in torques.iter().zip(&motion) {
            write!(table, ",{:.9},{torque:.7}", q + how.encoder * random.normal()).unwrap();
        }
    }
    std::fs::write(file, table + "\n").unwrap();
}

/// What is said of two logs of a machine, whose description knows nothing of friction.
fn diagnosed(name: &str, links: &[Link], how: Moves, change: &Change) -> Run {
    let folder = scratch(name);
    let robot = folder.join("robot");
    std::fs::create_dir_all(&robot).unwrap();
    std::fs::write(robot.join("robot.urdf"), urdf(links)).unwrap();
    std::fs::write(robot.join("biped.toml"), "[base]\nkind = \"fixed\"\nlink = \"stand\"\n").unwrap();
    let logs: Vec<PathBuf> = (1..=2).map(|seed| folder.join(format!("{seed}.csv"))).collect();
    for (seed, file) in (1..).zip(&logs) {
        log(file, links, how, seed, change);
    }
    bipedc(&["diagnose", text(&robot), text(&logs[0]), "--validate", text(&logs[1]), "--json"]).ok()
}

fn nothing(_: &mut [f64], _: &[[f64; 3]]) {}

/// The effect of a kind at a joint of the answer.
fn found<'a>(answer: &'a Value, joint: &str, kind: &str) -> &'a Value {
    let all = answer["effects"].as_array().unwrap();
    let one = all.iter().find(|effect| effect["joint"] == joint && effect["kind"] == kind);
    one.unwrap_or_else(|| panic!("no {kind} at {joint}: {}", answer["summary"]))
}

fn assert_near(effect: &Value, name: &str, truth: f64, part: f64) {
    let value = effect["parameters"][name].as_f64().unwrap();
    assert!((value / truth - 1.0).abs() < part, "{name} {value} instead of {truth}: {effect}");
}

/// All friction of all joints, nothing else, and nothing left.
fn assert_friction(answer: &Value, links: &[Link]) {
    for (k, link) in links.iter().enumerate() {
        let joint = format!("j{}", k + 1);
        for (kind, name, truth) in [
            ("coulomb_friction", "torque", link.friction[0]),
            ("viscous_friction", "damping", link.friction[1]),
        ] {
            if truth > 0.0 {
                assert_near(found(answer, &joint, kind), name, truth, 0.05);
            }
        }
    }
    let hidden = links.iter().flat_map(|link| link.friction).filter(|friction| *friction > 0.0).count();
    assert_eq!(answer["effects"].as_array().unwrap().len(), hidden, "{}", answer["summary"]);
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
}

/// An arm whose joints turn about z, y, y, z, y, z and so on, each link half as heavy as the one before.
fn arm(joints: usize) -> Vec<Link> {
    let link = |k: usize| {
        let (mass, axis) = (8.0 * 0.6_f64.powi(k as i32), [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
        let usual = [6.0, 40.0, 16.0, 1.2, 1.6, 0.3, 0.2][k];
        Link {
            slides: false,
            axis: axis[[0, 1, 1, 0, 1, 0, 1][k]],
            offset: if k == 0 { [0.0, 0.0, 0.2] } else { [0.12, 0.0, 0.18] },
            mass,
            center: [0.09, 0.02, 0.11],
            inertia: [0.012 * mass, 0.01 * mass, 0.006 * mass],
            friction: [0.08 * usual, 0.05 * usual],
            range: 1.4,
            noise: 0.004 * usual,
        }
    };
    (0..joints).map(link).collect()
}

/// Before: a coupling with the fourth joint in the place of the sixth one's friction, and couplings of all joints as what cannot be told apart.
#[test]
fn friction_of_seven_joints_that_move_together_is_found() {
    let links = arm(7);
    let how = Moves { together: true, rest: 0.3, seconds: 30.0, rate: 100.0, speed: 1.2, encoder: 1e-5 };
    let answer = diagnosed("seven-together", &links, how, &nothing).json();
    assert_friction(&answer, &links);
    assert!(!answer["summary"].as_str().unwrap().contains("Quadratic drag"), "{}", answer["summary"]);
    let free = answer["summary"].as_str().unwrap();
    assert!(free.contains(", where joints do not stick "), "{free}");
}

/// Before: friction was found and taken away again, because the noise of a resting joint's speed has a sign that changes at every sample, and none was left
/// "away from jumps": that of the first joint alone was left, and couplings were said to be no other.
#[test]
fn friction_of_joints_that_move_one_after_the_other_is_found() {
    let links = arm(3);
    let how = Moves { together: false, rest: 0.5, seconds: 45.0, rate: 200.0, speed: 1.2, encoder: 1e-5 };
    let answer = diagnosed("three-in-turn", &links, how, &nothing).json();
    assert_friction(&answer, &links);
    assert!(!answer["summary"].as_str().unwrap().contains("Coupling"), "{}", answer["summary"]);
}

/// Before: "something is left that none of the library's effects explains".
#[test]
fn clipped_efforts_are_bounds() {
    let links = arm(3);
    let how = Moves { together: true, rest: 0.0, seconds: 40.0, rate: 250.0, speed: 1.5, encoder: 0.0 };
    let clipped = |torques: &mut [f64], _: &[[f64; 3]]| torques[1] = torques[1].clamp(-18.0, 18.0);
    let run = diagnosed("clipped-efforts", &links, how, &clipped);
    let answer = run.json();
    assert!(answer["warnings"].to_string().contains("the effort of `j2` is clipped at"), "{answer}");
    assert_friction(&answer, &links);
    let told = answer["assumptions"].to_string();
    assert!(told.contains("clipped efforts") && told.contains("j2"), "{told}");
}

/// A heavy machine: a boom that turns slowly about the vertical, with a slide. Before: "its exact estimate is impossible" of viscous friction that is large beside
/// what the joint needs otherwise, and dry friction in its place.
#[test]
fn friction_of_slow_and_heavy_joints_is_possible() {
    let boom = Link {
        slides: false,
        axis: [0.0, 0.0, 1.0],
        offset: [0.0, 0.0, 1.0],
        mass: 400.0,
        center: [0.8, 0.0, 0.2],
        inertia: [20.0, 120.0, 120.0],
        friction: [0.0, 900.0],
        range: 1.2,
        noise: 3.0,
    };
    let slide = Link {
        slides: true,
        axis: [0.0, 0.0, 1.0],
        offset: [1.5, 0.0, 0.0],
        mass: 90.0,
        center: [0.1, 0.0, -0.3],
        inertia: [4.0, 4.0, 2.0],
        friction: [60.0, 0.0],
        range: 0.4,
        noise: 4.0,
    };
    let how = Moves { together: true, rest: 0.0, seconds: 40.0, rate: 100.0, speed: 0.4, encoder: 0.0 };
    // The slide carries nearly the same load always: dry friction, of which one that grows with the load could not be told, is the commoner one.
    let links = [boom, slide];
    let answer = diagnosed("slow-and-heavy", &links, how, &nothing).json();
    assert_friction(&answer, &links);
}

/// A crane: 100 kg a metre and a half beyond the slide. Before: gains of both efforts, and "nothing else is missing".
#[test]
fn a_load_is_as_far_out_as_a_machine_is_large() {
    let boom = Link {
        slides: false,
        axis: [0.0, 1.0, 0.0],
        offset: [0.0, 0.0, 1.0],
        mass: 900.0,
        center: [1.6, 0.0, 0.1],
        inertia: [40.0, 700.0, 700.0],
        friction: [0.0; 2],
        range: 0.5,
        noise: 100.0,
    };
    let slide = Link {
        slides: true,
        axis: [1.0, 0.0, 0.0],
        offset: [2.5, 0.0, 0.0],
        mass: 300.0,
        center: [1.2, 0.0, 0.0],
        inertia: [5.0, 150.0, 150.0],
        friction: [0.0; 2],
        range: 0.8,
        noise: 15.0,
    };
    let how = Moves { together: true, rest: 0.0, seconds: 40.0, rate: 100.0, speed: 0.8, encoder: 0.0 };
    let load = |torques: &mut [f64], motion: &[[f64; 3]]| {
        let point = Link { offset: [1.5, 0.0, -0.2], mass: 100.0, ..fixed() };
        // What the load alone asks of both joints.
        let massless = |axis, offset, slides| Link { axis, offset, slides, ..fixed() };
        let carriers = [
            massless([0.0, 1.0, 0.0], [0.0, 0.0, 1.0], false),
            massless([1.0, 0.0, 0.0], [2.5, 0.0, 0.0], true),
            point,
        ];
        let asked = efforts(&carriers, &[motion, &[[0.0; 3]]].concat());
        torques.iter_mut().zip(asked).for_each(|(torque, more)| *torque += more);
    };
    let answer = diagnosed("crane", &[boom, slide], how, &load).json();
    let [found] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
    assert_eq!((&found["kind"], &found["link"]), (&"payload".into(), &"l2".into()), "{}", answer["summary"]);
    assert_near(found, "mass", 100.0, 0.02);
    assert_near(found, "x", 1.5, 0.05);
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
    assert!(!found["doubts"].to_string().contains("usual range"), "{found}");
}

fn fixed() -> Link {
    Link {
        slides: false,
        axis: [1.0, 0.0, 0.0],
        offset: [0.0; 3],
        mass: 0.0,
        center: [0.0; 3],
        inertia: [0.0; 3],
        friction: [0.0; 2],
        range: 0.0,
        noise: 0.0,
    }
}

/// Of the only link's inertia and a rotor nobody can tell which it is. Before: the rotor alone was named, because about one axis alone a body's inertia cannot grow so much.
#[test]
fn the_inertia_of_the_first_link_is_named_beside_a_rotor() {
    let rod = Link {
        axis: [0.0, 1.0, 0.0],
        mass: 3.0,
        center: [0.0, 0.0, -0.25],
        inertia: [0.04, 0.04, 0.002],
        range: 1.0,
        noise: 0.02,
        ..fixed()
    };
    let how = Moves { together: true, rest: 0.0, seconds: 20.0, rate: 200.0, speed: 1.5, encoder: 0.0 };
    let heavier = |torques: &mut [f64], motion: &[[f64; 3]]| torques[0] += 0.06 * motion[0][2];
    let answer = diagnosed("heavier-rod", &[rod], how, &heavier).json();
    assert_near(found(&answer, "j1", "rotor_inertia"), "inertia", 0.06, 0.05);
    assert!(answer["indistinguishable"].to_string().contains("inertia_error"), "{}", answer["summary"]);
}

/// A pendulum on a stand that leans: its encoder's offset is the same. Before: the tilt was not named.
#[test]
fn a_tilt_is_named_beside_an_offset_of_the_only_encoder() {
    let rod = Link {
        axis: [0.0, 1.0, 0.0],
        mass: 3.0,
        center: [0.0, 0.0, -0.25],
        inertia: [0.04, 0.04, 0.002],
        range: 1.0,
        noise: 0.02,
        ..fixed()
    };
    let how = Moves { together: true, rest: 0.0, seconds: 20.0, rate: 200.0, speed: 1.5, encoder: 0.0 };
    let leaning = |torques: &mut [f64], motion: &[[f64; 3]]| {
        let q = motion[0][0];
        torques[0] += 3.0 * GRAVITY * 0.25 * ((q + 0.03).sin() - q.sin());
    };
    let answer = diagnosed("leaning-pendulum", &[rod], how, &leaning).json();
    let named = answer["indistinguishable"].to_string();
    assert!(named.contains("gravity_tilt") && named.contains("encoder_offset"), "{}", answer["summary"]);
}
