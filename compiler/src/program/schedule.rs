//! Order of execution: short live ranges, and enough independent work in flight to hide latencies.
use super::{Instruction, Operand, Program};

/// Cycles until a result of addition, multiplication or fused multiply-add is ready.
const LATENCY: u32 = 4;
/// Instructions issued per cycle.
const ISSUE: u32 = 2;
/// Above this many live values the scheduler stops opening new chains.
const LIVE_LIMIT: i32 = 40;

/// Reorders the instructions after the sines and cosines.
///
/// A list scheduler: among the instructions whose operands are ready, the one with the longest way to the
/// end, unless many values are live: then the one that frees most.
pub fn schedule(program: &mut Program) {
    let first = program.angles_ready;
    let n = program.instructions.len();
    if n - first < 3 {
        return;
    }
    let order = Scheduler::new(program, first).run();
    let order: Vec<usize> = (0..first).chain(order).collect();
    program.reorder(&order);
}

struct Scheduler<'a> {
    program: &'a Program,
    first: usize,
    /// Way to the end in cycles.
    height: Vec<u32>,
    users: Vec<Vec<u32>>,
    /// Operands not yet computed.
    waiting: Vec<u32>,
    /// Users not yet computed; outputs count as one that never comes.
    pending: Vec<u32>,
    ready_at: Vec<u32>,
}

fn values(instruction: &Instruction) -> impl Iterator<Item = usize> {
    let mut list: Vec<usize> = instruction
        .operands()
        .filter_map(|o| match o {
            Operand::Value(k) => Some(k as usize),
            _ => None,
        })
        .collect();
    list.sort_unstable();
    list.dedup();
    list.into_iter()
}

impl<'a> Scheduler<'a> {
    fn new(program: &'a Program, first: usize) -> Self {
        let n = program.instructions.len();
        let mut scheduler = Self {
            program,
            first,
            height: vec![0; n],
            users: vec![Vec::new(); n],
            waiting: vec![0; n],
            pending: vec![0; n],
            ready_at: vec![0; n],
        };
        for k in first..n {
            for value in values(&program.instructions[k]).filter(|&v| v >= first) {
                scheduler.users[value].push(k as u32);
                scheduler.waiting[k] += 1;
                scheduler.pending[value] += 1;
            }
        }
        for k in (first..n).rev() {
            let cost = match program.instructions[k] {
                Instruction::Div(..) | Instruction::Sqrt(_) => 4 * LATENCY,
                Instruction::Call(..) => 8 * LATENCY,
                Instruction::Neg(_) => 1,
                _ => LATENCY,
            };
            let longest = scheduler.users[k].iter().map(|&u| scheduler.height[u as usize]).max();
            scheduler.height[k] = cost + longest.unwrap_or(0);
        }
        scheduler
    }

    fn run(mut self) -> Vec<usize> {
        let n = self.program.instructions.len();
        let mut ready: Vec<usize> = (self.first..n).filter(|&k| self.waiting[k] == 0).collect();
        let mut order = Vec::with_capacity(n - self.first);
        let (mut issued, mut live) = (0u32, 0i32);
        while !ready.is_empty() {
            let now = issued / ISSUE;
            let best =
                (0..ready.len()).max_by_key(|&r| self.score(ready[r], now, live >= LIVE_LIMIT)).unwrap_or(0);
            let k = ready.swap_remove(best);
            live -= self.freed(k) - 1;
            for value in values(&self.program.instructions[k]).filter(|&v| v >= self.first) {
                self.pending[value] -= 1;
            }
            issued += 1;
            let done = now.max(self.ready_at[k]) + LATENCY;
            for u in std::mem::take(&mut self.users[k]) {
                let u = u as usize;
                self.waiting[u] -= 1;
                self.ready_at[u] = self.ready_at[u].max(done);
                if self.waiting[u] == 0 {
                    ready.push(u);
                }
            }
            order.push(k);
        }
        order
    }

    /// Values that die with this instruction.
    fn freed(&self, k: usize) -> i32 {
        values(&self.program.instructions[k]).filter(|&v| v >= self.first && self.pending[v] == 1).count()
            as i32
    }

    fn score(&self, k: usize, now: u32, full: bool) -> (i32, i32, i64, i64) {
        let stall = -(self.ready_at[k].saturating_sub(now) as i32);
        let freed = self.freed(k);
        let height = i64::from(self.height[k]);
        let early = -(k as i64);
        if full { (freed, stall, early, 0) } else { (stall, 0, height, early) }
    }
}
