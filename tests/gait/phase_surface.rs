//! The constraint surface of each phase, what the ground provides along it and the ratio of rates at its end, as functions of the runtime: against the whole
//! robot under its controller, from event to event.
use super::{WALKER, phased, relative, robot};
use bipedc::gait::{Chain, PhasedBench};
use bipedc::simulation::{Walker, walker};
use bipedc_analysis::simulate::phases::{
    Assumptions, Change, End, Order, PhasedRobot, Precision, Start, walk,
};
use bipedc_compiler::compile::PhasePrograms;
use bipedc_runtime::control::{
    Controller, JointCommand, Observation, PhasedController, PhasedGait, Refusal, held_contacts,
    phase_surface, surface_memory,
};
use bipedc_runtime::{Argument, Model, State};

const PRECISION: Precision = Precision {
    relative: 1e-12,
    absolute: 1e-12,
    largest_step: 0.02,
    largest_look: 0.01,
    shortest_look: 0.0,
    most_steps: 100_000,
    order: Order::Eighth,
};

/// Time, phase, state.
type Look = (f64, usize, Vec<f64>);

/// Two steps of the whole robot: everything that was seen, and the changes of phases, the beginning first.
fn walked(bench: &PhasedBench, walker: &Walker) -> (Vec<Look>, Vec<Change>, Vec<f64>) {
    // Where limits let outputs give way the robot leaves its surface.
    let controller = || {
        let mut controller = bench.controller(None, &[]).unwrap();
        controller.keep_limits([false; 2]);
        controller
    };
    let chain = Chain::new(bench, &walker.phases, controller()).unwrap();
    let begin = chain.beginning(&vec![0.0; bench.gait.parameters.len()], 0.3).unwrap().concat();
    let Walker { model, phases, feet, base, .. } = walker;
    let assumptions = Assumptions { friction: f64::INFINITY, ..Assumptions::default() };
    let robot = PhasedRobot::new(model, *base, feet, phases.clone(), assumptions, controller()).unwrap();
    robot.begin_phase(0, 0.0, &begin);
    let start = Start { time: 0.0, phase: 0, x: begin.clone() };
    let mut seen = Vec::new();
    let found = walk(&robot, start, 60.0, 8, &PRECISION, &mut |time, phase, x| {
        seen.push((time, phase, x.to_vec()));
    });
    let found = found.unwrap();
    assert_eq!(found.end, End::Changes);
    (seen, found.changes, begin)
}

fn call(model: &PhasePrograms, function: &str, state: &State<'_, f64>) -> Vec<f64> {
    let index = Model::<f64>::function(model, function).unwrap_or_else(|| panic!("no `{function}`"));
    let shape = Model::<f64>::signature(model, index).unwrap();
    let mut out = vec![f64::NAN; shape.rows * shape.columns];
    model.evaluate(index, state, &mut out).unwrap();
    out
}

/// The surface since a phase began.
struct Begun<'p> {
    programs: &'p PhasePrograms,
    /// In the gait.
    index: usize,
    name: String,
    arguments: Vec<f64>,
    held: Vec<f64>,
    near: Vec<f64>,
    controller: PhasedController<f64, PhasePrograms>,
}

impl<'p> Begun<'p> {
    /// In this state.
    fn new(bench: &PhasedBench, programs: &'p PhasePrograms, phase: usize, x: &[f64]) -> Self {
        let (q, v) = x.split_at(9);
        let mut controller = PhasedController::new(programs.clone()).unlimited().ungrounded();
        controller.begin(phase, q, v).unwrap();
        let index = controller.status().index;
        let arguments = controller.arguments().to_vec();
        let mut held = vec![0.0; 9];
        let count = held_contacts(programs, index, (q, &arguments), &mut held).unwrap();
        held.truncate(count);
        let name = bench.gait.phases[index].name.clone();
        Self { programs, index, name, arguments, held, near: q.to_vec(), controller }
    }

    /// φ and φ̇.
    fn phase(&self, x: &[f64]) -> [f64; 2] {
        let layout = PhasedGait::<f64>::phase(self.programs, self.index).unwrap();
        let state = State::new().with(Argument::Q, &x[..9]).with(Argument::V, &x[9..]);
        let all = call(self.programs, &format!("controlled_of_{}", self.name), &state);
        [all[0], all[1 + layout.outputs]]
    }

    /// T, T′ and T″.
    fn surface(&self, phi: f64) -> Result<[Vec<f64>; 3], Refusal> {
        let mut arguments = self.arguments.clone();
        arguments[0] = phi;
        if phi > arguments[2] {
            // As the controller does: behind φ₋ h_p stays zero.
            let layout = PhasedGait::<f64>::layout(self.programs);
            arguments[layout.matching()..].fill(0.0);
        }
        let mut memory = vec![0.0; surface_memory(9)];
        let point =
            phase_surface(self.programs, self.index, (&arguments, &self.held), &self.near, &mut memory)?;
        Ok([point.q.to_vec(), point.slope.to_vec(), point.curvature.to_vec()])
    }

    /// Accelerations and forces of the ground under the controller's torques, and these.
    fn moved(&mut self, x: &[f64], phase: usize) -> [Vec<f64>; 3] {
        let (q, v) = x.split_at(9);
        let mut commands = [JointCommand::Off; 6];
        self.controller.command(&Observation::new(0.0, phase, q, v), &mut commands).unwrap();
        let tau: Vec<f64> =
            [0.0; 3].into_iter().chain(commands.iter().map(|command| command.torque(0.0, 0.0))).collect();
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::Tau, &tau);
        let all = call(self.programs, &format!("constrained_dynamics_of_{}", self.name), &state);
        [all[..9].to_vec(), all[9..].to_vec(), tau]
    }
}

/// The largest difference, over the largest of what it is compared with.
fn apart(found: impl Iterator<Item = f64>, wanted: &[f64]) -> f64 {
    let size = wanted.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    found.zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / size
}

/// What a state on the way says of all: T against q, T′ φ̇ against v, T″ φ̇² + T′ φ̈ against the acceleration, with φ̈ of the zero dynamics; force of the ground
/// against those of the contacts, relative; the zero moment point against the centre of pressure, m, where one foot alone stands flat.
fn looked(begun: &mut Begun<'_>, phase: usize, x: &[f64]) -> [f64; 5] {
    let [phi, rate] = begun.phase(x);
    let [q, slope, curvature] = begun.surface(phi).unwrap();
    let [a, forces, tau] = begun.moved(x, phase);
    let at = State::new().with(Argument::Q, &q).with(Argument::V, &slope).with(Argument::A, &curvature);
    let zero = call(begun.programs, &format!("zero_dynamics_of_{}", begun.name), &at);
    let driven: f64 = zero[3..].iter().zip(&tau[3..]).map(|(part, torque)| part * torque).sum();
    let acceleration = (driven - zero[1] * rate * rate - zero[2]) / zero[0];
    let along = (0..9).map(|k| curvature[k] * rate * rate + slope[k] * acceleration);
    let ground = call(begun.programs, "ground_on_surface", &at);
    let of = |row: usize| ground[row] * acceleration + ground[3 + row] * rate * rate + ground[6 + row];
    let layout = PhasedGait::<f64>::phase(begun.programs, begun.index).unwrap();
    let feet: Vec<_> = layout.feet.iter().flatten().collect();
    let sum = |k: usize| feet.iter().map(|foot| forces[foot.force[k]]).sum::<f64>();
    let force = apart([of(0), of(1)].into_iter(), &[sum(0), sum(1)]);
    let pressure = match feet[..] {
        [foot] if foot.moment.is_some() => {
            // The right foot stands: from the middle of its sole.
            let places = call(begun.programs, "contact_positions", &State::new().with(Argument::Q, &x[..9]));
            let centre = 0.5 * (places[0] + places[1]) - forces[foot.moment.unwrap()] / forces[foot.force[1]];
            (-of(2) / of(1) - centre).abs()
        }
        _ => 0.0,
    };
    [
        apart(q.into_iter(), &x[..9]),
        apart(slope.iter().map(|s| s * rate), &x[9..]),
        apart(along, &a),
        force,
        pressure,
    ]
}

#[test]
fn the_surfaces_are_where_the_whole_robot_is() {
    let (bench, walker) = (phased(WALKER, "collocated"), walker(&robot(WALKER)).unwrap());
    let programs = PhasePrograms::new(bench.compiled(), &bench.gait).unwrap();
    let (seen, changes, begin) = walked(&bench, &walker);
    let mut begun = Begun::new(&bench, &programs, 0, &begin);
    let (mut worst, mut count, mut pressures) = ([0.0_f64; 6], 0, 0);
    let mut next = 0;
    for (time, phase, x) in &seen {
        while next < changes.len()
            && changes[next].time <= *time
            && changes[next].passage.to != changes[next].from
        {
            if *phase == changes[next].from && *time == changes[next].time {
                break;
            }
            let Change { before, after, from, passage, .. } = &changes[next];
            // η of the phase that ends, of its own surface.
            let [phi, rate] = begun.phase(before);
            let [q, slope, _] = begun.surface(phi).unwrap();
            let state = State::new().with(Argument::Q, &q).with(Argument::V, &slope);
            let eta = call(&programs, &format!("rate_ratio_of_{}", begun.name), &state)[0];
            begun = Begun::new(&bench, &programs, passage.to, after);
            worst[5] = worst[5].max(relative(eta * rate, begun.phase(after)[1]));
            assert_ne!(*from, passage.to);
            next += 1;
        }
        let found = looked(&mut begun, *phase, x);
        pressures += usize::from(found[4] > 0.0);
        (0..5).for_each(|k| worst[k] = worst[k].max(found[k]));
        count += 1;
    }
    println!("{count} states, {pressures} on one flat foot, {next} changes: {worst:?}");
    assert!(count > 200 && pressures > 50 && next >= 7, "{count} {pressures} {next}");
    let bounds = [1e-12, 1e-9, 1e-7, 1e-10, 1e-11, 1e-11];
    assert!(worst.iter().zip(bounds).all(|(worst, bound)| *worst < bound), "{worst:?}");
}

/// T′ and T″ are the slopes of T and T′, in every phase.
#[test]
fn slopes_are_those_of_the_surface() {
    let (bench, walker) = (phased(WALKER, "collocated"), walker(&robot(WALKER)).unwrap());
    let programs = PhasePrograms::new(bench.compiled(), &bench.gait).unwrap();
    let (_, changes, begin) = walked(&bench, &walker);
    let begins = changes.iter().take(3).map(|change| (change.passage.to, change.after.clone()));
    let mut worst = [0.0_f64; 2];
    for (phase, x) in [(0, begin)].into_iter().chain(begins) {
        let begun = Begun::new(&bench, &programs, phase, &x);
        let [start, end] = begun.controller.status().ends;
        let (phi, h) = (start + 0.4 * (end - start), 1e-5);
        let [low, middle, high] = [phi - h, phi, phi + h].map(|phi| begun.surface(phi).unwrap());
        for order in 0..2 {
            let slope = (0..9).map(|k| (high[order][k] - low[order][k]) / (2.0 * h));
            worst[order] = worst[order].max(apart(slope, &middle[order + 1]));
        }
        // No leg is that long, and the refusal says so.
        assert!(matches!(begun.surface(start + 3.0), Err(Refusal::Because(_) | Refusal::SingularOutputs)));
        let mut short = vec![0.0; surface_memory(9) - 1];
        let arguments = &begun.arguments;
        let refused =
            phase_surface(&programs, begun.index, (arguments, &begun.held), &begun.near, &mut short);
        assert_eq!(refused.err(), Some(Refusal::WrongLength));
    }
    println!("{worst:?}");
    assert!(worst.iter().all(|worst| *worst < 1e-6), "{worst:?}");
}
