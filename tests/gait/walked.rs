//! The gait's own controller walks the whole robot, event-driven, for many steps: speeds at mid-stance against the zero dynamics.
use super::simulated::{FIVE, Gaited, THREE, swapped, walk};
use super::{bent, gait, relative};
use bipedc::gait::{GaitBench, ProgramController};
use bipedc_analysis::gait::{Course, Landing};
use bipedc_analysis::simulate::Sample;
use bipedc_analysis::simulate::phases::WalkEnd;
use bipedc_runtime::control::{Controller, Feedback, JointCommand, Observation, Refusal};
use std::fmt::Write;

const STEPS: usize = 10;

/// A scenario that begins in this state and takes ten steps of this length.
fn scenario(gaited: &Gaited, [q, v]: &[Vec<f64>; 2], length: f64) -> String {
    let mut text = format!(
        "method = \"event_driven\"\nduration = 60.0\nsteps = {STEPS}\nlog_step = 0.002\nrelative_tolerance = 1e-12\n{}\
         [assumptions]\nfriction = 100.0\nscuffing = false\npushing = false\nsecond_impact = false\nlevel = 1.0\n\
         step_length = {length}\n[control]\njoint_stops = false\n[initial]\nbase_rotation = [{:?}]\n\
         base_angular_velocity = [{:?}]\n[joint]\n",
        gaited.gravity, q[2], v[2]
    );
    for (index, joint) in gaited.joints.iter().enumerate() {
        let (q, v) = (q[3 + index], v[3 + index]);
        writeln!(text, "{joint} = {{ position = {q:?}, velocity = {v:?} }}").unwrap();
    }
    text + gaited.effects
}

/// Asks for other parameters at the beginning of each step, and keeps what is said of it.
struct Asking<'c> {
    controller: ProgramController,
    wanted: &'c [Vec<f64>],
    begun: usize,
    arguments: Vec<Vec<f64>>,
}

impl Controller<f64> for Asking<'_> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        self.controller.command(observed, commands)
    }

    fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        let values = &self.wanted[self.begun.min(self.wanted.len() - 1)];
        for (index, &value) in values.iter().enumerate() {
            self.controller.ask(index, value)?;
        }
        self.begun += 1;
        self.controller.begin_phase(observed)?;
        self.arguments.push(self.controller.arguments().to_vec());
        Ok(())
    }
}

/// φ̇ at a phase, by the cubic through the four rows around it.
fn rate_at(rows: &[[f64; 2]], phase: f64) -> f64 {
    let after = rows.iter().position(|row| row[0] > phase).unwrap();
    let four = &rows[after - 2..after + 2];
    let term = |i: usize| {
        let others = four.iter().enumerate().filter(|(j, _)| *j != i);
        four[i][1] * others.map(|(_, other)| (phase - other[0]) / (four[i][0] - other[0])).product::<f64>()
    };
    (0..4).map(term).sum()
}

/// Walks ten steps with these parameters, one set for each; the worst relative difference of the speed at mid-stance.
fn ten_steps(gaited: &Gaited, bench: &GaitBench, wanted: &[Vec<f64>], speed: f64) -> f64 {
    let state = bench.beginning(&wanted[0], speed).unwrap();
    let controller = bench.controller(Feedback::default(), &[]).unwrap().unlimited();
    let mut asking = Asking { controller, wanted, begun: 0, arguments: Vec::new() };
    let text = scenario(gaited, &state, wanted[0][0]);
    let (summary, samples) = walk(gaited.folder, &text, Some(&mut asking));
    assert_eq!((summary.end, summary.steps), (WalkEnd::Steps, STEPS), "{:?}", summary.verdict);
    let model = bench.model().unwrap();
    let mut course = model.steady_course(&wanted[0]).unwrap();
    let mut energy = course.energy(speed);
    let mut worst = 0.0_f64;
    for step in 0..STEPS {
        let times =
            [step.checked_sub(1).map_or(0.0, |k| summary.changes[k].time), summary.changes[step].time];
        let rows = rows(gaited, &samples, times, step);
        // h_p of the controller, from the measured state, is that of the course.
        let own = &asking.arguments[step];
        let known = course.arguments(own[0]);
        assert!(own.iter().zip(&known).all(|(a, b)| (a - b).abs() < 1e-7), "{step}: {own:?} {known:?}");
        let measured = rate_at(&rows, course.dead_centre);
        worst = worst.max(relative(measured, course.speed(energy).unwrap()));
        let landing: Landing = course.landing.clone();
        energy = landing.delta * (energy - course.p_minus);
        let next: Course<'_, '_> = model.course(&wanted[(step + 1).min(wanted.len() - 1)], &landing).unwrap();
        course = next;
    }
    assert_eq!(asking.controller.status().refusal, None);
    worst
}

/// φ and φ̇ of the rows of one step, legs by their roles.
fn rows(gaited: &Gaited, samples: &[Sample], [from, to]: [f64; 2], step: usize) -> Vec<[f64; 2]> {
    let inside = samples.iter().filter(|s| s.time > from + 1e-9 && s.time < to - 1e-9);
    let role = |x: &[f64]| if step % 2 == 1 { swapped(x) } else { x.to_vec() };
    inside.map(|s| [(gaited.phase)(&role(&s.q)), (gaited.phase)(&role(&s.v))]).collect()
}

fn walks(gaited: &Gaited, wanted: &[Vec<f64>], speed: f64) {
    walks_by(&gait(gaited.folder, "thesis"), gaited, wanted, speed);
}

fn walks_by(bench: &GaitBench, gaited: &Gaited, wanted: &[Vec<f64>], speed: f64) {
    let worst = ten_steps(gaited, bench, wanted, speed);
    println!("{}: mid-stance speeds of ten steps within {worst:.1e}", gaited.folder);
    assert!(worst < 1e-6, "{}: {worst:e}", gaited.folder);
}

#[test]
fn ten_steps_have_the_speeds_of_the_zero_dynamics() {
    walks(&THREE, &[vec![0.5, -0.5]], 1.5);
    walks(&THREE, &[vec![0.5, -0.5]], 2.2);
    walks(&FIVE, &[vec![0.4, 0.2, 0.3]], 1.0);
    walks(&FIVE, &[vec![0.4, 0.5, 0.1]], 1.6);
}

#[test]
fn parameters_of_each_step_are_taken_at_its_impact() {
    let leans = [-0.5, -0.6, -0.4, -0.7, -0.5, -0.3, -0.6, -0.6, -0.5, -0.45, -0.5];
    walks(&THREE, &leans.map(|lean| vec![0.5, lean]), 1.7);
    let bends = [0.3, 0.2, 0.25, 0.1, 0.3, 0.35, 0.2, 0.15, 0.2, 0.3, 0.3];
    walks(&FIVE, &bends.map(|bend| vec![0.4, 0.4, bend]), 1.5);
}

/// Outputs that are no sums of joint angles: the controller finds the end of its steps by iteration.
#[test]
fn a_surface_without_a_closed_form_is_walked_too() {
    let leans = [-0.5, -0.6, -0.4, -0.7, -0.5, -0.3, -0.6, -0.6, -0.5, -0.45, -0.5];
    walks_by(&bent(), &THREE, &leans.map(|lean| vec![0.5, lean]), 1.7);
}

/// A controller that has been told nothing gives nothing, and says why.
#[test]
fn without_a_step_there_is_no_torque() {
    let bench = gait(THREE.folder, "thesis");
    let mut controller = bench.controller(Feedback::default(), &[]).unwrap();
    let [q, v] = bench.beginning(&[0.5, -0.5], 1.5).unwrap();
    let mut commands = [JointCommand::Off; 2];
    let seen = Observation::new(0.0, 0, &q, &v);
    assert_eq!(controller.command(&seen, &mut commands), Err(Refusal::NoStep));
    assert_eq!(commands, [JointCommand::Off; 2]);
    controller.begin_phase(&seen).unwrap();
    controller.command(&seen, &mut commands).unwrap();
    let status = controller.status();
    assert!(status.refusal.is_none() && status.clamped == 0 && status.error < 1e-12, "{status:?}");
}
