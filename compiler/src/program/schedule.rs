//! Order of execution: short live ranges, and enough independent work in flight to hide latencies.
use super::{Instruction, Operand, Pair, Paired, Program};
use std::ops::Range;

/// Cycles until a result of addition, multiplication or fused multiply-add is ready.
const LATENCY: u32 = 4;
/// Instructions issued per cycle.
const ISSUE: u32 = 2;
/// Above this many live values the scheduler stops opening new chains.
const LIVE_LIMIT: usize = 40;
/// The same where a pair is one value: the registers of AVX2, the fewest that emitted code finds where it is fast.
const REGISTERS: usize = 16;

/// Reorders the instructions after the sines and cosines.
///
/// A list scheduler: among the instructions whose operands are ready, the one with the longest way to the
/// end, unless many values are live: then the one that frees most.
pub fn schedule(program: &mut Program) {
    let order = order(program, &[], LIVE_LIMIT);
    program.reorder(&order);
}

/// The same of pairs, each as one instruction whose result takes one register.
pub fn schedule_pairs(paired: &mut Paired) {
    let order = order(&paired.program, &paired.pairs, REGISTERS);
    paired.pairs = order.iter().map(|&k| paired.pairs[k]).collect();
    paired.program.reorder(&order);
}

fn order(program: &Program, pairs: &[Option<Pair>], limit: usize) -> Vec<usize> {
    let steps = Steps::new(program, pairs);
    let scheduled = Scheduler::new(&steps).run(limit);
    let after = scheduled.into_iter().flat_map(|step| steps.members[step].clone());
    (0..program.angles_ready).chain(after).collect()
}

/// What is done at once: an instruction, or a pair.
struct Steps {
    members: Vec<Range<usize>>,
    /// Steps whose results each one needs, without those before the sines and cosines.
    needs: Vec<Vec<usize>>,
    /// Cycles until the result is there.
    costs: Vec<u32>,
}

impl Steps {
    fn new(program: &Program, pairs: &[Option<Pair>]) -> Self {
        let (first, n) = (program.angles_ready, program.instructions.len());
        let mut members = Vec::with_capacity(n - first);
        let mut step_of = vec![0; n];
        let mut k = first;
        while k < n {
            let end = k + 1 + usize::from(pairs.get(k).is_some_and(Option::is_some));
            step_of[k..end].fill(members.len());
            members.push(k..end);
            k = end;
        }
        let needs = |range: &Range<usize>| -> Vec<usize> {
            let operands = program.instructions[range.clone()].iter().flat_map(Instruction::operands);
            let mut list: Vec<usize> = operands
                .filter_map(|o| match o {
                    Operand::Value(k) if k as usize >= first => Some(step_of[k as usize]),
                    _ => None,
                })
                .collect();
            list.sort_unstable();
            list.dedup();
            list
        };
        let cost = |range: &Range<usize>| match program.instructions[range.start] {
            Instruction::Div(..) | Instruction::Sqrt(_) => 4 * LATENCY,
            Instruction::Call(..) => 8 * LATENCY,
            Instruction::Neg(_) => 1,
            _ => LATENCY,
        };
        let (needs, costs) = (members.iter().map(needs).collect(), members.iter().map(cost).collect());
        Self { members, needs, costs }
    }
}

struct Scheduler<'a> {
    steps: &'a Steps,
    /// Way to the end in cycles.
    height: Vec<u32>,
    users: Vec<Vec<usize>>,
    /// Operands not yet computed.
    waiting: Vec<usize>,
    /// Users not yet computed.
    pending: Vec<usize>,
    ready_at: Vec<u32>,
}

impl<'a> Scheduler<'a> {
    fn new(steps: &'a Steps) -> Self {
        let n = steps.members.len();
        let mut users = vec![Vec::new(); n];
        for (k, needs) in steps.needs.iter().enumerate() {
            needs.iter().for_each(|&needed| users[needed].push(k));
        }
        let mut height = vec![0; n];
        for k in (0..n).rev() {
            let longest = users[k].iter().map(|&user| height[user]).max();
            height[k] = steps.costs[k] + longest.unwrap_or(0);
        }
        let waiting = steps.needs.iter().map(Vec::len).collect();
        let pending = users.iter().map(Vec::len).collect();
        Self { steps, height, users, waiting, pending, ready_at: vec![0; n] }
    }

    fn run(mut self, limit: usize) -> Vec<usize> {
        let n = self.height.len();
        let mut ready: Vec<usize> = (0..n).filter(|&k| self.waiting[k] == 0).collect();
        let mut order = Vec::with_capacity(n);
        let mut live = 0;
        while !ready.is_empty() {
            let now = order.len() as u32 / ISSUE;
            let best =
                (0..ready.len()).max_by_key(|&r| self.score(ready[r], now, live >= limit)).unwrap_or(0);
            let k = ready.swap_remove(best);
            // Results of the program live until its end.
            live = live + 1 - self.freed(k);
            self.steps.needs[k].iter().for_each(|&needed| self.pending[needed] -= 1);
            let done = now.max(self.ready_at[k]) + LATENCY;
            for user in std::mem::take(&mut self.users[k]) {
                self.waiting[user] -= 1;
                self.ready_at[user] = self.ready_at[user].max(done);
                if self.waiting[user] == 0 {
                    ready.push(user);
                }
            }
            order.push(k);
        }
        order
    }

    /// Values that die with this step.
    fn freed(&self, k: usize) -> usize {
        self.steps.needs[k].iter().filter(|&&needed| self.pending[needed] == 1).count()
    }

    fn score(&self, k: usize, now: u32, full: bool) -> (i64, i64, i64) {
        let stall = -i64::from(self.ready_at[k].saturating_sub(now));
        let early = -(k as i64);
        if full { (self.freed(k) as i64, stall, early) } else { (stall, i64::from(self.height[k]), early) }
    }
}
