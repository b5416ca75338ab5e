//! A step allocates nothing.
use super::Numbers;
use super::bodies::Pendulum;
use super::solver::random;
use bipedc_analysis::simulate::{Cone, DriveServo, JointLaw, MotionState, MotorLaw, Solver, Tolerance};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: forwards to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // Not counted while the thread ends.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of this thread so far.
pub fn count() -> usize {
    ALLOCATIONS.get()
}

#[test]
fn steps_do_not_allocate() {
    drop(std::hint::black_box(Box::new(1)));
    assert!(count() > 0, "the counter works");
    let pendulum = Pendulum { inertia: 0.2, weight: 5.0 };
    let law = JointLaw {
        dry: [0.1, 0.1],
        limits: Some([-0.2, 0.3]),
        damping: 0.01,
        rotor_inertia: 0.01,
        slope: 0.0,
    };
    let mut stepper = pendulum.stepper(law);
    let mut motion = MotionState { time: 0.0, q: vec![0.1], v: vec![0.0] };
    let before = count();
    for k in 0..2000 {
        let torque = if k % 500 < 250 { 9.0 } else { -9.0 };
        stepper.step(&mut motion, &[torque], 1e-3).unwrap();
    }
    assert_eq!(count(), before);
    // With a motor behind play and a servo inside its drive.
    let motor = MotorLaw {
        joint: 0,
        inertia: 0.01,
        damping: 0.01,
        dry: [0.1; 2],
        stiffness: 500.0,
        spring_damping: 0.1,
        gap: 0.02,
    };
    let mut stepper = pendulum.stepper(law).with_motors(vec![motor], &motion).unwrap();
    let before = count();
    for k in 0..2000 {
        let wanted = [if k % 500 < 250 { 0.2 } else { -0.1 }, 0.0];
        let (stiffness, damping, limits) = (200.0, 4.0, [-9.0, 9.0]);
        stepper.set_servos(std::iter::once(DriveServo {
            axis: 1,
            stiffness,
            damping,
            wanted,
            bias: 0.0,
            limits,
        }));
        stepper.step(&mut motion, &[0.0, 0.0], 1e-3).unwrap();
    }
    assert_eq!(count(), before);
}

#[test]
fn contact_problems_do_not_allocate() {
    let mut numbers = Numbers(11);
    let (mut solver, mut hardest) = (Solver::with_room(8 * 3 + 4), 0);
    for case in 0..60 {
        let mut problem = random(&mut numbers, 1 + case % 8, 2, Cone::Round);
        let before = count();
        // Little is tolerated, so that everything the solver has is tried.
        let solved = solver.solve(&mut problem, &Tolerance { relative: 1e-12, ..Tolerance::default() });
        assert_eq!(count(), before, "case {case}: {solved:?}");
        hardest = hardest.max(solved.sweeps + solved.newton);
    }
    // After two rounds of sweeps and Newton steps, steps are taken whatever they bring.
    assert!(hardest > 1 + 12 + 2 + 12, "{hardest}");
}
