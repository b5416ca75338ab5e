//! Emitted gaits and their controller: the same bits as in process.
use super::allocation::allocations;
use super::models::{five_link_walker, three_link_walker};
use super::states::{Arguments, Random, functions};
use bipedc::gait::GaitBench;
use bipedc::progress::Silent;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{GaitPrograms, ProgramModel};
use bipedc_runtime::control::{
    Controller, Feedback, Gait, GaitController, JointCommand, Observation, Refusal,
};
use bipedc_runtime::{Model, Scalar};
use five_link_walker::gait_thesis::ThesisGait as Five;
use std::path::Path;
use three_link_walker::gait_thesis::ThesisGait as Three;

const SEED: u64 = 0x0b1b_ed0d;

fn bench(robot: &str) -> GaitBench {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot);
    let robot = Robot::read(&path).unwrap_or_else(|e| panic!("{e}"));
    GaitBench::open(&robot, "thesis", &Silent).unwrap_or_else(|e| panic!("{e}"))
}

fn same_functions(emitted: &impl Model<f64>, robot: &str) {
    let known = ProgramModel::new(bench(robot).compiled().model.clone());
    let names = functions(emitted);
    assert_eq!(names, functions::<f64>(&known));
    let mut random = Random(SEED);
    for _ in 0..100 {
        let arguments = Arguments::<f64>::random(emitted, &mut random);
        for (k, (function, length)) in names.iter().enumerate() {
            let (mut ours, mut theirs) = (vec![f64::NAN; *length], vec![f64::INFINITY; *length]);
            emitted.evaluate(k, &arguments.state(), &mut ours).unwrap();
            known.evaluate(k, &arguments.state(), &mut theirs).unwrap();
            for (a, b) in ours.iter().zip(&theirs) {
                assert!(a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(), "{function}: {a:e} {b:e}");
            }
        }
    }
}

#[test]
fn functions_of_gaits_have_the_same_bits() {
    same_functions(&Five, "five_link");
    same_functions(&Three, "three_link");
}

fn programs(bench: &GaitBench) -> GaitPrograms {
    GaitPrograms::new(bench.compiled(), &bench.gait).unwrap()
}

#[test]
fn what_a_controller_knows_is_the_same() {
    fn same(emitted: impl Gait<f64>, robot: &str) {
        let known = programs(&bench(robot));
        assert_eq!(emitted.layout(), Gait::<f64>::layout(&known));
        assert!(emitted.parameter(0).is_some() && emitted.parameter(9).is_none());
        assert!((0..9).all(|k| emitted.parameter(k) == Gait::<f64>::parameter(&known, k)));
        assert!((0..9).all(|k| emitted.effort_limit(k) == Gait::<f64>::effort_limit(&known, k)));
    }
    same(Five, "five_link");
    same(Three, "three_link");
}

/// States around the steps of a gait.
fn states(bench: &GaitBench, count: usize) -> Vec<[Vec<f64>; 2]> {
    let values = bench.values(&[]).unwrap();
    let model = bench.model().unwrap();
    let course = model.steady_course(&values).unwrap();
    let mut random = Random(SEED);
    let [start, end] = course.ends();
    let mut state = |_| {
        let phase = start + (end - start) * (0.5 + 0.6 * random.next());
        let point = course.surface(phase).unwrap();
        let rate = 1.0 + 0.5 * random.next();
        let mut off = |x: f64| x + 0.05 * random.next();
        let q = point.q.iter().map(|&x| off(x)).collect();
        [q, point.slope.iter().map(|&slope| off(slope * rate)).collect()]
    };
    (0..count).map(&mut state).collect()
}

/// Torques of a gait in these states, each after a step that begins in the state before it.
fn torques<R: Scalar + Into<f64>, G: Gait<R>>(
    gait: G,
    feedback: Feedback<R>,
    states: &[[Vec<f64>; 2]],
) -> Vec<f64> {
    let short = |x: &[f64]| x.iter().map(|&x| R::constant(x)).collect::<Vec<R>>();
    let joints = gait.layout().outputs;
    let mut controller = GaitController::new(gait, feedback);
    let mut found = Vec::new();
    for (k, pair) in states.windows(2).enumerate() {
        controller.ask(1, R::constant(0.1 + 0.01 * k as f64)).unwrap();
        let [from, to] = [&pair[0], &pair[1]].map(|[q, v]| [short(q), short(v)]);
        let begun = controller.begin_step(&from[0], &from[1]);
        let mut commands = vec![JointCommand::Off; joints];
        let seen = Observation::new(R::constant(0.0), 0, &to[0], &to[1]);
        let given = controller.command(&seen, &mut commands);
        assert_eq!(begun.is_ok(), given.is_ok(), "{begun:?} {given:?}");
        found.extend(commands.iter().map(|command| command.torque(to[0][0], to[0][0]).into()));
        found.extend(controller.arguments().iter().map(|&x| x.into()));
        let status = controller.status();
        found.extend([status.phase, status.rate, status.error, status.excess].map(Into::into));
        found.push(f64::from(status.clamped));
    }
    found
}

const FINITE: Feedback<f64> = Feedback::FiniteTime { exponent: 0.9, time_scale: 0.1 };

#[test]
fn controllers_give_the_same_bits() {
    fn same(emitted: impl Gait<f64> + Copy, robot: &str) {
        let bench = bench(robot);
        let states = states(&bench, 60);
        for feedback in [Feedback::default(), FINITE] {
            let ours = torques(emitted, feedback, &states);
            let theirs = torques::<f64, _>(programs(&bench), feedback, &states);
            assert!(ours.iter().any(|x| x.abs() > 1.0));
            assert!(ours.iter().zip(&theirs).all(|(a, b)| a.to_bits() == b.to_bits()), "{robot}");
        }
    }
    same(Five, "five_link");
    same(Three, "three_link");
}

#[test]
fn single_precision_walks_nearly_the_same() {
    let bench = bench("five_link");
    let states = states(&bench, 60);
    let single = Feedback::Linear { stiffness: 400.0f32, damping: 40.0 };
    let (long, short) =
        (torques::<f64, _>(Five, Feedback::default(), &states), torques::<f32, _>(Five, single, &states));
    // Torques come first; each against the largest of its state, because all are solved for together.
    let size = 4 + five_link_walker::gait_thesis::ARGUMENTS + 5;
    let mut worst = 0.0_f64;
    for (long, short) in long.chunks_exact(size).zip(short.chunks_exact(size)) {
        let largest = long[..4].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let apart = long[..4].iter().zip(&short[..4]).map(|(a, b)| (a - b).abs());
        worst = worst.max(apart.fold(0.0, f64::max) / largest);
    }
    println!("f32 against f64: {worst:.1e}");
    assert!(worst < 2e-3, "{worst:e}");
}

#[test]
fn controllers_do_not_allocate() {
    let bench = bench("five_link");
    let states = states(&bench, 20);
    let mut controller = GaitController::new(Five, FINITE);
    let mut commands = [JointCommand::Off; 4];
    let [q, v] = bench.beginning(&bench.values(&[]).unwrap(), 0.9).unwrap();
    let before = allocations();
    controller.begin_step(&q, &v).unwrap();
    for [q, v] in &states {
        controller.command(&Observation::new(0.0, 0, q, v), &mut commands).unwrap();
    }
    assert_eq!(allocations(), before);
}

/// What `docs/gaits.md` shows, line by line.
#[test]
fn the_page_shows_what_compiles() {
    use super::models::five_link_walker as five_link;
    fn shown(q: [f64; 7], v: [f64; 7], time: f64) -> Result<[JointCommand<f64>; 4], Refusal> {
        use five_link::gait_thesis::ThesisGait;
        let mut controller = GaitController::new(ThesisGait, Feedback::default());
        controller.ask(1, 0.3)?;
        controller.begin_step(&q, &v)?;
        let mut commands = [JointCommand::Off; 4];
        controller.command(&Observation::new(time, 0, &q, &v), &mut commands)?;
        Ok(commands)
    }
    let bench = bench("five_link");
    let [q, v] = bench.beginning(&bench.values(&[]).unwrap(), 0.9).unwrap();
    let commands = shown(q.try_into().unwrap(), v.try_into().unwrap(), 0.0).unwrap();
    assert!(
        commands.iter().all(|command| matches!(command, JointCommand::Torque(torque) if torque.is_finite()))
    );
    let (page, own) = (include_str!("../../docs/gaits.md"), include_str!("gait.rs"));
    let block = page.split("```rust\n").nth(1).unwrap().split("```").next().unwrap();
    let lines = block.lines().map(|line| line.split("//").next().unwrap().trim());
    let code: Vec<&str> = lines.filter(|line| !line.is_empty() && !line.starts_with("use ")).collect();
    assert_eq!(code.len(), 5, "{code:?}");
    assert!(code.iter().all(|line| own.contains(line)), "{code:?}");
}
