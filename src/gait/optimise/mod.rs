//! Gaits found by direct collocation: the whole robot's dynamics at nodes of all phases, impacts, periodicity, margins, and virtual
//! constraints whose coefficients are variables too, so that what is found is a gait file.
mod body;
mod constraints;
mod cost;
mod demands;
mod guess;
mod kept;
mod landing;
mod layout;
mod margins;
mod met;
mod mirrored;
mod rows;
mod seed;
mod similarity;
#[cfg(test)]
mod tests;
mod transcription;
mod variables;
mod write;

pub use body::{size, slides, weight};
pub use demands::{Demands, Objective, Wishes};
pub use landing::lands_by_posture;
pub use margins::MotionMargins;
pub use mirrored::{exchangeable, least_distance};
pub use rows::RowName;
pub use write::gait_text;

use bipedc_analysis::nonlinear::{
    Central, Ending, InteriorPoint, Iteration, Minimiser, Program, Solution, Start,
};
use bipedc_compiler::compile::{Collocation, NodeRow};
use bipedc_compiler::description::gait::AnyGait;
use bipedc_effects::diagnostic::Diagnostic;
use body::gravity;
use constraints::Builder;
use guess::Guess;
pub use guess::MOST_BEGINNINGS;
use landing::LandingPosture;
use layout::Layout;
use similarity::{Measure, Similarity};
use transcription::Transcription;

/// A motion that all demands hold of, or as near as the search came.
#[derive(Debug, Clone)]
pub struct Optimum {
    /// All variables, in their units.
    x: Vec<f64>,
    layout: Layout,
    /// Parts of the step that the phases took in the first guess.
    parts: Vec<f64>,
    rates: Vec<f64>,
    /// Of legs in the first guess, by phase and foot.
    regular: Vec<Vec<Option<f64>>>,
    height: f64,
    /// A place on the central path of the last stage, variables in their units: neighbours begin there.
    central: Option<Central>,
    /// How the search ended.
    pub ending: Ending,
    /// What was made small: mean squared torque over the squared twentieth of the weight (and base height), or five times the cost of transport; with what keeps a
    /// motion smooth and near rest.
    pub cost: f64,
    /// Iterations of all stages.
    pub iterations: usize,
    /// Violated constraints with by how much, in SI units, the worst first: they are compared as those of a robot of 20 kg and 0.7 m.
    pub violations: Vec<(RowName, f64)>,
    /// Of the posture that a search by [`from_landing`] began at.
    pub landing: Option<LandingPush>,
}

/// What the landing of a toe can push with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandingPush {
    /// The phase that it ends, by index.
    pub phase: usize,
    /// Smallest vertical impulse on a foot that stands, N s, at the fastest landing and in the best posture found; less what slipping and tipping forbid.
    pub push: f64,
}

/// Which of the stages of a search runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Motion without virtual constraints.
    Motion,
    /// With them.
    Gait,
}

/// Finds a gait at another speed from one that was found.
pub fn from_neighbour(
    of: &Collocation,
    demands: &Demands,
    neighbour: &Optimum,
    watch: &mut dyn FnMut(Stage, &Iteration) -> bool,
) -> Optimum {
    let from = Optimum { iterations: 0, ..neighbour.clone() };
    let found = solve(of, demands, &from, Stage::Gait, watch);
    if matches!(found.ending, Ending::Minimum | Ending::Feasible | Ending::Stopped) {
        return found;
    }
    // What is known of the central path may lead astray.
    let from = Optimum { central: None, iterations: found.iterations, ..neighbour.clone() };
    solve(of, demands, &from, Stage::Gait, watch)
}

/// Length of the first steps of a beginning by its number, m.
pub fn first_step(of: &Collocation, demands: &Demands, beginning: usize) -> f64 {
    guess::first_step(of, demands.speed, beginning)
}

/// Finds a gait from nothing but the robot. `beginning`, from 0 to below [`MOST_BEGINNINGS`], says how long the first steps are.
pub fn from_nothing(
    of: &Collocation,
    demands: &Demands,
    beginning: usize,
    watch: &mut dyn FnMut(Stage, &Iteration) -> bool,
) -> Optimum {
    let layout = Layout::new(of, &intervals(of, demands));
    let guess = guess::naive(of, &layout, demands.speed, beginning);
    in_two_stages(of, [&demands.eased(), demands], &begun(of, guess, layout), watch)
}

/// The same from a guess with a posture in which the landing of the toe pushes on all feet that stand, as far as one is found; none: the robot has no such landing.
pub fn from_landing(
    of: &Collocation,
    demands: &Demands,
    watch: &mut dyn FnMut(Stage, &Iteration) -> bool,
) -> Option<Optimum> {
    let layout = Layout::new(of, &intervals(of, demands));
    let (landing, push) = landing_of(of, demands, &layout)?;
    let guess = guess::around(of, &layout, (demands.speed, landing.step), Some(&landing));
    let start = Optimum { landing: Some(push), ..begun(of, guess, layout) };
    // The first motion keeps what the posture was found for: asked for less, it leaves it again.
    let first = Demands { impulse: demands.impulse, ..demands.eased() };
    Some(in_two_stages(of, [&first, demands], &start, watch))
}

/// The largest impulse that it makes sense to ask for, N s: what is asked for, if the landing of the toe pushes with as much in some posture; else half of what
/// it pushes with in the best that was found. None: the robot has no such landing, or it pulls in every posture that was found.
pub fn impulse_that_lands(of: &Collocation, demands: &Demands) -> Option<f64> {
    let layout = Layout::new(of, &intervals(of, demands));
    let (_, LandingPush { push, .. }) = landing_of(of, demands, &layout)?;
    match push >= demands.impulse {
        true => Some(demands.impulse),
        false => (push > 0.0).then_some(push / landing::ENOUGH),
    }
}

fn landing_of(of: &Collocation, demands: &Demands, layout: &Layout) -> Option<(LandingPosture, LandingPush)> {
    let naive = guess::naive(of, layout, demands.speed, 0);
    let landing = landing::posture(of, layout, demands, &naive)?;
    let push = LandingPush { phase: landing.phase, push: landing.reserve * demands.landing[1] };
    Some((landing, push))
}

/// The first phase of which the phase variable does not grow along the motion from which [`from_nothing`] begins, and its values at both ends.
pub fn stays(of: &Collocation, demands: &Demands) -> Option<(usize, [f64; 2])> {
    let layout = Layout::new(of, &intervals(of, demands));
    let guess = guess::naive(of, &layout, demands.speed, 0);
    let at = |p: usize, node: usize| {
        rows_of(of, &layout, &guess.x, (p, node), NodeRow::Phase).first().copied().unwrap_or(f64::NAN)
    };
    let ends = |p: usize| [0, layout.phases[p].nodes() - 1].map(|node| at(p, node));
    (0..of.phases.len()).map(|p| (p, ends(p))).find(|(_, [first, last])| last <= first)
}

/// Finds a gait near one that has curves; `seed` is derived from the form of that one.
///
/// # Errors
/// Other phases, outputs without Bezier coefficients, curves along which there are no postures.
pub fn from_gait(
    of: &Collocation,
    demands: &Demands,
    (gait, seed): (&AnyGait, &Collocation),
    watch: &mut dyn FnMut(Stage, &Iteration) -> bool,
) -> Result<Optimum, Diagnostic> {
    let layout = Layout::new(of, &intervals(of, demands));
    let guess = seed::along_curves((of, &layout), (gait, seed), demands.speed)?;
    Ok(in_two_stages(of, [&demands.eased(), demands], &begun(of, guess, layout), watch))
}

/// Intervals of a phase at least. With six of them φ̇ at the end of a phase is off by one part in a hundred, and walks are that much faster than motions.
const LEAST_INTERVALS: usize = 10;

/// Of each phase.
fn intervals(of: &Collocation, demands: &Demands) -> Vec<usize> {
    let share = |part: f64| ((part * demands.intervals as f64).ceil() as usize).max(LEAST_INTERVALS);
    guess::parts(of.phases.len()).into_iter().map(share).collect()
}

fn begun(of: &Collocation, guess: Guess, layout: Layout) -> Optimum {
    let regular = (0..of.phases.len()).map(|p| regularity(of, &layout, &guess.x, p)).collect();
    Optimum {
        x: guess.x,
        layout,
        parts: guess.parts,
        rates: guess.rates,
        regular,
        height: guess.height,
        central: None,
        ending: Ending::Infeasible,
        cost: 0.0,
        iterations: 0,
        violations: Vec::new(),
        landing: None,
    }
}

/// The largest determinant of each leg in a phase of the guess; none where it vanishes.
fn regularity(of: &Collocation, layout: &Layout, x: &[f64], p: usize) -> Vec<Option<f64>> {
    let nodes: Vec<Vec<f64>> = (0..layout.phases[p].nodes())
        .map(|node| rows_of(of, layout, x, (p, node), NodeRow::Regularity))
        .collect();
    let largest = |foot: usize| {
        let of_nodes = nodes.iter().filter_map(|node| node.get(foot).copied());
        of_nodes.max_by(|a, b| a.abs().total_cmp(&b.abs())).filter(|x| *x != 0.0)
    };
    (0..of.description.feet.len()).map(largest).collect()
}

/// The rows of a kind at a node.
fn rows_of(
    of: &Collocation,
    layout: &Layout,
    x: &[f64],
    (p, node): (usize, usize),
    kind: NodeRow,
) -> Vec<f64> {
    let local: Vec<f64> = layout.node(p, node).iter().map(|&k| x[k]).collect();
    let phase = &of.phases[p];
    let mut values = vec![0.0; phase.node.rows()];
    phase.node.values(&local, &mut values);
    let place = phase.rows.iter().find(|row| row.0 == kind);
    place.map_or_else(Vec::new, |&(_, first, count)| values[first..first + count].to_vec())
}

/// First less than what is asked for and without, then with virtual constraints.
fn in_two_stages(
    of: &Collocation,
    [first, demands]: [&Demands; 2],
    start: &Optimum,
    watch: &mut dyn FnMut(Stage, &Iteration) -> bool,
) -> Optimum {
    let mut found = solve(of, first, start, Stage::Motion, watch);
    for p in 0..of.phases.len() {
        let last = found.layout.phases[p].nodes() - 1;
        let (first, last) = (found.phase_at(of, p, 0), found.phase_at(of, p, last));
        let ends = found.layout.phases[p].ends();
        (found.x[ends[0]], found.x[ends[1]]) = (first, last);
        guess::fit(of, &found.layout.clone(), &mut found.x, p);
    }
    solve(of, demands, &found, Stage::Gait, watch)
}

impl Optimum {
    fn phase_at(&self, of: &Collocation, p: usize, node: usize) -> f64 {
        self.first_row(of, (p, node), NodeRow::Phase)
    }

    fn first_row(&self, of: &Collocation, at: (usize, usize), kind: NodeRow) -> f64 {
        rows_of(of, &self.layout, &self.x, at, kind).first().copied().unwrap_or(f64::NAN)
    }

    /// φ at the first and at the last node of a phase.
    pub fn ends(&self, p: usize) -> [f64; 2] {
        self.layout.phases[p].ends().map(|k| self.x[k])
    }

    /// Bezier coefficients of an output.
    pub fn coefficients(&self, of: &Collocation, p: usize, output: usize) -> &[f64] {
        let (first, count) = (self.layout.phases[p].coefficients.start, of.phases[p].coefficients);
        &self.x[first + output * count..first + (output + 1) * count]
    }

    /// q at a node.
    pub fn configuration(&self, p: usize, node: usize) -> &[f64] {
        let first = self.layout.motion(p, node, 0);
        &self.x[first..first + self.layout.nv]
    }

    /// q at the last node of a phase.
    pub fn last_configuration(&self, p: usize) -> &[f64] {
        self.configuration(p, self.layout.phases[p].nodes() - 1)
    }

    /// φ̇ at a node.
    pub fn rate(&self, of: &Collocation, p: usize, node: usize) -> f64 {
        self.first_row(of, (p, node), NodeRow::PhaseRate)
    }

    /// φ̇ at the last node of a phase.
    pub fn last_rate(&self, of: &Collocation, p: usize) -> f64 {
        self.rate(of, p, self.layout.phases[p].nodes() - 1)
    }

    /// The slowest φ̇ of a phase, per s: that near its dead centre.
    pub fn slowest_rate(&self, of: &Collocation, p: usize) -> f64 {
        let nodes = 0..self.layout.phases[p].nodes();
        nodes.map(|node| self.rate(of, p, node)).fold(f64::INFINITY, f64::min)
    }

    /// φ at the nodes of a phase, and the torques of each joint there, N m.
    pub fn torques(&self, of: &Collocation, p: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
        let nodes = 0..self.layout.phases[p].nodes();
        let at = nodes.clone().map(|node| self.phase_at(of, p, node)).collect();
        let torque =
            |joint: usize| nodes.clone().map(move |node| self.x[self.layout.torques(p, node) + joint]);
        (at, (0..self.layout.joints).map(|joint| torque(joint).collect()).collect())
    }

    /// How far the motion stays from limits.
    pub fn margins(&self, of: &Collocation) -> MotionMargins {
        margins::margins(of, &self.layout, &self.x)
    }

    /// Largest distance of an output from its curve at any node, rad or m: what the nodes leave of the virtual constraints.
    pub fn drift(&self, of: &Collocation) -> Vec<f64> {
        let at = |p: usize, node: usize| {
            let local: Vec<f64> = self.layout.node(p, node).iter().map(|&k| self.x[k]).collect();
            let mut values = vec![0.0; of.phases[p].node.rows()];
            of.phases[p].node.values(&local, &mut values);
            let place = of.phases[p].rows.iter().find(|row| row.0 == NodeRow::Output);
            let (first, count) = place.map_or((0, 0), |&(_, first, count)| (first, count));
            values[first..first + count].iter().fold(0.0, |a: f64, y| a.max(y.abs()))
        };
        let of_phase =
            |p: usize| (0..self.layout.phases[p].nodes()).map(|node| at(p, node)).fold(0.0, f64::max);
        (0..of.phases.len()).map(of_phase).collect()
    }

    /// Distance that the robot goes in a step, m.
    pub fn step_length(&self) -> f64 {
        let last = self.layout.phases.len() - 1;
        let end = self.configuration(last, self.layout.phases[last].nodes() - 1)[0];
        end - self.configuration(0, 0)[0]
    }

    /// ∫ Σ \|τ q̇\| dt over weight and distance, by Simpson's rule at the nodes, 1: nothing is smoothed.
    pub fn cost_of_transport(&self, of: &Collocation) -> f64 {
        cost::work(of, &self.layout, &self.x) / (of.mass * gravity(of) * self.step_length())
    }

    /// Duration of each phase, s.
    pub fn durations(&self) -> Vec<f64> {
        self.layout.phases.iter().map(|phase| self.x[phase.duration]).collect()
    }
}

/// Smallest rate of a phase variable, over its mean in the first guess.
const SLOWEST: f64 = 0.6;

/// Violations that are rounding, of a robot of 20 kg and 0.7 m.
const FEASIBLE: f64 = 1e-5;

/// Solves one stage from a motion that is known.
pub fn solve(
    of: &Collocation,
    demands: &Demands,
    from: &Optimum,
    stage: Stage,
    watch: &mut dyn FnMut(Stage, &Iteration) -> bool,
) -> Optimum {
    let layout = from.layout.clone();
    let rates: Vec<f64> = from.rates.iter().map(|rate| SLOWEST * rate).collect();
    let similar = Similarity::new(of, from.height);
    let builder = Builder {
        of,
        layout: &layout,
        similar,
        coordinates: &Measure::of_coordinates(of),
        demands,
        outputs: stage == Stage::Gait,
        rates: &rates,
        regular: &from.regular,
        parts: &from.parts,
        height: from.height,
    };
    let rows = builder.rows();
    let program = Transcription::new(of, layout, (rows, similar), demands, &from.x);
    let start = program.scaled(&from.x);
    let central = from
        .central
        .as_ref()
        .filter(|known| stage == Stage::Gait && known.multipliers.len() == program.rows.limits.len());
    let central = central.map(|known| Central { x: program.scaled(&known.x), ..known.clone() });
    let start = Start { x: &start, central: central.as_ref() };
    // From a neighbour some ten iterations do, or it was none.
    let most = if central.is_some() { 40 } else { 400 };
    let usual = InteriorPoint { iterations: most, ..InteriorPoint::default() };
    // The first stage is a guess for the second.
    let solver = match stage {
        Stage::Motion => InteriorPoint { tolerance: 1e-3, patience: (5, 0.02), ..usual },
        Stage::Gait => usual,
    };
    let found: Solution = solver.minimise(&program, &start, &mut |iteration| watch(stage, iteration));
    let name = |&(row, by): &(usize, f64)| (program.rows.names[row].clone(), by * program.rows.scale[row]);
    // A search without a result says why, by however little.
    let found_it = matches!(found.ending, Ending::Minimum | Ending::Feasible);
    let large = found.violations.iter().any(|(_, by)| by.abs() >= FEASIBLE);
    let told = found.violations.iter().filter(|(_, by)| by.abs() >= FEASIBLE || !(found_it || large));
    Optimum {
        x: program.unscaled(&found.x),
        cost: program.objective(&found.x),
        ending: found.ending,
        iterations: from.iterations + found.iterations,
        violations: told.map(name).collect(),
        parts: from.parts.clone(),
        rates: from.rates.clone(),
        regular: from.regular.clone(),
        height: from.height,
        central: found
            .central
            .filter(|_| stage == Stage::Gait)
            .map(|central| Central { x: program.unscaled(&central.x), ..central }),
        layout: program.layout.clone(),
        landing: from.landing,
    }
}
