//! The constraint surface of a phase (6.30): where the robot is at φ, T with T′ and T″, by Newton's method with bounded work.
use super::Refusal;
use super::elimination::solve;
use super::phased::{PhaseLayout, PhasedGait};
use super::slices::copy;
use super::surface::{Constraints, Iteration};
use crate::model::{Argument, State};
use crate::real::Scalar;

/// Places of the functions that tell a phase's surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhaseSurfaceLayout {
    /// How many coordinates of contact points the ground holds: the first rows of `surface_equations`.
    pub held: usize,
    /// Function `surface_equations`.
    pub equations: usize,
    /// Function `surface_slopes`.
    pub slopes: usize,
    /// Function `surface_rates`.
    pub rates: usize,
    /// Function `surface_curvatures`.
    pub curvatures: usize,
}

/// A point of a phase's constraint surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint<'m, R> {
    /// T, as q.
    pub q: &'m [R],
    /// T′, per unit of φ: at φ̇ the velocity is T′ φ̇.
    pub slope: &'m [R],
    /// T″: the acceleration is T″ φ̇² + T′ φ̈.
    pub curvature: &'m [R],
}

/// Numbers that [`phase_surface`] needs, of a robot with so many elements of q.
pub const fn surface_memory(nq: usize) -> usize {
    nq * (6 + nq)
}

fn layout<R: Scalar>(gait: &impl PhasedGait<R>, index: usize) -> Result<PhaseLayout, Refusal> {
    gait.phase(index).ok_or(Refusal::Because("the gait does not have this phase"))
}

/// Where the ground holds the feet of a phase (by its index in the gait) at q: into the first of `nq` numbers, m; how many they are.
///
/// # Errors
/// No such phase, wrong lengths.
pub fn held_contacts<R: Scalar>(
    gait: &impl PhasedGait<R>,
    index: usize,
    (q, arguments): (&[R], &[R]),
    held: &mut [R],
) -> Result<usize, Refusal> {
    let of = layout(gait, index)?.surface;
    let state = State::new().with(Argument::Q, q).with(Argument::Parameters, arguments);
    gait.evaluate(of.equations, &state, held)?;
    Ok(of.held)
}

/// T, T′ and T″ at φ, the first of the gait's `arguments`, in a phase (by its index in the gait): feet stay where [`held_contacts`] says that
/// they are held, the outputs vanish. Behind φ₋ a controller's h_p stays zero, so are its value and slope in `arguments` to be. Looked for from the posture `near`; `memory` has [`surface_memory`] numbers.
///
/// # Errors
/// There is no such posture nearby, or outputs and contacts do not fix it; no such phase, wrong lengths.
pub fn phase_surface<'m, R: Scalar>(
    gait: &impl PhasedGait<R>,
    index: usize,
    (arguments, held): (&[R], &[R]),
    near: &[R],
    memory: &'m mut [R],
) -> Result<SurfacePoint<'m, R>, Refusal> {
    let of = layout(gait, index)?.surface;
    let n = gait.nq();
    let mut rest = memory;
    let mut cut = |count: usize| -> Result<&'m mut [R], Refusal> {
        let (own, left) =
            core::mem::take(&mut rest).split_at_mut_checked(count).ok_or(Refusal::WrongLength)?;
        rest = left;
        Ok(own)
    };
    let (q, slope, curvature) = (cut(n)?, cut(n)?, cut(n)?);
    let (origin, step, residual, jacobian) = (cut(n)?, cut(n)?, cut(n)?, cut(n * n)?);
    if near.len() != n || held.len() < of.held {
        return Err(Refusal::WrongLength);
    }
    copy(near, q);
    let held = held.get(..of.held).unwrap_or(&[]);
    let functions = Constraints { residual: of.equations, jacobian: of.slopes, held };
    let mut iteration = Iteration { q, origin, step, residual, jacobian };
    if !iteration.run(gait, functions, arguments) {
        return Err(Refusal::Because("no posture nearby has this phase, its contacts and its outputs"));
    }
    let Iteration { q, jacobian, .. } = iteration;
    let at = || State::new().with(Argument::Q, &*q).with(Argument::Parameters, arguments);
    gait.evaluate(of.rates, &at(), slope)?;
    solved(gait, (of.slopes, &at()), jacobian, slope)?;
    gait.evaluate(of.curvatures, &at().with(Argument::V, slope), curvature)?;
    solved(gait, (of.slopes, &at()), jacobian, curvature)?;
    Ok(SurfacePoint { q, slope, curvature })
}

/// `J x = −right` into `right`.
fn solved<R: Scalar>(
    gait: &impl PhasedGait<R>,
    (slopes, state): (usize, &State<'_, R>),
    jacobian: &mut [R],
    right: &mut [R],
) -> Result<(), Refusal> {
    gait.evaluate(slopes, state, jacobian)?;
    right.iter_mut().for_each(|x| *x = -*x);
    if solve(jacobian, right) { Ok(()) } else { Err(Refusal::SingularOutputs) }
}
