//! A gait's controller: on the constraint surface its torques make the robot move as the zero dynamics say.
use bipedc_runtime::Scalar;
use bipedc_runtime::control::{
    Controller, Feedback, Gait, GaitController, GaitLayout, JointCommand, Observation,
};
use bipedc_runtime::nalgebra::SVector;
use core::hint::black_box;

use walker::gait_thesis as gait;

/// Arguments of a step on the surface without h_p, from its beginning; φ is any.
fn arguments<R: Scalar>(
    controller: &mut GaitController<R, gait::ThesisGait>,
) -> Option<[R; gait::ARGUMENTS]> {
    let mut arguments = [R::constant(0.0); gait::ARGUMENTS];
    let start = black_box(R::constant(-0.25));
    for (index, argument) in arguments.iter_mut().skip(GaitLayout::PARAMETERS).enumerate() {
        let parameter = Gait::<R>::parameter(controller.gait(), index);
        *argument = R::constant(parameter.map_or(0.0, |parameter| parameter.default));
    }
    arguments[GaitLayout::START] = start;
    arguments[GaitLayout::END] = controller.step_end(start)?;
    Some(arguments)
}

/// How far the accelerations under the controller are from those of the zero dynamics; `None`: it refuses.
fn miss<R: Scalar>(feedback: Feedback<R>) -> Option<R> {
    let mut controller = GaitController::new(gait::ThesisGait, feedback).unlimited();
    let mut known = arguments(&mut controller)?;
    let rate = black_box(R::constant(1.5));
    let mut worst = R::constant(0.0);
    for phase in [-0.25, 0.0, 0.2] {
        known[0] = black_box(R::constant(phase));
        let surface = gait::surface(&SVector::from(known));
        let column = |k: usize| SVector::<R, { gait::NQ }>::from(surface.data.0[k]);
        let (q, slope, curvature) = (column(0), column(1), column(2));
        let mut v = [R::constant(0.0); gait::NV];
        v.iter_mut().zip(slope.iter()).for_each(|(v, slope)| *v = *slope * rate);
        if phase == -0.25 {
            controller.begin_step(q.as_slice(), &v).ok()?;
        }
        let mut commands = [JointCommand::Off; 2];
        controller.command(&Observation::new(rate, 0, q.as_slice(), &v), &mut commands).ok()?;
        let mut tau = SVector::<R, { gait::NV }>::from([R::constant(0.0); gait::NV]);
        for (tau, command) in tau.iter_mut().skip(3).zip(&commands) {
            *tau = command.torque(rate, rate);
        }
        let v = SVector::from(v);
        let found = gait::constrained_dynamics_of_single_support(&q, &v, &tau);
        let zero = gait::zero_dynamics(&q, &slope, &curvature);
        let [alpha, beta, gamma] = zero.data.0[0];
        let turn = -(beta * rate * rate + gamma) / alpha;
        for ((found, slope), curvature) in found.iter().zip(slope.iter()).zip(curvature.iter()) {
            worst = worst.larger((*found - (*curvature * rate * rate + *slope * turn)).abs());
        }
    }
    Some(worst)
}

/// The end of a step by iteration is that by the closed form.
fn iterates<R: Scalar + Into<f64>>(tolerance: f64) -> bool {
    let start = black_box(R::constant(-0.25));
    let closed = GaitController::<R, _>::new(gait::ThesisGait, Feedback::default()).step_end(start);
    let found = GaitController::<R, _>::new(bent::gait_bent::BentGait, Feedback::default()).step_end(start);
    closed.zip(found).is_some_and(|(a, b)| (a - b).abs().into() <= tolerance)
}

/// Both feedbacks; ends of steps by iteration; also what cannot be is refused: a step backwards, a state of another length, a step without end.
pub fn walks<R: Scalar + Into<f64>>(tolerance: f64) -> bool {
    let finite = Feedback::FiniteTime { exponent: R::constant(0.9), time_scale: R::constant(0.1) };
    let mut controller = GaitController::new(gait::ThesisGait, black_box(finite));
    let zeros = black_box([R::constant(0.0); gait::NQ]);
    let refused = controller.begin_step(&zeros, &zeros).is_err()
        & controller.begin_step(&zeros, &[]).is_err()
        & controller.ask(0, R::constant(9.0)).is_ok()
        & controller.step_end(R::constant(-0.25)).is_none();
    let near = |miss: Option<R>| miss.is_some_and(|miss| miss.into() <= tolerance);
    refused
        & iterates::<R>(tolerance)
        & near(miss(black_box(Feedback::default())))
        & near(miss(black_box(finite)))
}
