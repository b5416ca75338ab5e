//! TUlip's controller as it is committed: time of a call over a million calls, by the clock on the wall and by the processor's time of this thread.
//!
//! `cargo bench --bench on_board [CALLS]`. Calls are those of a simulated walk with a push, answered again by new controllers, so that all of its phases
//! and the search for another step are among them.
#[path = "harness/processor.rs"]
mod processor;

use processor::processor;
use std::env;
use std::hint::black_box;
use tulip_controller::walking::{Controller, STATE};

#[path = "../tests/on_board/recorded.rs"]
#[allow(dead_code)]
mod recorded;

/// A push that is stepped out.
const PUSH: &str = "[[push]]\ntime = 4.1\nimpulse = 4.0\ndirection = 1.57\n";

/// Nanoseconds of a clock of the system.
#[cfg(unix)]
fn nanoseconds(clock: i32) -> u64 {
    #[repr(C)]
    struct Timespec {
        seconds: i64,
        nanoseconds: i64,
    }
    unsafe extern "C" {
        fn clock_gettime(clock: i32, into: *mut Timespec) -> i32;
    }
    let mut now = Timespec { seconds: 0, nanoseconds: 0 };
    // The pointer is to a value of the form that the system writes on 64 bits.
    unsafe { clock_gettime(clock, &raw mut now) };
    (now.seconds * 1_000_000_000 + now.nanoseconds) as u64
}

/// Monotonic, and of the thread, as Linux counts them.
const CLOCKS: [(&str, i32); 2] = [("clock on the wall", 1), ("processor's time of the thread", 3)];

fn main() {
    let count = env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(1_000_000);
    let calls = recorded::walk("bench", 16.0, PUSH);
    println!("state {STATE} bytes; {count} calls each; {}", processor());
    println!("{:>32} {:>9} {:>9} {:>9} {:>9} {:>9}  µs", "", "median", "99 %", "99.9 %", "99.99 %", "worst");
    for learns in [false, true] {
        for (name, clock) in CLOCKS {
            let mut taken = Vec::with_capacity(count);
            while taken.len() < count {
                let mut controller = Controller::default();
                controller.learn_payload(learns);
                for call in calls.iter().take(count - taken.len()) {
                    let start = nanoseconds(clock);
                    black_box(controller.step(black_box(&call.sensors), call.wanted));
                    taken.push(nanoseconds(clock) - start);
                }
            }
            taken.sort_unstable();
            let at = |part: f64| taken[((taken.len() - 1) as f64 * part) as usize] as f64 * 1e-3;
            let row = [0.5, 0.99, 0.999, 0.9999, 1.0].map(|part| format!("{:9.1}", at(part)));
            let name = if learns { format!("{name}, learning") } else { name.to_owned() };
            println!("{name:>32} {}", row.join(" "));
        }
    }
}
