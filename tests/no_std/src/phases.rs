//! A gait of a phase that ends at a φ: its controller, and its constraint surface by iteration.
use bipedc_runtime::Scalar;
use bipedc_runtime::control::{
    Controller, JointCommand, Observation, PhasedController, held_contacts, phase_surface, surface_memory,
};
use core::hint::black_box;
use phases::gait_grounded as gait;

/// T at φ, and T′.
fn at<R: Scalar>(
    arguments: &[R; gait::ARGUMENTS],
    held: &[R],
    near: &[R],
    phase: R,
) -> Option<[[R; gait::NQ]; 2]> {
    let mut arguments = *arguments;
    arguments[0] = phase;
    let mut memory = [R::constant(0.0); surface_memory(gait::NQ)];
    let point = phase_surface(&gait::GroundedGait, 0, (&arguments, held), near, &mut memory).ok()?;
    let mut found = [[R::constant(0.0); gait::NQ]; 2];
    for (found, of) in found.iter_mut().zip([point.q, point.slope]) {
        found.iter_mut().zip(of).for_each(|(found, of)| *found = *of);
    }
    Some(found)
}

/// How far T′ is from the slope of T a little before and behind; `None`: something refuses.
fn miss<R: Scalar>(step: f64) -> Option<R> {
    let q = black_box([0.0, 0.7, 0.1, -0.6, 0.2, 0.1, 0.3].map(R::constant));
    let v = black_box([0.7, 0.0, 0.0, 0.5, 0.1, -0.5, 0.2].map(R::constant));
    let mut controller = PhasedController::new(gait::GroundedGait);
    let seen = Observation::new(R::constant(0.0), 0, &q, &v);
    controller.begin_phase(&seen).ok()?;
    let mut commands = [JointCommand::Off; 4];
    controller.command(&seen, &mut commands).ok()?;
    let mut arguments = [R::constant(0.0); gait::ARGUMENTS];
    arguments.iter_mut().zip(controller.arguments()).for_each(|(own, known)| *own = *known);
    let mut held = [R::constant(0.0); gait::NQ];
    let count = held_contacts(&gait::GroundedGait, 0, (&q, &arguments), &mut held).ok()?;
    let held = held.get(..count)?;
    let (phase, step) = (arguments[0] + R::constant(0.02), R::constant(step));
    let [before, now, after] = [phase - step, phase, phase + step].map(|phase| at(&arguments, held, &q, phase));
    let ([before, _], [_, slope], [after, _]) = (before?, now?, after?);
    let mut worst = R::constant(0.0);
    for ((before, after), slope) in before.iter().zip(&after).zip(&slope) {
        worst = worst.larger(((*after - *before) / (step + step) - *slope).abs());
    }
    Some(worst)
}

/// Surfaces are found, and what is no phase, or too little room, is refused.
pub fn hold<R: Scalar + Into<f64>>(step: f64, tolerance: f64) -> bool {
    let nothing = [R::constant(0.0); gait::NQ];
    let arguments = [R::constant(0.0); gait::ARGUMENTS];
    let refused = |phase: usize, memory: &mut [R]| {
        phase_surface(&gait::GroundedGait, phase, (&arguments, &nothing), &nothing, memory).is_err()
    };
    refused(black_box(1), &mut [R::constant(0.0); surface_memory(gait::NQ)])
        & refused(0, &mut [R::constant(0.0); 3])
        & miss::<R>(black_box(step)).is_some_and(|miss| miss.into() <= tolerance)
}
