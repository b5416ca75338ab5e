//! The core never allocates.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use bipedc_runtime::Real;
use bipedc_runtime::lanes::{F32x16, F64x4, F64x8};
use bipedc_runtime::math::sin_cos;

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

fn exercise<R: Real>(scale: f64) {
    let angles: [R; 13] = std::array::from_fn(|i| R::constant(scale * i as f64));
    black_box(R::sin_cos_all(black_box(angles)));
    black_box(sin_cos(R::fused(angles[1], angles[2], angles[3].sqrt())));
}

#[test]
fn scalars_and_lanes_do_not_allocate() {
    drop(black_box(Box::new(1)));
    let before = ALLOCATIONS.get();
    assert!(before > 0, "the counter works");
    for scale in [0.1, 1e10, f64::NAN] {
        exercise::<f64>(scale);
        exercise::<f32>(scale);
        exercise::<F64x4>(scale);
        exercise::<F64x8>(scale);
        exercise::<F32x16>(scale);
    }
    assert_eq!(ALLOCATIONS.get(), before);
}
