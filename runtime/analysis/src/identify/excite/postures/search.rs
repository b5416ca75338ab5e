//! The search for postures that tell most.
use super::descent::Descent;
use super::ground::{Conditions, Tolerance, perturbed};
use super::problem::{Point, Problem};
use super::standing::StanceModel;
use super::start::feasible;
use crate::identify::excite::{Criterion, Quality, Scaling};
use crate::polygon::Polygon;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::random::Random;
use serde::Serialize;
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Robots on which the answer is tried, other than those of the search.
const TRIED: usize = 200;

/// What is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostureRequest {
    /// Number of postures.
    pub postures: usize,
    /// Number of foot placements that they share.
    pub placements: usize,
    /// What is made small.
    pub criterion: Criterion,
    /// Lengths of the regressor's columns.
    pub scaling: Scaling,
    /// Part of every joint's range that is left unused.
    pub margin: f64,
    /// Distance of the expected centre of pressure from the support's edge, m.
    pub stability: f64,
    /// Distance between the soles, m.
    pub gap: f64,
    /// How wrong the described parameters may be.
    pub tolerance: Tolerance,
    /// Of the random starts.
    pub seed: u64,
    /// Number of starts.
    pub starts: usize,
    /// Most evaluations in one start.
    pub evaluations: usize,
    /// After this the best so far is the answer.
    pub time_limit: Option<Duration>,
}

/// A posture of the answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Planned {
    /// Index of its placement.
    pub placement: usize,
    /// Positions of all joints, rad or m.
    pub joints: Vec<f64>,
    /// Expected centre of pressure in the standing sole's frame, m.
    pub center: [f64; 2],
    /// Its distance from the support's edge, m.
    pub stability: f64,
}

/// One start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Run {
    /// Of the feasible postures it began with.
    pub before: Quality,
    /// Of what it led to.
    pub after: Quality,
    /// Evaluations of cost and gradient.
    pub evaluations: usize,
}

/// Postures and how they were found.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignedPostures {
    /// x, y (m) and yaw (rad) of the other sole in the standing sole's frame.
    pub placements: Vec<[f64; 3]>,
    /// In the order of their placements.
    pub postures: Vec<Planned>,
    /// All starts that were made, in order.
    pub runs: Vec<Run>,
    /// Index of the start that the answer is from.
    pub best: usize,
    /// Smallest distance between the soles, m.
    pub gap: f64,
    /// Smallest distance of the centre of pressure from the support's edge over robots that are as wrong as the tolerance
    /// allows and that played no part in the search, m; negative: outside.
    pub stability_of_others: f64,
    /// Part of them, times postures, that stand.
    pub standing_others: f64,
    /// Whether the search was ended early, in its last start too.
    pub stopped: bool,
}

/// Looks for the postures that tell most and keep all conditions; `progress` hears which part is done, `stop` is asked
/// whether to end with the best so far.
///
/// Every start begins with feasible postures and stays feasible: conditions are logarithmic barriers that fade from round
/// to round; within a round a quasi-Newton method of limited memory (Nocedal and Wright, chapter 7) on the surface of
/// postures with both soles flat, with exact gradients. Dense methods are cubic in the number of unknowns, hundreds here.
///
/// # Errors
/// Requests without meaning; no feasible postures; fewer postures than parameters.
pub fn design_postures(
    standing: &StanceModel<'_>,
    request: &PostureRequest,
    progress: &dyn Fn(f64),
    stop: &dyn Fn() -> bool,
) -> Result<DesignedPostures, Diagnostic> {
    check(standing, request)?;
    let begun = Instant::now();
    // Asked only before more is done: once it says so, the search ended early.
    let stopped = Cell::new(false);
    let late = || {
        stopped.set(stop() || request.time_limit.is_some_and(|limit| begun.elapsed() >= limit));
        stopped.get()
    };
    let mut random = Random::new(request.seed);
    let conditions = conditions(standing, request, &mut random);
    let problem =
        Problem { standing, conditions: &conditions, criterion: request.criterion, scaling: request.scaling };
    let (mut runs, mut best): (Vec<Run>, Option<(usize, Point)>) = (Vec::new(), None);
    for start in 0..request.starts {
        let wanted = (request.postures, request.placements);
        let begin = match feasible(standing, &conditions, wanted, &mut random, &late) {
            Ok(found) => point(found),
            // Time ran out before this start had its postures: what was found before is the answer.
            Err(_) if !runs.is_empty() && late() => break,
            Err(error) => return Err(error),
        };
        let report = |part: f64| {
            let starts = (start as f64 + part) / request.starts as f64;
            let limit = request.time_limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
            progress(starts.max(begun.elapsed().as_secs_f64() / limit).min(1.0));
        };
        let (run, end) = improved(&problem, request, begin, (&report, &late));
        runs.push(run);
        if best.as_ref().is_none_or(|(k, _)| better(request.criterion, &run.after, &runs[*k].after)) {
            best = Some((runs.len() - 1, end));
        }
        if runs.len() < request.starts && late() {
            break;
        }
    }
    let (best, found) = best.ok_or_else(|| Diagnostic::error("no postures were found"))?;
    if !runs[best].after.condition_number.is_finite() {
        return Err(Diagnostic::error("these postures do not tell all parameters")
            .help("ask for more --postures or --placements, or widen the joints' limits"));
    }
    Ok(judged(standing, request, &conditions, (found, best, runs), stopped.get()))
}

/// What a start leads to; what it began with if that tells more.
fn improved(
    problem: &Problem<'_, '_>,
    request: &PostureRequest,
    begin: Point,
    (report, stop): (&dyn Fn(f64), &dyn Fn() -> bool),
) -> (Run, Point) {
    let descent = Descent { problem, left: Cell::new(request.evaluations), stop };
    let end = descent.minimised(&begin, request.evaluations, report);
    let (before, after) = (problem.quality(&begin), problem.quality(&end));
    let (after, end) =
        if better(request.criterion, &after, &before) { (after, end) } else { (before, begin) };
    (Run { before, after, evaluations: request.evaluations - descent.left.get() }, end)
}

fn better(criterion: Criterion, one: &Quality, other: &Quality) -> bool {
    match criterion {
        Criterion::Condition => one.condition_number < other.condition_number,
        Criterion::Information => one.log_determinant > other.log_determinant,
    }
}

fn check(standing: &StanceModel<'_>, request: &PostureRequest) -> Result<(), Diagnostic> {
    let refuse = |what: String, help: &str| Err(Diagnostic::error(what).help(help.to_owned()));
    let unknowns = standing.parts.columns.len();
    if 2 * request.postures < unknowns {
        let message = format!(
            "{} postures give {} equations for {unknowns} parameters",
            request.postures,
            2 * request.postures
        );
        return refuse(message, &format!("ask for at least {} postures; 50 are usual", unknowns.div_ceil(2)));
    }
    if !(1..=request.postures).contains(&request.placements) || request.postures > 2000 {
        let message = format!("{} postures on {} placements", request.postures, request.placements);
        return refuse(
            message,
            "give at most 2000 postures, and 1 to as many placements as there are postures",
        );
    }
    if standing.joints() < 7 {
        return refuse(
            format!("{} joints between two flat soles leave no freedom", standing.joints()),
            "postures are designed for robots in three dimensions with six or more joints between two feet",
        );
    }
    let lengths = [request.stability, request.gap, request.tolerance.center, request.tolerance.mass];
    if !(0.0..=0.9).contains(&request.margin) || lengths.iter().any(|x| !(0.0..1.0).contains(x)) {
        return refuse(
            "a margin has no meaning".to_owned(),
            "give parts between 0 and 0.9, lengths from 0 to 1 m",
        );
    }
    if !(1..=10_000).contains(&request.starts) || request.evaluations > 10_000_000 {
        return refuse(format!("{} starts", request.starts), "give 1 to 10000 starts");
    }
    Ok(())
}

fn conditions(standing: &StanceModel<'_>, request: &PostureRequest, random: &mut Random) -> Conditions {
    let within = |(low, high): (f64, f64)| {
        let unused = 0.5 * request.margin * (high - low);
        (low + unused, high - unused)
    };
    Conditions {
        limits: standing.parts.joints.iter().map(|joint| within(joint.limits)).collect(),
        stability: request.stability,
        gap: request.gap,
        others: perturbed(&standing.parts.parameters, &request.tolerance, random),
    }
}

fn point(found: Vec<super::start::Placed>) -> Point {
    let of = found.iter().enumerate().flat_map(|(k, (_, own))| vec![k; own.len()]).collect();
    let (placements, joints): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    Point { placements, joints: joints.into_iter().flatten().collect(), of }
}

/// What the answer keeps, measured on it.
fn judged(
    standing: &StanceModel<'_>,
    request: &PostureRequest,
    conditions: &Conditions,
    (found, best, runs): (Point, usize, Vec<Run>),
    stopped: bool,
) -> DesignedPostures {
    // Always the same robots, so that answers of different seeds are judged alike.
    let tried = Tolerance { draws: TRIED, ..request.tolerance };
    let others = perturbed(&standing.parts.parameters, &tried, &mut Random::new(0x0077));
    let (mut least, mut stand, mut all) = (f64::INFINITY, 0_usize, 0_usize);
    let postures = found.joints.iter().zip(&found.of).map(|(q, &placement)| {
        let bodies = standing.bodies(q);
        let support = Polygon::hull(&standing.corners(&found.placements[placement]).concat());
        for parameters in &others {
            let (center, _) = standing.center(&bodies, parameters);
            let inside = support.inside([center.x, center.y]);
            (least, all, stand) = (least.min(inside), all + 1, stand + usize::from(inside > 0.0));
        }
        let (center, _) = standing.center(&bodies, &standing.parts.parameters);
        let center = [center.x, center.y];
        Planned { placement, joints: q.clone(), center, stability: support.inside(center) }
    });
    let postures: Vec<Planned> = postures.collect();
    let gap = |placement: &[f64; 3]| {
        let [own, other] = standing.corners(placement).map(|c| Polygon::hull(&c));
        own.apart(&other).map_or(f64::NEG_INFINITY, |gap| gap.distance)
    };
    debug_assert!(found.joints.iter().zip(&found.of).all(|(q, k)| conditions.kept(
        standing,
        q,
        &found.placements[*k]
    )));
    DesignedPostures {
        gap: found.placements.iter().map(gap).fold(f64::INFINITY, f64::min),
        placements: found.placements,
        postures,
        runs,
        best,
        stability_of_others: least,
        standing_others: stand as f64 / all.max(1) as f64,
        stopped,
    }
}
