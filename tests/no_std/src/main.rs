//! Calls the runtime's core and generated code in a program without the standard library.
//!
//! `check.sh` builds it and searches it for what must not be there: panics, allocation, mathematical
//! libraries. Run, it ends with 0 when the numbers are right.
#![no_std]
#![no_main]

mod filter;
mod generated;
mod on_board;
mod phases;
mod standing;
mod walking;

use core::hint::black_box;

use bipedc_runtime::Real;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal, Servo};
use bipedc_runtime::lanes::{F32x8, F64x4, F64x8};
use bipedc_runtime::math::sin_cos;

// The C start-up code calls `main`.
#[link(name = "c")]
unsafe extern "C" {}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// The `core` that comes with the compiler was built for unwinding and names this; nothing calls it.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// Every operation of [`Real`], on angles of the common range and beyond; the sum of sin² + cos², so `N`.
fn squares<R: Real, const N: usize>(angles: [R; N]) -> R {
    let (sines, cosines) = R::sin_cos_all(black_box(angles));
    let mut sum = R::constant(0.0);
    for (s, c) in sines.into_iter().zip(cosines) {
        sum = R::fused(s, s, R::fused(-c, -c, sum));
    }
    let (s, c) = sin_cos(black_box(angles)[0]);
    sum + (s * s + c * c).sqrt() - R::constant(1.0)
}

/// exp and tanh from tiny to beyond their range: e · e⁻¹, tanh² + 1 / cosh², limits; 5 in all.
fn exponentials<R: Real>(x: R) -> R {
    let x = black_box(x);
    let (grown, shrunk, one) = (x.exp(), (-x).exp(), R::constant(1.0));
    let t = x.tanh();
    let cosh = (grown + shrunk) / R::constant(2.0);
    let limits = (x * R::constant(-1e4)).exp() + (x * R::constant(1e4)).tanh();
    grown * shrunk + t * t + one / (cosh * cosh) + limits + (-x).abs().sign() + (-x).larger(one)
}

/// A controller behind a pointer: a servo and a torque for two joints behind a planar base; what they ask for together, 5.
fn controlled<R: Real>() -> R {
    let x = R::constant;
    let mut controller = |seen: &Observation<'_, R>, commands: &mut [JointCommand<R>]| {
        let (q, v) = seen.joints(commands.len());
        for (k, command) in commands.iter_mut().enumerate() {
            let (Some(q), Some(v)) = (q.get(k), v.get(k)) else { return Err(Refusal::SingularOutputs) };
            let (position, velocity, limit) = (*q + x(0.5), *v, x(2.0));
            let servo =
                Servo { position, velocity, stiffness: x(8.0), damping: x(1.0), torque: x(0.0), limit };
            *command = if k == 0 { JointCommand::Servo(servo) } else { JointCommand::Torque(x(3.0)) };
        }
        Ok(())
    };
    let controller: &mut dyn Controller<R> = black_box(&mut controller);
    let (q, v) = (black_box([x(0.25); 5]), black_box([x(0.0); 5]));
    let mut commands = [JointCommand::Off; 2];
    let given = controller.command(&Observation::new(x(0.0), 0, &q, &v), &mut commands);
    let asked = commands[0].torque(q[3], v[3]) + commands[1].torque(q[4], v[4]);
    if given.is_ok() { asked } else { x(0.0) }
}

fn good(value: f64, expected: f64, tolerance: f64) -> bool {
    let difference = value - expected;
    difference <= tolerance && -difference <= tolerance
}

/// Status 0 when all is right. Without an argument the controller walks with everything of the system forbidden; with one the
/// system is asked for something then: that has to end the program.
#[unsafe(no_mangle)]
pub extern "C" fn main(arguments: i32) -> i32 {
    let right = calls() & on_board::walks(4000);
    #[cfg(all(target_os = "linux", target_arch = "x86_64"))]
    {
        let closed = filter::close();
        if arguments > 1 {
            filter::ask();
        }
        let walked = on_board::walks(100_000);
        filter::end(i32::from(!(right & closed & walked)));
    }
    #[allow(unreachable_code)]
    i32::from(!right || arguments == 0)
}

fn calls() -> bool {
    let single = squares::<f64, 3>([0.5, 1e300, -700.0]);
    let twelve = squares::<f64, 13>([0.25; 13]);
    let short = squares::<f32, 5>([0.5, 1e30, -700.0, 2.0, 3.0]);
    let four = squares([F64x4::from_array([0.1, 0.2, 1e100, 3.0]); 2]).to_array();
    let eight = squares([F64x8::constant(1.5); 2]).to_array();
    let floats = squares([F32x8::constant(1.5); 2]).to_array();
    let right = good(single, 3.0, 1e-14)
        & good(twelve, 13.0, 1e-14)
        & good(f64::from(short), 5.0, 1e-5)
        & four.iter().chain(&eight).all(|sum| good(*sum, 2.0, 1e-14))
        & floats.iter().all(|sum| good(f64::from(*sum), 2.0, 1e-6))
        & good(exponentials(0.7), 5.0, 1e-14)
        & good(f64::from(exponentials(0.7f32)), 5.0, 1e-5)
        & exponentials(F64x4::constant(2.5)).to_array().iter().all(|sum| good(*sum, 5.0, 1e-14))
        & exponentials(F32x8::constant(2.5)).to_array().iter().all(|sum| good(f64::from(*sum), 5.0, 1e-5))
        & good(controlled::<f64>(), 5.0, 1e-14)
        & good(f64::from(controlled::<f32>()), 5.0, 1e-5)
        & good(generated::round_trip::<f64>(), 0.0, 1e-12)
        & good(f64::from(generated::round_trip::<f32>()), 0.0, 1e-3)
        & generated::every_function()
        & walking::walks::<f64>(1e-10)
        & walking::walks::<f32>(2e-2)
        & phases::hold::<f64>(1e-4, 1e-6)
        & phases::hold::<f32>(1e-2, 1e-1)
        & standing::shares::<f64>(1e-9)
        & standing::shares::<f32>(1e-2)
        & standing::stands::<f64>(1e-3)
        & standing::stands::<f32>(1e-2)
        & standing::weighs::<f64>(1e-2)
        & standing::weighs::<f32>(0.05);
    right
}
