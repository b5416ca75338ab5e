//! Timing as the peers' harness does it: 1024 states, 16 chunks, the fastest time of each chunk.
mod processor;

use bipedc_runtime::nalgebra::SVector;
use bipedc_runtime::{Model, Real};
use processor::processor;
use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

pub const STATES: usize = 1024;
const CHUNKS: usize = 16;

/// One state of a robot.
#[derive(Clone, Copy)]
pub struct State<R, const NQ: usize, const NV: usize> {
    pub q: SVector<R, NQ>,
    pub v: SVector<R, NV>,
    pub a: SVector<R, NV>,
    pub tau: SVector<R, NV>,
}

/// Where states come from and where figures go.
pub struct Bench {
    pub robot: &'static str,
    /// Folder with the peers' trees and states; without it states are random and a table is printed.
    models: Option<String>,
    budget: Duration,
}

impl Bench {
    /// From the command line; `None` if another robot is asked for.
    pub fn new(robot: &'static str) -> Option<Self> {
        let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
        let milliseconds = std::env::var("BENCH_MS").ok().and_then(|x| x.parse().ok()).unwrap_or(100);
        let bench = |models| Self { robot, models, budget: Duration::from_millis(milliseconds) };
        match arguments.as_slice() {
            [models, name] if name == robot => Some(bench(Some(models.clone()))),
            [_, _] => None,
            _ => {
                println!("\n{}", processor());
                println!("{robot:<32}ns per call   in lanes, a state    99.99 % below     slowest");
                Some(bench(None))
            }
        }
    }

    /// The peers' states in the order of our joints, or random ones.
    pub fn states<M: Model<f64>, const NQ: usize, const NV: usize>(
        &self,
        model: &M,
    ) -> Vec<State<f64, NQ, NV>> {
        match &self.models {
            Some(folder) => read_states(Path::new(folder), self.robot, model),
            None => random_states(),
        }
    }

    /// Times a function of one state and the same of a register full of states.
    pub fn time(
        &self,
        function: &str,
        mut one: impl FnMut(usize),
        per_call: usize,
        lanes: Option<&mut dyn FnMut(usize)>,
    ) {
        if std::env::var("BENCH_ONLY").is_ok_and(|only| only != function) {
            return;
        }
        if let Some(calls) = std::env::var("BENCH_CALLS").ok().and_then(|x| x.parse::<usize>().ok()) {
            return (0..calls).map(|k| k % STATES).for_each(&mut one);
        }
        let single = self.nanoseconds(STATES, &mut one);
        let wide = lanes
            .map(|f| self.nanoseconds(STATES / per_call, f))
            .map(|(min, median)| (min / per_call as f64, median / per_call as f64));
        if self.models.is_some() {
            let line = |peer: &str, (min, median): (f64, f64)| {
                println!(
                    "{{\"peer\":\"{peer}\",\"robot\":\"{}\",\"fn\":\"{function}\",\"ns_min\":{min:.1},\"ns_med\":{median:.1}}}",
                    self.robot
                );
            };
            line("ours", single);
            if let Some(pair) = wide {
                line("ours_lanes", pair);
            }
        } else {
            let wide = wide.map_or_else(String::new, |(min, _)| format!("{min:.1}"));
            let [usual, slowest] = slowest(&mut one);
            println!("{function:<32}{:>11.1}{wide:>20}{usual:>17.0}{slowest:>12.0}", single.0);
        }
    }

    /// Fastest and median time per call.
    fn nanoseconds(&self, calls: usize, mut f: impl FnMut(usize)) -> (f64, f64) {
        (0..calls).for_each(&mut f);
        let chunk = calls / CHUNKS;
        let mut fastest = [f64::INFINITY; CHUNKS];
        let mut passes = Vec::new();
        let start = Instant::now();
        while start.elapsed() < self.budget || passes.len() < 11 {
            let mut pass = 0.0;
            for (c, best) in fastest.iter_mut().enumerate() {
                let at = Instant::now();
                (c * chunk..(c + 1) * chunk).for_each(&mut f);
                let time = at.elapsed().as_nanos() as f64;
                *best = best.min(time);
                pass += time;
            }
            passes.push(pass / calls as f64);
        }
        passes.sort_by(f64::total_cmp);
        (fastest.iter().sum::<f64>() / calls as f64, passes[passes.len() / 2])
    }
}

/// Time (ns) below which 9999 of 10 000 single calls stay, and of the slowest of a million (`BENCH_SINGLE`), less that of reading the clock.
fn slowest(one: &mut impl FnMut(usize)) -> [f64; 2] {
    let count = std::env::var("BENCH_SINGLE").ok().and_then(|x| x.parse().ok()).unwrap_or(1_000_000);
    let sorted = |call: &mut dyn FnMut(usize)| {
        let timed = |k: usize| {
            let at = Instant::now();
            call(k % STATES);
            at.elapsed().as_nanos() as f64
        };
        let mut times: Vec<f64> = (0..count).map(timed).collect();
        times.sort_by(f64::total_cmp);
        times
    };
    let clock = sorted(&mut |_| {})[count / 2];
    let times = sorted(one);
    [times[(count - 1) * 9999 / 10_000], times[count - 1]].map(|time| (time - clock).max(0.0))
}

fn random_states<const NQ: usize, const NV: usize>() -> Vec<State<f64, NQ, NV>> {
    let mut seed = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut state = || {
        let mut q = SVector::from_fn(|_, _| random());
        if NQ > NV {
            let norm = (3..7).map(|k| q[k] * q[k]).sum::<f64>().sqrt();
            (3..7).for_each(|k| q[k] /= norm);
        }
        let mut vector = || SVector::from_fn(|_, _| random());
        State { q, v: vector(), a: vector(), tau: vector() }
    };
    (0..STATES).map(|_| state()).collect()
}

/// The peers' joints stand in Pinocchio's order, ours in that of the URDF.
fn read_states<M: Model<f64>, const NQ: usize, const NV: usize>(
    folder: &Path,
    robot: &str,
    model: &M,
) -> Vec<State<f64, NQ, NV>> {
    let tree = std::fs::read_to_string(folder.join(format!("{robot}.txt"))).expect("the peers' tree");
    let names: Vec<&str> = tree.lines().skip(1).filter_map(|line| line.split_whitespace().last()).collect();
    let names: Vec<&str> =
        names.into_iter().filter(|n| (0..model.joints()).any(|k| model.joint_name(k) == Some(n))).collect();
    let place =
        |k: usize| names.iter().position(|n| Some(*n) == model.joint_name(k)).expect("the same joints");
    let order: Vec<usize> = (0..model.joints()).map(place).collect();
    let bytes = std::fs::read(folder.join(format!("{robot}.bin"))).expect("the peers' states");
    let all: Vec<f64> =
        bytes.chunks_exact(8).map(|c| f64::from_le_bytes(c.try_into().expect("8 bytes"))).collect();
    let take = |x: &[f64], base: usize, k: usize| if k < base { x[k] } else { x[base + order[k - base]] };
    all.chunks_exact(NQ + 3 * NV)
        .map(|x| {
            let (q, rest) = x.split_at(NQ);
            let vector = |n: usize| SVector::from_fn(|k, _| take(&rest[n * NV..], NV - order.len(), k));
            State {
                q: SVector::from_fn(|k, _| take(q, NQ - order.len(), k)),
                v: vector(0),
                a: vector(1),
                tau: vector(2),
            }
        })
        .collect()
}

/// Registers full of consecutive states.
pub fn lanes<R: Real, const L: usize, const NQ: usize, const NV: usize>(
    states: &[State<f64, NQ, NV>],
    pack: impl Fn([f64; L]) -> R,
) -> Vec<State<R, NQ, NV>> {
    let packed = |group: &[State<f64, NQ, NV>]| {
        let vector = |f: &dyn Fn(&State<f64, NQ, NV>) -> SVector<f64, NV>| {
            SVector::from_fn(|k, _| pack(std::array::from_fn(|l| f(&group[l])[k])))
        };
        State {
            q: SVector::from_fn(|k, _| pack(std::array::from_fn(|l| group[l].q[k]))),
            v: vector(&|s| s.v),
            a: vector(&|s| s.a),
            tau: vector(&|s| s.tau),
        }
    };
    states.chunks_exact(L).map(packed).collect()
}

/// Calls the function that is named `F`, of one state or in lanes; inlined but for `spills.sh`, which counts its instructions.
#[allow(clippy::extra_unused_type_parameters)]
#[cfg_attr(apart, inline(never))]
#[cfg_attr(not(apart), inline(always))]
pub fn apart<F, const WIDE: bool>(f: &mut impl FnMut(usize), k: usize) {
    f(k);
}

/// Keeps a result from being optimised away.
pub fn used<T>(result: &mut T) {
    black_box(result);
}
