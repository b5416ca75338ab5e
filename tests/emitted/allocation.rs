//! Emitted code never allocates.
use super::models::{FiveLinkWithEffects, ThreeLink, Tulip};
use super::states::{Arguments, Random, functions};
use bipedc_runtime::{Model, Real};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

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

/// Of this thread, so far.
pub fn allocations() -> usize {
    ALLOCATIONS.get()
}

fn exercise<R: Real>(model: &impl Model<R>) {
    let arguments = Arguments::<R>::random(model, &mut Random(3));
    let mut outputs: Vec<Vec<R>> =
        functions(model).iter().map(|(_, length)| vec![R::constant(0.0); *length]).collect();
    let before = ALLOCATIONS.get();
    for (k, output) in outputs.iter_mut().enumerate() {
        black_box(model).evaluate(k, &arguments.state(), output).unwrap();
        black_box(output);
    }
    assert_eq!(ALLOCATIONS.get(), before);
    // A refused call does not allocate its error either.
    assert!(model.evaluate(0, &arguments.state(), &mut []).is_err());
    assert_eq!(ALLOCATIONS.get(), before);
}

#[test]
fn emitted_functions_do_not_allocate() {
    drop(black_box(Box::new(1)));
    assert!(ALLOCATIONS.get() > 0, "the counter works");
    exercise::<f64>(&ThreeLink);
    exercise::<f32>(&ThreeLink);
    exercise::<f64>(&Tulip);
    exercise::<f64>(&FiveLinkWithEffects);
}
