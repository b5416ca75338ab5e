//! Forward dynamics while directions of one point of one body are held: the force of each is found from how the free robot answers it.
use super::Sensitivity;
use super::articulated::Freeing;
use super::subtree::Wrench;
use crate::derive::constrained::{dot, solve_symmetric};
use crate::expression::Sym;

/// Directions of a body's point that are held.
pub(in crate::derive) struct Held<'g> {
    pub body: usize,
    /// A unit force along each, about the body's origin in its joint axes.
    pub units: Vec<Wrench<'g>>,
    /// w: acceleration along each without accelerations of `v` (m/s², rad/s²); of an impact the velocity before it (m/s, rad/s).
    pub rates: Vec<Sym<'g>>,
}

/// How the free robot answers a unit force: the elements of L⁻ᵀ Jᵀ that can differ from zero, with their rows of `v` and 1 / Δ.
struct Answer<'g> {
    rows: Vec<usize>,
    half: Vec<Sym<'g>>,
    inverse: Vec<Sym<'g>>,
}

/// Accelerations under generalised forces, both in the order of `v`, and the held directions' forces: λ = −Y (J D⁻¹ f + w),
/// Y = (J D⁻¹ Jᵀ)⁻¹ (4.23a), D by articulated bodies. Force goes from the body to the root alone, other branches are seen once.
pub(in crate::derive) fn solve_pinned<'g>(
    robot: &Sensitivity<'_, 'g, '_>,
    forces: &[Sym<'g>],
    held: &Held<'g>,
) -> (Vec<Sym<'g>>, Vec<Sym<'g>>) {
    let mut freed = Freeing::new(robot, forces, 0);
    let answers: Vec<Answer<'g>> =
        held.units.iter().map(|&unit| Answer::new(robot, &freed, held.body, unit)).collect();
    let scaled: Vec<Vec<Sym<'g>>> = answers.iter().map(Answer::scaled).collect();
    let n = answers.len();
    let gram = (0..n).map(|r| (0..=r).map(|c| dot(&answers[r].half, &scaled[c])).collect()).collect();
    let lacking = |(answer, (scaled, &rate)): (&Answer<'g>, (&Vec<Sym<'g>>, &Sym<'g>))| {
        let rests: Vec<Sym<'g>> = answer.rows.iter().map(|row| freed.rests[*row]).collect();
        -(dot(scaled, &rests) + rate)
    };
    let residual = answers.iter().zip(scaled.iter().zip(&held.rates)).map(lacking).collect();
    let reactions = solve_symmetric(gram, residual);
    for (answer, &force) in answers.iter().zip(&reactions) {
        for (&row, &half) in answer.rows.iter().zip(&answer.half) {
            freed.rests[row] = freed.rests[row] + half * force;
        }
    }
    (freed.accelerate(robot), reactions)
}

impl<'g> Answer<'g> {
    fn new(robot: &Sensitivity<'_, 'g, '_>, freed: &Freeing<'g>, body: usize, unit: Wrench<'g>) -> Self {
        let model = robot.model;
        let mut out = Self { rows: Vec::new(), half: Vec::new(), inverse: Vec::new() };
        // Needed is the opposite of what acts.
        let (mut at, mut wrench) = (body, (-unit.0, -unit.1));
        loop {
            let projections = robot.projections(at, wrench);
            out.rows.extend(projections.iter().map(|(row, _)| *row));
            if let Some(pivot) = &freed.pivots[at] {
                let rest =
                    projections.iter().fold(model.constant(0.0), |sum, (_, x)| sum - model.signed(at, *x));
                out.half.push(rest);
                out.inverse.push(pivot.inverse);
                wrench = pivot.pass(rest, wrench);
            } else if let Some(root) = &freed.root {
                let mut rests: Vec<Sym<'g>> = projections.iter().map(|(_, x)| -*x).collect();
                root.half_solve(&mut rests);
                out.half.extend(rests);
                out.inverse.extend(root.inverse);
            }
            let Some(parent) = model.tree.bodies[at].parent else { return out };
            wrench = robot.lift(at, parent, wrench);
            at = parent;
        }
    }

    fn scaled(&self) -> Vec<Sym<'g>> {
        self.half.iter().zip(&self.inverse).map(|(&x, &inverse)| x * inverse).collect()
    }
}
