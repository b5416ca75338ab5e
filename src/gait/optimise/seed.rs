//! Where a search begins that knows a gait: along its curves, at the speed that is wished.
use super::guess::{Guess, fit, height, weights};
use super::layout::Layout;
use bipedc_compiler::compile::{Collocation, NodeRow};
use bipedc_compiler::description::gait::{AnyGait, Curve, Feedforward, GaitOutput};
use bipedc_effects::diagnostic::Diagnostic;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// A phase of the gait that is begun from.
struct SeedPhase<'g> {
    curves: Vec<(&'g [f64], [f64; 2])>,
    over: [f64; 2],
    feedforward: Option<&'g Feedforward>,
}

/// Most steps of the search for a posture, and the rest that is none.
const STEPS: usize = 60;
const FOUND: f64 = 1e-8;
/// Nothing is as far off as this where a posture was nearly found, m or rad.
const NEAR: f64 = 1e-2;

/// `seed` is the gait's own form, derived; `of` that of the search, on the same phases.
///
/// # Errors
/// Other phases; outputs that are no Bezier polynomials; curves along which there are no postures.
pub(super) fn along_curves(
    (of, layout): (&Collocation, &Layout),
    (gait, seed): (&AnyGait, &Collocation),
    speed: f64,
) -> Result<Guess, Diagnostic> {
    let phases = read(gait)?;
    let names = |of: &Collocation| of.phases.iter().map(|phase| phase.name.clone()).collect::<Vec<_>>();
    if names(of) != names(seed) {
        let help = "begin from a gait of the same phases";
        return Err(Diagnostic::error("the gait to begin from has other phases than the form").help(help));
    }
    let mut x = vec![0.0; layout.variables];
    let mut q = beginning(seed, gait);
    let mut held: BTreeMap<usize, f64> =
        seed.phases[0].standing.first().map(|&point| (point, 0.0)).into_iter().collect();
    let (mut durations, mut rates) = (Vec::new(), Vec::new());
    for (p, own) in phases.iter().enumerate() {
        let phase = &layout.phases[p];
        let nodes = phase.nodes();
        let mut found: Vec<Vec<f64>> = Vec::with_capacity(nodes);
        for node in 0..nodes {
            let part = phase.part(node);
            let phi = own.over[0] + part * (own.over[1] - own.over[0]);
            posture(seed, p, (&mut q, phi), own, &held)?;
            found.push(q.clone());
        }
        let duration = ((found[nodes - 1][0] - found[0][0]) / speed).abs().max(0.02);
        x[phase.duration] = duration;
        [x[phase.ends()[0]], x[phase.ends()[1]]] = own.over;
        rates.push((own.over[1] - own.over[0]) / duration);
        motion(&mut x, (layout, p), &found, duration);
        weights(of, layout, &mut x, p);
        if let Some(known) = own.feedforward {
            torques(&mut x, (of, layout, p), known, own.over);
        }
        durations.push(duration);
        if seed.changes[p].relabel {
            q = seed.relabelling.iter().map(|&(row, sign)| sign * q[row]).collect();
        }
        // What stands next stays where it is now.
        let next = (p + 1) % phases.len();
        let places = rows(seed, next, &q, NodeRow::Place).0;
        held = seed.phases[next].standing.iter().map(|&point| (point, places[point])).collect();
    }
    for p in 0..phases.len() {
        let ends = layout.phases[p].ends();
        for (end, node) in ends.into_iter().zip([0, layout.phases[p].nodes() - 1]) {
            let first = layout.motion(p, node, 0);
            x[end] = rows(of, p, &x[first..first + layout.nv], NodeRow::Phase).0[0];
        }
        fit(of, layout, &mut x, p);
    }
    let whole: f64 = durations.iter().sum();
    let parts = durations.iter().map(|duration| duration / whole).collect();
    Ok(Guess { x, parts, rates, height: height(of) })
}

fn read(gait: &AnyGait) -> Result<Vec<SeedPhase<'_>>, Diagnostic> {
    match gait {
        AnyGait::OnePhase(gait) => Ok(vec![seed_phase(&gait.phase.outputs, None)?]),
        AnyGait::Phased(gait) => {
            gait.phases.iter().map(|phase| seed_phase(&phase.outputs, phase.feedforward.as_ref())).collect()
        }
    }
}

fn seed_phase<'g>(
    outputs: &'g [GaitOutput],
    feedforward: Option<&'g Feedforward>,
) -> Result<SeedPhase<'g>, Diagnostic> {
    let curve = |output: &'g GaitOutput| match &output.wanted {
        Curve::Bezier { coefficients, over, along: None, plus: None } => Ok((&coefficients[..], *over)),
        Curve::Formula(_) | Curve::Bezier { .. } => {
            let message = format!("output `{}` of the gait to begin from is a formula", output.name);
            Err(Diagnostic::error(message)
                .help("begin from a gait whose outputs have `wanted.bezier` without `along` and `plus`"))
        }
    };
    let curves = outputs.iter().map(curve).collect::<Result<Vec<_>, _>>()?;
    let over = curves.first().map_or([0.0, 1.0], |curve| curve.1);
    Ok(SeedPhase { curves, over, feedforward })
}

fn bezier((coefficients, [first, last]): (&[f64], [f64; 2]), phi: f64) -> f64 {
    let s = (phi - first) / (last - first);
    let mut points = coefficients.to_vec();
    while points.len() > 1 {
        points = points.windows(2).map(|pair| pair[0] + s * (pair[1] - pair[0])).collect();
    }
    points.first().copied().unwrap_or(0.0)
}

/// Joints where the gait says that searches begin.
fn beginning(seed: &Collocation, gait: &AnyGait) -> Vec<f64> {
    let known = match gait {
        AnyGait::OnePhase(gait) => &gait.phase.posture,
        AnyGait::Phased(gait) => &gait.phases[0].posture,
    };
    let mut q = vec![0.0; seed.tree.nq];
    for joint in &seed.tree.joints {
        q[joint.v_index] = known.get(&joint.name).copied().unwrap_or(0.0);
    }
    q[1] = height(seed);
    q
}

/// Rows of a kind at a posture, with their slopes by q.
fn rows(of: &Collocation, p: usize, q: &[f64], kind: NodeRow) -> (DVector<f64>, DMatrix<f64>) {
    let phase = &of.phases[p];
    let mut x = vec![0.0; phase.node.variables()];
    x[..q.len()].copy_from_slice(q);
    x[3 * of.tree.nv + 1] = 1.0;
    let mut values = vec![0.0; phase.node.rows()];
    phase.node.values(&x, &mut values);
    let mut slopes = vec![0.0; phase.node.jacobian_structure().len()];
    phase.node.jacobian(&x, &mut slopes);
    let place = phase.rows.iter().find(|row| row.0 == kind);
    let (first, count) = place.map_or((0, 0), |&(_, first, count)| (first, count));
    let mut jacobian = DMatrix::zeros(count, q.len());
    for (&[row, variable], slope) in phase.node.jacobian_structure().iter().zip(slopes) {
        if (first..first + count).contains(&row) && variable < q.len() {
            jacobian[(row - first, variable)] += slope;
        }
    }
    (DVector::from_column_slice(&values[first..first + count]), jacobian)
}

/// The posture on the curves at φ, by Newton's method from one near by.
fn posture(
    seed: &Collocation,
    p: usize,
    (q, phi): (&mut Vec<f64>, f64),
    own: &SeedPhase<'_>,
    held: &BTreeMap<usize, f64>,
) -> Result<(), Diagnostic> {
    let mut off = f64::INFINITY;
    for _ in 0..STEPS {
        let mut asked: Vec<(f64, Vec<f64>)> = Vec::new();
        let mut ask = |of: &(DVector<f64>, DMatrix<f64>), row: usize, wanted: f64| {
            asked.push((wanted - of.0[row], of.1.row(row).iter().copied().collect()));
        };
        let [outputs, variable, heights, places] =
            [NodeRow::Output, NodeRow::Phase, NodeRow::Height, NodeRow::Place]
                .map(|kind| rows(seed, p, q, kind));
        own.curves.iter().enumerate().for_each(|(k, &curve)| ask(&outputs, k, bezier(curve, phi)));
        ask(&variable, 0, phi);
        seed.phases[p].standing.iter().for_each(|&point| ask(&heights, point, 0.0));
        held.iter().for_each(|(&point, &place)| ask(&places, point, place));
        let matrix = DMatrix::from_fn(asked.len(), q.len(), |i, j| asked[i].1[j]);
        let wrong = DVector::from_iterator(asked.len(), asked.iter().map(|row| row.0));
        off = wrong.amax();
        let normal = matrix.transpose() * &matrix + DMatrix::identity(q.len(), q.len()) * 1e-9;
        let Some(step) = normal.lu().solve(&(matrix.transpose() * wrong)) else { break };
        let length = step.amax();
        let part = if length > 0.3 { 0.3 / length } else { 1.0 };
        q.iter_mut().zip(step.iter()).for_each(|(q, d)| *q += part * d);
        if length < FOUND {
            break;
        }
    }
    if off < NEAR {
        return Ok(());
    }
    let message = format!(
        "no posture lies on the curves of the gait to begin from: phase `{}`, φ = {phi:.4}",
        seed.phases[p].name
    );
    Err(Diagnostic::error(message).help("begin from nothing, or from a gait of this robot"))
}

/// Positions, and velocities and accelerations by their differences.
fn motion(x: &mut [f64], (layout, p): (&Layout, usize), found: &[Vec<f64>], duration: f64) {
    let last = found.len() - 1;
    let at = |node: usize| duration * layout.phases[p].part(node);
    for k in 0..layout.nv {
        let q = |node: usize| found[node][k];
        let slope = |from: usize, to: usize| (q(to) - q(from)) / (at(to) - at(from));
        for node in 0..=last {
            let (before, after) = (node.saturating_sub(1), (node + 1).min(last));
            x[layout.motion(p, node, 0) + k] = q(node);
            x[layout.motion(p, node, 1) + k] = slope(before, after);
            let middle = node.clamp(1, last.max(2) - 1);
            let rise = slope(middle, middle + 1) - slope(middle - 1, middle);
            x[layout.motion(p, node, 2) + k] = 2.0 * rise / (at(middle + 1) - at(middle - 1));
        }
    }
}

/// Feed-forward torques, straight between the places where they are given.
fn torques(
    x: &mut [f64],
    (of, layout, p): (&Collocation, &Layout, usize),
    known: &Feedforward,
    over: [f64; 2],
) {
    let last = layout.phases[p].nodes() - 1;
    for (k, joint) in of.tree.joints.iter().enumerate() {
        let Some(values) = known.torques.get(&joint.name) else { continue };
        for node in 0..=last {
            let phi = over[0] + (over[1] - over[0]) * layout.phases[p].part(node);
            let after = known.at.partition_point(|&at| at < phi).clamp(1, known.at.len() - 1);
            let part =
                ((phi - known.at[after - 1]) / (known.at[after] - known.at[after - 1])).clamp(0.0, 1.0);
            x[layout.torques(p, node) + k] = values[after - 1] + part * (values[after] - values[after - 1]);
        }
    }
}
