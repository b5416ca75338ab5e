//! Torques of gaits of several phases: random problems of outputs, drives and feet, against an interior point solver (clarabel).
use super::Numbers;
use bipedc_lapack as _;
use bipedc_runtime::control::{
    Controller, Feedback, GaitParameter, GaveWay, JointCommand, MOST_FEET, Observation, PhaseLayout,
    PhaseSurfaceLayout, PhasedController, PhasedGait, PhasedLayout, StandingFoot,
};
use bipedc_runtime::{Argument, CallError, Model, Signature, State};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

const JOINTS: usize = 6;
const FRICTION: f64 = 0.6;
const EFFORT: f64 = 8.0;
const LEAST_PUSH: f64 = 3.0;
const SOLE: [f64; 2] = [-0.11, 0.13];

/// A gait in one state: its functions are numbers.
#[derive(Clone)]
struct Problem {
    outputs: usize,
    forces: usize,
    feet: [Option<StandingFoot>; MOST_FEET],
    /// `lie_derivatives`, column after column.
    lie: Vec<f64>,
    feedforward: Vec<f64>,
}

impl Problem {
    fn random(numbers: &mut Numbers, (outputs, feet): (usize, &[StandingFoot])) -> Self {
        let forces = feet.iter().map(|foot| if foot.moment.is_some() { 3 } else { 2 }).sum();
        let height = outputs + forces;
        let mut lie = vec![0.0; height * (3 + JOINTS)];
        for output in 0..outputs {
            for column in 2..3 + JOINTS {
                // Outputs have any scale.
                let size = [1.0, 30.0, 200.0][output % 3] * if column == 2 { 5.0 } else { 1.0 };
                lie[column * height + output] = size * numbers.next();
            }
        }
        let mut first = outputs;
        for foot in feet {
            let of = |row: usize, lie: &mut [f64], free: f64, numbers: &mut Numbers, size: f64| {
                lie[2 * height + row] = free;
                (3..3 + JOINTS).for_each(|column| lie[column * height + row] = size * numbers.next());
            };
            of(first, &mut lie, 20.0 * numbers.next(), numbers, 4.0);
            of(first + 1, &mut lie, 60.0 + 40.0 * numbers.next(), numbers, 4.0);
            if foot.moment.is_some() {
                of(first + 2, &mut lie, 6.0 * numbers.next(), numbers, 0.5);
            }
            first += if foot.moment.is_some() { 3 } else { 2 };
        }
        let mut standing = [None; MOST_FEET];
        standing.iter_mut().zip(feet).for_each(|(place, foot)| *place = Some(*foot));
        Self { outputs, forces, feet: standing, lie, feedforward: numbers.fill(JOINTS) }
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.lie[column * (self.outputs + self.forces) + row]
    }

    /// Rows aᵀu = b of outputs, then aᵀu ≤ b, written from the laws themselves.
    fn rows(&self) -> (Vec<[f64; JOINTS]>, Vec<f64>) {
        let (mut rows, mut bounds) = (Vec::new(), Vec::new());
        let of = |row: usize| std::array::from_fn::<f64, JOINTS, _>(|k| self.at(row, 3 + k));
        for output in 0..self.outputs {
            rows.push(of(output));
            bounds.push(-self.at(output, 2));
        }
        for joint in 0..JOINTS {
            for sign in [1.0, -1.0] {
                rows.push(std::array::from_fn(|k| if k == joint { sign } else { 0.0 }));
                bounds.push(EFFORT);
            }
        }
        // λ = free + Λ u: a force less than another one times a factor, and a constant.
        let mut less = |a: f64, i: usize, b: f64, j: usize, c: f64| {
            let (i, j) = (self.outputs + i, self.outputs + j);
            let (first, second) = (of(i), of(j));
            rows.push(std::array::from_fn(|k| a * first[k] - b * second[k]));
            bounds.push(b * self.at(j, 2) - a * self.at(i, 2) + c);
        };
        for foot in self.feet.iter().flatten() {
            let [x, z] = foot.force;
            less(-1.0, z, 0.0, z, -LEAST_PUSH);
            less(1.0, x, FRICTION, z, 0.0);
            less(-1.0, x, FRICTION, z, 0.0);
            if let Some(moment) = foot.moment {
                // −M/F_z between the ends of the sole.
                less(1.0, moment, -SOLE[0], z, 0.0);
                less(-1.0, moment, SOLE[1], z, 0.0);
            }
        }
        (rows, bounds)
    }

    /// The square of a change of the feed-forward, and how far it is beyond the conditions.
    fn change(&self, u: &[f64]) -> (f64, f64) {
        let (rows, bounds) = self.rows();
        let over = |k: usize| rows[k].iter().zip(u).map(|(a, u)| a * u).sum::<f64>() - bounds[k];
        let missed = (0..self.outputs).map(|k| over(k).abs());
        let beyond = (self.outputs..rows.len()).map(over).chain(missed).fold(0.0, f64::max);
        (u.iter().zip(&self.feedforward).map(|(a, b)| (a - b).powi(2)).sum(), beyond)
    }

    /// The least change of the feed-forward by clarabel, and whether it reached its tolerances; `None`: there is none.
    fn oracle(&self) -> Option<(Vec<f64>, bool)> {
        let (rows, bounds) = self.rows();
        let weights = CscMatrix::identity(JOINTS);
        let linear: Vec<f64> = self.feedforward.iter().map(|u| -u).collect();
        let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.to_vec()).collect();
        let matrix = CscMatrix::from(rows.iter());
        let cones = [
            SupportedConeT::ZeroConeT(self.outputs),
            SupportedConeT::NonnegativeConeT(bounds.len() - self.outputs),
        ];
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: 1e-13,
            tol_gap_rel: 1e-13,
            tol_feas: 1e-13,
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(&weights, &linear, &matrix, &bounds, &cones, settings).unwrap();
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved => Some((solver.solution.x.clone(), true)),
            SolverStatus::AlmostSolved => Some((solver.solution.x.clone(), false)),
            _ => None,
        }
    }
}

impl Model<f64> for Problem {
    fn nq(&self) -> usize {
        JOINTS + 3
    }
    fn nv(&self) -> usize {
        JOINTS + 3
    }
    fn joint_name(&self, _: usize) -> Option<&str> {
        None
    }
    fn joints(&self) -> usize {
        JOINTS
    }
    fn signature(&self, _: usize) -> Option<Signature<'_>> {
        None
    }
    fn argument_length(&self, _: Argument) -> usize {
        0
    }
    fn evaluate(&self, function: usize, _: &State<'_, f64>, output: &mut [f64]) -> Result<(), CallError> {
        match function {
            // φ = 0 moves with 1 per s.
            0 => {
                output.fill(0.0);
                output[1 + self.outputs] = 1.0;
            }
            1 => output.fill(0.0),
            2 => output.fill(1.0),
            3 => output.copy_from_slice(&self.feedforward),
            _ => output.copy_from_slice(&self.lie),
        }
        Ok(())
    }
}

impl PhasedGait<f64> for Problem {
    type Memory = Vec<f64>;

    fn memory(&self) -> Vec<f64> {
        vec![0.0; self.layout().memory()]
    }
    fn layout(&self) -> PhasedLayout {
        let Self { outputs, forces, .. } = *self;
        PhasedLayout {
            parameters: 0,
            joints: JOINTS,
            phases: 1,
            outputs,
            forces,
            friction: Some(FRICTION),
            least_push: LEAST_PUSH,
        }
    }
    fn phase(&self, index: usize) -> Option<PhaseLayout> {
        (index == 0).then_some(PhaseLayout {
            phase: 0,
            outputs: self.outputs,
            forces: self.forces,
            controlled: 0,
            wanted: 1,
            end: 2,
            feedforward: 3,
            lie_derivatives: 4,
            surface: PhaseSurfaceLayout { held: 0, equations: 0, slopes: 0, rates: 0, curvatures: 0 },
            rate_ratio: 0,
            impact_matching: true,
            feedback: None,
            feet: self.feet,
        })
    }
    fn parameter(&self, _: usize) -> Option<GaitParameter<'_>> {
        None
    }
    fn effort_limit(&self, _: usize) -> Option<f64> {
        Some(EFFORT)
    }
}

/// The controller's torques, what gave way, and how many limits it was held to.
fn torques(of: &Problem) -> (Vec<f64>, GaveWay, usize) {
    let mut controller = PhasedController::new(of.clone()).with_feedback(Feedback::default());
    let (q, mut commands) = ([0.0; JOINTS + 3], [JointCommand::Off; JOINTS]);
    let observed = Observation::new(0.0, 0, &q, &q);
    controller.begin_phase(&observed).unwrap();
    controller.command(&observed, &mut commands).unwrap();
    let status = controller.status();
    let found = commands.iter().map(|command| command.torque(0.0, 0.0)).collect();
    (found, status.gave_way, status.limits)
}

fn foot(first: usize, flat: bool) -> StandingFoot {
    let moment = flat.then_some(first + 2);
    StandingFoot { force: [first, first + 1], moment, sole: SOLE, holds: true, level: [true; 2] }
}

/// Outputs and feet as in the four phases of a step.
fn kinds() -> [(usize, Vec<StandingFoot>); 4] {
    [
        (5, vec![foot(0, true)]),
        (6, vec![foot(0, false)]),
        (4, vec![foot(0, false), foot(2, false)]),
        (3, vec![foot(0, true), foot(3, false)]),
    ]
}

#[test]
fn torques_are_the_least_change_that_meets_all_limits() {
    let mut numbers = Numbers(11);
    let (mut worst, mut held, mut solved, mut impossible, mut almost) = (0.0_f64, 0, 0, 0, 0);
    for round in 0..2000 {
        let (outputs, feet) = &kinds()[round % 4];
        let problem = Problem::random(&mut numbers, (*outputs, feet));
        let (found, gave_way, limits) = torques(&problem);
        let Some((expected, exact)) = problem.oracle() else {
            // What another solver cannot do either is said, and the drives' limits hold all the same.
            assert_ne!(gave_way, GaveWay::Nothing, "round {round}");
            assert!(found.iter().all(|u| u.abs() <= EFFORT * (1.0 + 1e-9)), "round {round}: {found:?}");
            impossible += 1;
            continue;
        };
        assert_eq!(gave_way, GaveWay::Nothing, "round {round}: {expected:?}");
        held += usize::from(limits > 0);
        solved += 1;
        let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Where the other solver is only almost done, ours is no worse than it.
        let [(own, beyond), (other, _)] = [&found, &expected].map(|u| problem.change(u));
        assert!(own <= other * (1.0 + 1e-9) && beyond < 1e-8, "round {round}: {own} {other} {beyond:e}");
        worst = if exact { worst.max(apart) } else { worst };
        almost += usize::from(!exact);
    }
    println!(
        "{solved} solved, {held} of them at a limit, {impossible} impossible, {almost} almost solved by the other, at most {worst:e} N m apart"
    );
    assert!(almost < 20 && solved > 300 && held > 150 && impossible > 300);
    assert!(worst < 1e-6, "{worst:e}");
}

/// Where outputs cannot be met they are missed as little as possible: no other torques within the limits have a smaller sum of squares,
/// tried along random directions and against clarabel's least one.
#[test]
fn outputs_give_way_as_little_as_possible() {
    let mut numbers = Numbers(12);
    let (mut tried, mut ground) = (0, 0);
    for round in 0..1000 {
        let (outputs, feet) = &kinds()[round % 4];
        let problem = Problem::random(&mut numbers, (*outputs, feet));
        let (found, gave_way, _) = torques(&problem);
        ground += usize::from(gave_way == GaveWay::Ground);
        if gave_way != GaveWay::Outputs {
            continue;
        }
        let (rows, bounds) = problem.rows();
        let length = |row: &[f64; JOINTS]| row.iter().map(|a| a * a).sum::<f64>().sqrt();
        let along = |row: &[f64; JOINTS], u: &[f64]| row.iter().zip(u).map(|(a, u)| a * u).sum::<f64>();
        let cost = |u: &[f64]| {
            let change: f64 = u.iter().zip(&problem.feedforward).map(|(a, b)| (a - b).powi(2)).sum();
            let miss = |k: usize| ((along(&rows[k], u) - bounds[k]) / length(&rows[k])).powi(2);
            change + 1e7 * (0..*outputs).map(miss).sum::<f64>()
        };
        let beyond = |u: &[f64]| {
            let over = |k: usize| (along(&rows[k], u) - bounds[k]) / length(&rows[k]);
            (*outputs..rows.len()).map(over).fold(0.0, f64::max)
        };
        assert!(beyond(&found) < 1e-8, "round {round}: {:e}", beyond(&found));
        let least = cost(&found);
        for _ in 0..200 {
            let size = 10f64.powf(3.0 * numbers.next() - 2.0);
            let other: Vec<f64> = found.iter().map(|u| u + size * numbers.next()).collect();
            if beyond(&other) <= 0.0 {
                assert!(cost(&other) >= least * (1.0 - 1e-9), "round {round}: {} {least}", cost(&other));
                tried += 1;
            }
        }
    }
    println!("{tried} other torques; the ground's limits gave way in {ground} of 1000");
    assert!(tried > 500, "{tried}");
}

/// A foot that is let go keeps its push and does not slip.
#[test]
fn a_foot_that_is_let_go_does_not_slip() {
    let mut numbers = Numbers(13);
    let (mut held, mut slips) = (0, 0);
    for round in 0..400 {
        let mut feet = vec![foot(0, true), foot(3, false)];
        feet[1].holds = false;
        let mut problem = Problem::random(&mut numbers, (3, &feet));
        // Nearly let go.
        let row = 3 + 4;
        problem.lie[2 * 8 + row] = 5.0;
        let (found, gave_way, _) = torques(&problem);
        let force = |row: usize| {
            (0..JOINTS).fold(problem.at(row, 2), |sum, k| sum + problem.at(row, 3 + k) * found[k])
        };
        let [x, z] = [force(3 + 3), force(3 + 4)];
        // Where it carries next to nothing, half a percent of the whole load may be across.
        let most = FRICTION * z.max(0.0) + 0.005 * (z + force(3 + 1));
        match gave_way {
            GaveWay::Nothing => {
                held += usize::from((x.abs() - most).abs() < 1e-9);
                assert!(x.abs() <= most + 1e-8, "round {round}: {x} {z}");
            }
            GaveWay::LettingGo => {
                slips += 1;
                assert!(x.abs() > most, "round {round}: {x} {z}");
            }
            _ => {}
        }
    }
    println!("{held} held to their friction, {slips} slip");
    assert!(held > 50 && slips > 5, "{held} {slips}");
}
