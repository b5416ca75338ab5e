//! One call of a controller, emitted code, one core: `cargo bench --bench controllers`. Median and worst of a million calls, on states around
//! the motion of the gait.
#[path = "harness/processor.rs"]
mod processor;

use bipedc_effects::random::Random;
use bipedc_macros::Biped;
use bipedc_runtime::control::{
    Controller, Feedback, GaitController, JointCommand, Observation, PhasedController,
};
use five_link_walker::gait_thesis::ThesisGait as Five;
use processor::processor;
use seven_link_walker::gait_collocated::CollocatedGait as Seven;
use std::hint::black_box;
use std::time::Instant;
use three_link_walker::gait_thesis::ThesisGait as Three;

/// With its gait.
#[derive(Biped)]
#[biped(description = "robots/three_link", functions = ["bias"], gait = "thesis")]
pub struct ThreeLinkWalker;

/// With its gait.
#[derive(Biped)]
#[biped(description = "robots/five_link", functions = ["bias"], gait = "thesis")]
pub struct FiveLinkWalker;

/// With its gait of four phases.
#[derive(Biped)]
#[biped(description = "robots/seven_link_v1", functions = ["bias"], gait = "collocated")]
pub struct SevenLinkWalker;

const CALLS: usize = 1_000_000;
/// Different states, one after the other.
const STATES: usize = 1024;

/// States around one, each coordinate within these distances.
fn around<const N: usize>([q, v]: [[f64; N]; 2], [position, velocity]: [f64; 2]) -> Vec<[[f64; N]; 2]> {
    let mut random = Random::new(1);
    let mut near = |x: [f64; N], size: f64| x.map(|x| x + size * random.symmetric());
    (0..STATES).map(|_| [near(q, position), near(v, velocity)]).collect()
}

/// Times a million calls and prints them; the clock's own time is taken off.
fn timed(name: &str, bar: &str, mut call: impl FnMut(usize)) {
    let mut empty: Vec<u32> = (0..10_000).map(|_| nanoseconds(|| ())).collect();
    empty.sort_unstable();
    let clock = empty[empty.len() / 2];
    let mut times: Vec<u32> =
        (0..CALLS).map(|k| nanoseconds(|| call(k % STATES)).saturating_sub(clock)).collect();
    times.sort_unstable();
    let part = |part: f64| f64::from(times[((CALLS - 1) as f64 * part) as usize]) / 1e3;
    println!(
        "{name:<34} {:>9.3} {:>9.3} {:>9.3} {:>9.1} {bar:>9}",
        part(0.5),
        part(0.99),
        part(0.9999),
        part(1.0)
    );
}

fn nanoseconds(work: impl FnOnce()) -> u32 {
    let clock = Instant::now();
    work();
    clock.elapsed().as_nanos() as u32
}

fn one_phase<const N: usize, const JOINTS: usize, G: bipedc_runtime::control::Gait<f64>>(
    (name, bar): (&str, &str),
    gait: G,
    start: [[f64; N]; 2],
) {
    let mut controller = GaitController::new(gait, Feedback::default());
    controller.begin_step(&start[0], &start[1]).unwrap_or_else(|why| panic!("{name}: {why}"));
    let states = around(start, [0.05, 0.3]);
    let mut commands = [JointCommand::Off; JOINTS];
    let mut refused = 0_usize;
    timed(name, bar, |k| {
        let [q, v] = &states[k];
        let given = controller.command(&Observation::new(0.0, 0, black_box(q), black_box(v)), &mut commands);
        refused += usize::from(given.is_err());
        black_box(&commands);
    });
    assert_eq!(refused, 0, "{name}");
    timed(&format!("{name}: beginning of a step"), "", |_| {
        let _ = black_box(controller.begin_step(black_box(&start[0]), black_box(&start[1])));
    });
}

fn several_phases() {
    let mut controller = PhasedController::<f64, _>::new(Seven);
    let q = [-0.2378, 0.6529, 0.1159, -0.2838, 0.0419, 0.1260, 0.0824, 0.6380, 0.5573];
    let v = [0.39, 0.0, 0.24, 0.27, 0.29, -0.81, 0.47, -1.46, 2.86];
    let states = around([q, v], [0.02, 0.1]);
    let mut commands = [JointCommand::Off; 6];
    for (phase, name) in ["flat foot", "toe roll", "heel strike", "push-off"].into_iter().enumerate() {
        let begun = controller.begin_phase(&Observation::new(0.0, phase, &q, &v));
        begun.unwrap_or_else(|why| panic!("{name}: {why}"));
        let mut refused = 0_usize;
        timed(&format!("seven-link, {name}"), "5.0", |k| {
            let [q, v] = &states[k];
            let observed = Observation::new(0.0, phase, black_box(&q[..]), black_box(&v[..]));
            refused += usize::from(controller.command(&observed, &mut commands).is_err());
            black_box(&commands);
        });
        assert_eq!(refused, 0, "{name}");
    }
}

fn main() {
    println!("{}, {CALLS} calls on {STATES} states, µs per call", processor());
    println!("{:<34} {:>9} {:>9} {:>9} {:>9} {:>9}", "", "median", "99 %", "99.99 %", "worst", "bar");
    let three = [[-0.1, 0.99, 0.5, -0.65, -0.4], [1.4, 0.15, 0.0, 1.5, -1.5]];
    one_phase::<5, 2, _>(("three-link", "0.5"), Three, three);
    let five = [[-0.08, 0.79, 0.2, -0.35, 0.15, -0.2, 0.15], [0.9, 0.1, 0.0, 1.1, 0.1, -1.1, 0.1]];
    one_phase::<7, 4, _>(("five-link", "1.5"), Five, five);
    several_phases();
}
