//! The solver of contact problems: proximal points by Gauss and Seidel, Newton's method on the same equations.
use super::dense::dot;
use super::newton::{NEAR, NEARNESS, Newton};
use super::problem::{Law, Problem, nearest};
use super::sharing::Springs;

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Largest admissible [`Solved::residual`].
    pub relative: f64,
    /// Largest number of sweeps; a Newton step counts as one.
    pub sweeps: usize,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { relative: 1e-8, sweeps: 400 }
    }
}

/// How well a problem was solved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Solved {
    /// `|λ − prox(λ − r ξ)|` over the larger of `|λ|` (at most `LARGEST` times `|r c|`) and `|r c|` (Euclidean norms): what the
    /// laws (4.7) are missed by, as a part of the impulses.
    pub residual: f64,
    /// Sweeps of Gauss and Seidel.
    pub sweeps: usize,
    /// Newton steps.
    pub newton: usize,
    /// Whether the residual is within the tolerance.
    pub converged: bool,
}

/// Impulses larger than so many times `|r c|` do not excuse what is missed. The two ends of a motor's play are opposite rows: a Newton
/// step that takes both for closed makes impulses of any size that cancel, against which everything else seems small.
const LARGEST: f64 = 1e4;

/// Sweeps before the first Newton step.
const FIRST_SWEEPS: usize = 0;

/// Largest number of Newton steps in a row.
const NEWTON_STEPS: usize = 12;

/// What a further step with the same matrix leaves of the residual, where such steps are taken.
pub(super) const STEADY: f64 = 0.1;

/// Whole ones that are tried first.
const WHOLE_STEPS: usize = 3;

/// Largest number of those that are taken whatever they bring.
const STRIDES: usize = 16;

/// After so many sweeps, Newton steps that do not arrive are taken back.
const PATIENCE: usize = 100;

/// Solves contact problems; keeps its workspace.
#[derive(Debug, Clone, Default)]
pub struct Solver {
    pub(super) newton: Newton,
    /// Where the sweeps were.
    pub(super) start: Vec<f64>,
    /// What shares the load of redundant contacts.
    pub(super) springs: Springs,
}

impl Solver {
    /// With room for problems of so many rows.
    pub fn with_room(rows: usize) -> Self {
        Self {
            newton: Newton::with_room(rows),
            start: Vec::with_capacity(rows),
            springs: Springs::with_room(rows),
        }
    }

    /// Improves `problem.impulse` until the tolerance is met; `problem.velocity` is ξ of the answer.
    ///
    /// Sweeps find which contacts open, stick and slip; Newton's method on the semismooth equations (Alart and
    /// Curnier, 1991) then converges within a few steps, where sweeps alone take hundreds because the corners of a
    /// foot share their load. Where Newton steps stop short again and again they lead the sweeps, which would converge,
    /// around in circles: after `PATIENCE` sweeps those that do not arrive are taken back.
    ///
    /// Of the solutions, where there are several, it is the one with equal springs in all contacts, see `sharing`.
    pub fn solve(&mut self, problem: &mut Problem, tolerance: &Tolerance) -> Solved {
        let mut solved = Solved::default();
        self.newton.begin();
        if !self.springs.put_into(problem) {
            problem.weigh();
            self.arrive(problem, tolerance, NEAR, &mut solved);
            // What nearness leaves would make what rests creep.
            if let Some(smaller) = self.newton.refine(problem, solved.residual) {
                solved.residual = smaller;
            }
            return solved;
        }
        problem.weigh();
        self.arrive(problem, &self.springs.tolerance(tolerance), NEARNESS[0], &mut solved);
        if solved.converged {
            self.share(problem, &mut solved);
        }
        self.springs.take_out_of(problem);
        self.without_springs(problem, tolerance, &mut solved);
        solved
    }

    /// To the tolerance, if the sweeps suffice. `nearness`: of the first Newton steps.
    pub(super) fn arrive(
        &mut self,
        problem: &mut Problem,
        tolerance: &Tolerance,
        nearness: f64,
        solved: &mut Solved,
    ) {
        problem.at_limit.clear();
        solved.residual = residual(problem);
        if solved.residual > tolerance.relative {
            problem.find_limits();
            solved.residual = follow(problem, solved.residual);
        }
        let mut round = FIRST_SWEEPS;
        let mut turn = 0;
        while solved.residual > tolerance.relative || solved.residual.is_nan() {
            if solved.sweeps + solved.newton >= tolerance.sweeps || !solved.residual.is_finite() {
                return;
            }
            for _ in 0..round {
                sweep(problem);
            }
            if round > 0 {
                solved.sweeps += round;
                solved.residual = residual(problem);
            }
            if turn == 0 {
                self.hurry(problem, tolerance, nearness, solved);
            }
            let nearness =
                if turn % NEARNESS.len() == 0 { nearness } else { NEARNESS[turn % NEARNESS.len()] };
            self.finish(problem, tolerance, nearness, solved);
            if turn > 0 && solved.residual > tolerance.relative {
                self.stride(problem, tolerance, solved);
            }
            turn += 1;
            round = (2 * round).clamp(1, 64);
        }
        solved.converged = true;
    }

    /// Newton steps from where the sweeps are: to the end, or back.
    pub(super) fn finish(
        &mut self,
        problem: &mut Problem,
        tolerance: &Tolerance,
        nearness: f64,
        solved: &mut Solved,
    ) {
        let before = solved.residual;
        self.start.clear();
        self.start.extend_from_slice(&problem.impulse);
        for _ in 0..NEWTON_STEPS {
            if solved.residual <= tolerance.relative {
                return;
            }
            if let Some(smaller) = self.newton.refine(problem, STEADY * solved.residual) {
                solved.residual = smaller;
                continue;
            }
            solved.newton += 1;
            match self.newton.step(problem, solved.residual, nearness) {
                Some(smaller) => solved.residual = smaller,
                None => break,
            }
        }
        if solved.residual > tolerance.relative && solved.sweeps > PATIENCE {
            problem.impulse.copy_from_slice(&self.start);
            solved.residual = before;
        }
    }

    /// Whole Newton steps, whatever becomes of the residual in between; back if they do not arrive. Where contacts change between sticking,
    /// slipping and letting go the first one may miss more than was missed before, and the next one hits: shorter steps would be many.
    fn hurry(&mut self, problem: &mut Problem, tolerance: &Tolerance, nearness: f64, solved: &mut Solved) {
        let before = solved.residual;
        self.start.clear();
        self.start.extend_from_slice(&problem.impulse);
        for _ in 0..WHOLE_STEPS {
            let present = solved.residual;
            solved.newton += 1;
            let leapt = self.newton.leap(problem, nearness);
            problem.at_limit.clear();
            let Some(found) = leapt else { break };
            solved.residual = found;
            if found > tolerance.relative && found < STEADY * present {
                solved.residual = self.newton.refine(problem, STEADY * found).unwrap_or(found);
            }
            if solved.residual <= tolerance.relative {
                return;
            }
            if !found.is_finite() {
                break;
            }
        }
        problem.impulse.copy_from_slice(&self.start);
        self.newton.begin();
        solved.residual = before;
        residual(problem);
    }

    /// Whole Newton steps, each as long as the impulses are large, whatever becomes of the residual in between; back if they do
    /// not arrive. Where corners cannot all stick and only forces between them make one slip, which the motion does not feel,
    /// the residual stays the same until they are large enough.
    fn stride(&mut self, problem: &mut Problem, tolerance: &Tolerance, solved: &mut Solved) {
        let before = solved.residual;
        self.start.clear();
        self.start.extend_from_slice(&problem.impulse);
        for _ in 0..STRIDES {
            // What is missed divided by this is of the size of the impulses.
            let nearness = solved.residual.clamp(NEAR, 1.0);
            solved.newton += 1;
            let Some(found) = self.newton.leap(problem, nearness) else { break };
            solved.residual = if found <= tolerance.relative { found } else { admit(problem) };
            if solved.residual <= tolerance.relative {
                return;
            }
            if solved.residual.is_nan() {
                break;
            }
        }
        problem.impulse.copy_from_slice(&self.start);
        solved.residual = before;
        residual(problem);
    }

    /// Sweeps alone, for comparison.
    pub fn solve_by_sweeps(problem: &mut Problem, tolerance: &Tolerance) -> Solved {
        problem.weigh();
        let mut solved = Solved { residual: residual(problem), ..Solved::default() };
        while solved.residual > tolerance.relative && solved.sweeps < tolerance.sweeps {
            sweep(problem);
            solved.sweeps += 1;
            solved.residual = residual(problem);
        }
        solved.converged = solved.residual <= tolerance.relative;
        solved
    }
}

/// Every block once, each with the latest impulses of the others.
fn sweep(problem: &mut Problem) {
    sweep_by(problem, 1.0);
}

/// The same with this part of the steps of the proximal point.
fn sweep_by(problem: &mut Problem, part: f64) {
    for index in 0..problem.blocks.len() {
        let block = problem.blocks[index];
        let row = block.first;
        let wanted = |problem: &Problem, r: usize| {
            problem.impulse[r] - part * problem.weight[r] * problem.velocity_of(r)
        };
        let first = wanted(problem, row);
        match block.law {
            Law::Unilateral => problem.impulse[row] = first.max(0.0),
            Law::Limited { low, high } => problem.impulse[row] = first.max(low).min(high),
            Law::Contact { friction, tangents, cone } => {
                problem.impulse[row] = first.max(0.0);
                let limit = friction * problem.impulse[row];
                let second = if tangents == 2 { wanted(problem, row + 2) } else { 0.0 };
                let found = nearest([wanted(problem, row + 1), second], limit, tangents, cone);
                problem.impulse[row + 1..row + 1 + tangents].copy_from_slice(&found[..tangents]);
            }
            Law::Sole { friction, turning, normals, cone } => {
                let load = problem.load(row, normals);
                let found = nearest([first, wanted(problem, row + 1)], friction * load, 2, cone);
                problem.impulse[row..row + 2].copy_from_slice(&found);
                let most = turning * load;
                problem.impulse[row + 2] = wanted(problem, row + 2).max(-most).min(most);
            }
        }
    }
}

/// Lets the guess go on as it went, if less is missed there; what is missed then. Newton's method squares what it begins with: where
/// contacts slide this is an elimination less.
fn follow(problem: &mut Problem, present: f64) -> f64 {
    // Where nothing slides the equations are linear, and one step hits from anywhere.
    if !problem.at_limit.contains(&true) || problem.trend.iter().all(|trend| *trend == 0.0) {
        return present;
    }
    problem.impulse.iter_mut().zip(&problem.trend).for_each(|(impulse, trend)| *impulse += trend);
    let found = residual(problem);
    let better = found < present;
    if !better {
        problem.impulse.iter_mut().zip(&problem.trend).for_each(|(impulse, trend)| *impulse -= trend);
    }
    // Once is enough.
    problem.trend.fill(0.0);
    if better { found } else { residual(problem) }
}

/// Takes the nearest admissible impulses; their residual.
fn admit(problem: &mut Problem) -> f64 {
    sweep_by(problem, 0.0);
    residual(problem)
}

/// [`Solved::residual`]; computes `problem.velocity`.
pub(super) fn residual(problem: &mut Problem) -> f64 {
    problem.move_by_impulses();
    residual_at_hand(problem)
}

/// The same where `problem.velocity` is known.
pub(super) fn residual_at_hand(problem: &mut Problem) -> f64 {
    // No early end: so they are compared side by side.
    if !problem.velocity.iter().fold(true, |all, velocity| all & velocity.is_finite()) {
        // Comparisons below would take NaN for an open contact.
        return f64::NAN;
    }
    // Taken out, since the laws read the rest of the problem.
    let mut missed = std::mem::take(&mut problem.missed);
    for ((missed, impulse), (weight, velocity)) in
        missed.iter_mut().zip(&problem.impulse).zip(problem.weight.iter().zip(&problem.velocity))
    {
        *missed = impulse - weight * velocity;
    }
    for block in &problem.blocks {
        let row = block.first;
        let wanted = &mut missed[row..row + block.size()];
        match block.law {
            Law::Unilateral => wanted[0] = wanted[0].max(0.0),
            Law::Limited { low, high } => wanted[0] = wanted[0].max(low).min(high),
            Law::Contact { friction, tangents, cone } => {
                wanted[0] = wanted[0].max(0.0);
                let limit = friction * problem.impulse[row].max(0.0);
                let both = [wanted[1], if tangents == 2 { wanted[2] } else { 0.0 }];
                let found = nearest(both, limit, tangents, cone);
                wanted[1..].copy_from_slice(&found[..tangents]);
            }
            Law::Sole { friction, turning, normals, cone } => {
                let load = problem.load(row, normals);
                let found = nearest([wanted[0], wanted[1]], friction * load, 2, cone);
                wanted[..2].copy_from_slice(&found);
                wanted[2] = wanted[2].max(-turning * load).min(turning * load);
            }
        }
    }
    missed.iter_mut().zip(&problem.impulse).for_each(|(missed, impulse)| *missed -= impulse);
    let (miss, size) = (dot(&missed, &missed), dot(&problem.impulse, &problem.impulse));
    problem.missed = missed;
    let scale = f64::max(size.min(LARGEST * LARGEST * problem.driven), problem.driven).sqrt();
    if scale > 0.0 { miss.sqrt() / scale } else { miss.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::super::problem::{Block, Law, Problem};
    use super::residual;

    /// Both ends of a play at once, and a body that falls onto the ground meanwhile.
    #[test]
    fn impulses_that_cancel_do_not_excuse_what_is_missed() {
        let mut problem = Problem::default();
        problem.clear(3);
        problem.set_delassus(|i, j| [[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]][i][j]);
        problem.free = vec![1e-3, 1e-3, -1.0];
        problem.blocks = (0..3).map(|first| Block { first, law: Law::Unilateral }).collect();
        problem.weigh();
        problem.impulse = vec![1e20, 1e20, 0.0];
        problem.move_by_impulses();
        assert!(residual(&mut problem) > 1e-5);
        problem.impulse = vec![0.0, 0.0, 1.0];
        problem.move_by_impulses();
        assert!(residual(&mut problem) < 1e-15);
    }
}
