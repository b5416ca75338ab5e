//! Generated code for a robot with a floating base: called by name through the trait, and directly.
use bipedc_runtime::nalgebra::SVector;
use bipedc_runtime::{Argument, Model, Real, State};
use core::hint::black_box;
use effects::FiveLink;
use floating::{NQ, NV, ThreeLink};

/// Longer than any argument or result of this robot.
const ROOM: usize = 1024;

/// Configuration of unit quaternion, and velocity.
fn state<R: Real>() -> (SVector<R, NQ>, SVector<R, NV>) {
    let mut q = [R::constant(0.25); NQ];
    let unit = [0.5, -0.5, 0.5, 0.5];
    for (element, value) in q[3..].iter_mut().zip(unit) {
        *element = R::constant(value);
    }
    (SVector::from(black_box(q)), SVector::from(black_box([R::constant(-0.5); NV])))
}

/// The largest difference between an acceleration and the forward dynamics of its inverse dynamics.
pub fn round_trip<R: Real + PartialOrd>() -> R {
    let (q, v) = state::<R>();
    let tau = floating::inverse_dynamics(&q, &v, &v);
    let mut a = v;
    floating::forward_dynamics_into(&q, &v, &tau, black_box(&mut a));
    let mut largest = R::constant(0.0);
    for (&x, &y) in a.iter().zip(v.iter()) {
        let difference = if x > y { x - y } else { y - x };
        largest = if difference > largest { difference } else { largest };
    }
    largest
}

/// Calls all functions of both robots, one with friction, springs and formulas, which no rigid body needs; whether none was refused.
pub fn every_function() -> bool {
    every_function_of(&ThreeLink, 10) & every_function_of(&FiveLink, 10)
}

/// Calls all functions by their index; whether none was refused and there were more than so many.
fn every_function_of(model: &impl Model<f64>, count: usize) -> bool {
    let numbers = black_box([0.5f64; ROOM]);
    let mut output = [0.0; ROOM];
    let mut state = State::new();
    for argument in Argument::ALL {
        let length = model.argument_length(argument);
        state = state.with(argument, numbers.get(..length).unwrap_or(&[]));
    }
    let (mut index, mut right) = (0, true);
    while let Some(signature) = model.signature(index) {
        let place = output.get_mut(..signature.rows * signature.columns).unwrap_or(&mut []);
        right &= model.evaluate(index, &state, place).is_ok();
        black_box(&mut output);
        index += 1;
    }
    right & (index > count)
}
