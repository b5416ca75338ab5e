//! What the controller says where it cannot do as the gait wants: never a panic, never a torque that is no number.
use super::gait;
use bipedc::gait::GaitBench;
use bipedc_compiler::compile::GaitPrograms;
use bipedc_runtime::control::{
    Controller, Feedback, Gait, GaitController, GaitLayout, GaitParameter, GaitStatus, JointCommand,
    Observation, PhasePlace, Refusal,
};
use bipedc_runtime::{Argument, CallError, Model, Signature, State};

/// The five-link gait's controller, a step begun; states on the surface by φ and φ̇.
struct Bench {
    bench: GaitBench,
    values: Vec<f64>,
}

impl Bench {
    fn new() -> Self {
        Self { bench: gait("robots/five_link", "thesis"), values: vec![0.4, 0.2, 0.3] }
    }

    fn controller(&self) -> GaitController<f64, GaitPrograms> {
        let mut controller = self.bench.controller(Feedback::default(), &[]).unwrap();
        let [q, v] = self.bench.beginning(&self.values, 0.9).unwrap();
        controller.begin_step(&q, &v).unwrap();
        controller
    }

    fn at(&self, place: impl Fn([f64; 2]) -> f64, rate: f64) -> [Vec<f64>; 2] {
        let model = self.bench.model().unwrap();
        let course = model.steady_course(&self.values).unwrap();
        let point = course.surface(place(course.ends())).unwrap();
        [point.q, point.slope.iter().map(|slope| slope * rate).collect()]
    }
}

const UNTOUCHED: JointCommand<f64> = JointCommand::Off;

fn asked(
    controller: &mut impl Controller<f64>,
    [q, v]: &[Vec<f64>; 2],
) -> (Result<(), Refusal>, [JointCommand<f64>; 4]) {
    let mut commands = [UNTOUCHED; 4];
    let given = controller.command(&Observation::new(0.0, 0, q, v), &mut commands);
    (given, commands)
}

fn torques(commands: &[JointCommand<f64>]) -> Vec<f64> {
    commands.iter().map(|command| command.torque(0.0, 0.0)).collect()
}

#[test]
fn torques_are_clamped_and_it_is_said() {
    let bench = Bench::new();
    let mut state = bench.at(|[start, end]| 0.5 * (start + end), 1.0);
    // The torso is far off.
    state[0][2] += 0.8;
    let (mut limited, mut free) = (bench.controller(), bench.controller().unlimited());
    let [(given, clamped), (_, wanted)] = [asked(&mut limited, &state), asked(&mut free, &state)];
    assert_eq!((given, free.status().clamped), (Ok(()), 0));
    let (clamped, wanted) = (torques(&clamped), torques(&wanted));
    let mut beyond = 0.0_f64;
    for (joint, (clamped, wanted)) in clamped.iter().zip(&wanted).enumerate() {
        assert_eq!(*clamped, wanted.clamp(-150.0, 150.0), "{joint}");
        assert_eq!(limited.status().clamped >> joint & 1 == 1, wanted.abs() > 150.0, "{joint}");
        beyond = beyond.max(wanted.abs() - 150.0);
    }
    assert!(beyond > 0.0, "{wanted:?}");
    assert_eq!(limited.status().excess, beyond);
    assert!(limited.status().error > 0.1);
    // On the surface nothing is clamped, and nothing is said of it any more.
    asked(&mut limited, &bench.at(|[start, end]| 0.5 * (start + end), 0.9)).0.unwrap();
    assert_eq!((limited.status().clamped, limited.status().excess), (0, 0.0));
}

#[test]
fn the_phase_says_where_it_is() {
    let bench = Bench::new();
    let mut controller = bench.controller();
    let ends = controller.status().ends;
    for (by, rate, place, back) in [
        (0.5, 0.9, PhasePlace::Within, false),
        (-0.1, 0.9, PhasePlace::Before, false),
        (1.1, 0.9, PhasePlace::Beyond, false),
        (0.3, -0.4, PhasePlace::Within, true),
        (-0.2, -0.4, PhasePlace::Before, true),
    ] {
        let state = bench.at(|[start, end]| start + by * (end - start), rate);
        let (given, commands) = asked(&mut controller, &state);
        let GaitStatus { place: found, turns_back, phase, rate: speed, .. } = controller.status();
        assert_eq!((given, found, turns_back), (Ok(()), place, back), "{by} {rate}");
        assert!((phase - (ends[0] + by * (ends[1] - ends[0]))).abs() < 1e-12 && (speed - rate).abs() < 1e-12);
        assert!(torques(&commands).iter().all(|torque| torque.is_finite()), "{commands:?}");
    }
}

/// Behind its end h_p stays zero: the outputs are the formulas alone.
#[test]
fn behind_its_end_matching_stays_zero() {
    let bench = Bench::new();
    let mut controller = bench.controller();
    let end = controller.status().ends[1];
    let steady = bench.bench.model().unwrap();
    let course = steady.steady_course(&bench.values).unwrap();
    for beyond in [0.0, 1e-9, 0.05] {
        let mut arguments = course.arguments(end + beyond);
        arguments[6..].fill(0.0);
        let point = steady.surface(&arguments, &[0.0; 7]).unwrap();
        let state = [point.q, point.slope];
        asked(&mut controller, &state).0.unwrap();
        assert!(controller.status().error < 1e-12, "{beyond}: {:?}", controller.status());
    }
}

#[test]
fn steps_that_cannot_be_are_refused_until_one_can() {
    let bench = Bench::new();
    let good = bench.at(|[start, _]| start, 0.9);
    let inside = bench.at(|[start, end]| 0.4 * start + 0.6 * end, 0.9);
    let back = bench.at(|[start, _]| start, -0.9);
    let late = bench.at(|[_, end]| end + 0.02, 0.9);
    let mut far = bench.controller();
    far.ask(0, 2.5).unwrap();
    let cases = [
        (bench.controller(), &back, Refusal::PhaseTurnsBack),
        (bench.controller(), &late, Refusal::NoPhaseLeft),
        (far, &good, Refusal::NoEnd),
    ];
    for (mut controller, [q, v], why) in cases {
        assert_eq!(controller.begin_step(q, v), Err(why));
        for _ in 0..2 {
            assert_eq!(asked(&mut controller, &inside), (Err(why), [UNTOUCHED; 4]));
        }
        assert_eq!(controller.status().refusal, Some(why));
        controller.ask(0, 0.4).unwrap();
        controller.begin_step(&good[0], &good[1]).unwrap();
        assert_eq!(asked(&mut controller, &inside).0, Ok(()));
        assert_eq!(controller.status().refusal, None);
    }
}

#[test]
fn what_is_no_state_is_refused() {
    let bench = Bench::new();
    let mut controller = bench.controller();
    let good = bench.at(|[start, end]| 0.5 * (start + end), 0.9);
    for (part, index, value) in [(0, 3, f64::NAN), (1, 2, f64::INFINITY), (0, 2, 1e300), (1, 6, f64::NAN)] {
        let mut state = good.clone();
        state[part][index] = value;
        assert_eq!(asked(&mut controller, &state), (Err(Refusal::NotFinite), [UNTOUCHED; 4]), "{value}");
    }
    let short = [good[0][..6].to_vec(), good[1].clone()];
    assert_eq!(asked(&mut controller, &short), (Err(Refusal::WrongLength), [UNTOUCHED; 4]));
    let mut few = [UNTOUCHED; 3];
    let seen = Observation::new(0.0, 0, &good[0], &good[1]);
    assert_eq!(controller.command(&seen, &mut few), Err(Refusal::WrongLength));
    assert_eq!(controller.ask(3, 0.1), Err(Refusal::WrongLength));
    assert_eq!(controller.ask(0, f64::NAN), Err(Refusal::NotFinite));
    // None of it stays.
    assert_eq!(asked(&mut controller, &good).0, Ok(()));
    let mut spoiled = good.clone();
    spoiled[1][2] = f64::NAN;
    assert_eq!(controller.begin_step(&spoiled[0], &spoiled[1]), Err(Refusal::NotFinite));
    assert_eq!(asked(&mut controller, &good), (Err(Refusal::NotFinite), [UNTOUCHED; 4]));
}

/// What becomes of Lie derivatives.
type Spoiler = fn(&mut [f64]);

/// A gait whose Lie derivatives are spoiled.
struct Spoiled(GaitPrograms, Spoiler);

impl Model<f64> for Spoiled {
    fn nq(&self) -> usize {
        Model::<f64>::nq(&self.0)
    }
    fn nv(&self) -> usize {
        Model::<f64>::nv(&self.0)
    }
    fn joint_name(&self, index: usize) -> Option<&str> {
        Model::<f64>::joint_name(&self.0, index)
    }
    fn joints(&self) -> usize {
        Model::<f64>::joints(&self.0)
    }
    fn signature(&self, index: usize) -> Option<Signature<'_>> {
        Model::<f64>::signature(&self.0, index)
    }
    fn argument_length(&self, argument: Argument) -> usize {
        Model::<f64>::argument_length(&self.0, argument)
    }
    fn evaluate(&self, function: usize, state: &State<'_, f64>, out: &mut [f64]) -> Result<(), CallError> {
        self.0.evaluate(function, state, out)?;
        if function == self.layout().lie_derivatives {
            (self.1)(out);
        }
        Ok(())
    }
}

impl Gait<f64> for Spoiled {
    type Memory = Vec<f64>;
    fn memory(&self) -> Vec<f64> {
        self.0.memory()
    }
    fn layout(&self) -> GaitLayout {
        Gait::<f64>::layout(&self.0)
    }
    fn parameter(&self, index: usize) -> Option<GaitParameter<'_>> {
        Gait::<f64>::parameter(&self.0, index)
    }
    fn posture(&self, index: usize) -> f64 {
        Gait::<f64>::posture(&self.0, index)
    }
    fn effort_limit(&self, joint: usize) -> Option<f64> {
        Gait::<f64>::effort_limit(&self.0, joint)
    }
}

#[test]
fn a_singular_decoupling_matrix_is_named() {
    let bench = Bench::new();
    let state = bench.at(|[start, end]| 0.5 * (start + end), 0.9);
    // Columns of four outputs: h, L_f h, L_f² h, then one for each joint.
    let spoilers: [(Spoiler, Refusal); 4] = [
        (|out| out[12..].fill(0.0), Refusal::SingularOutputs),
        (|out| out.copy_within(12..16, 16), Refusal::SingularOutputs),
        (|out| out[12] = f64::NAN, Refusal::NotFinite),
        (|out| out[8] = f64::INFINITY, Refusal::NotFinite),
    ];
    for (spoil, why) in spoilers {
        let programs = GaitPrograms::new(bench.bench.compiled(), &bench.bench.gait).unwrap();
        let mut controller = GaitController::new(Spoiled(programs, spoil), Feedback::default());
        let [q, v] = bench.bench.beginning(&bench.values, 0.9).unwrap();
        controller.begin_step(&q, &v).unwrap();
        assert_eq!(asked(&mut controller, &state), (Err(why), [UNTOUCHED; 4]));
        assert_eq!(controller.status().refusal, Some(why));
    }
}
