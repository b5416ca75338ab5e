//! Ctrl-C: what is done so far is kept, and no temporary file stays behind.
use bipedc_effects::files::remove_temporaries;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Set by the first signal, once somebody asked for it.
static ASKED: OnceLock<Arc<AtomicBool>> = OnceLock::new();
/// When the first signal came.
static FIRST: OnceLock<Instant> = OnceLock::new();
/// A second signal within this time is the same request: `timeout` sends its signal to the program and to its group, and both arrive.
const SAME: Duration = Duration::from_secs(1);
/// Exit code after a second signal.
const AT_ONCE: i32 = 130;

/// Whether Ctrl-C (or SIGTERM) asked for an end; a second time, a second or more later, the program ends at once, with code 130. Nobody listens before
/// the first question: until then there is nothing to be kept.
pub fn asked() -> impl Fn() -> bool + Send + Sync {
    let asked = OnceLock::new();
    move || asked.get_or_init(flag).load(Ordering::Relaxed)
}

fn flag() -> Arc<AtomicBool> {
    let flag = ASKED.get_or_init(Arc::default);
    #[cfg(not(unix))]
    listen(flag);
    Arc::clone(flag)
}

/// From here on signals that end the program clear its temporary files away first, and a file that would exceed the
/// allowed size (`ulimit -f`) is an error of writing instead of a sudden end.
///
/// # Errors
/// The system takes no handler.
#[cfg(unix)]
pub fn watch() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    signal_hook::flag::register(SIGXFSZ, Arc::default())?;
    let mut signals =
        Signals::new([SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| !is_ignored(*signal)))?;
    let answer = move || signals.forever().for_each(on_signal);
    std::thread::Builder::new().name("signals".to_owned()).spawn(answer)?;
    Ok(())
}

#[cfg(unix)]
fn on_signal(signal: i32) {
    let asked = ASKED.get();
    if asked.is_some_and(|flag| !flag.swap(true, Ordering::Relaxed)) {
        FIRST.get_or_init(Instant::now);
        return;
    }
    if asked.is_some() && FIRST.get().is_some_and(|first| first.elapsed() < SAME) {
        return;
    }
    remove_temporaries();
    if asked.is_some() {
        std::process::exit(AT_ONCE);
    }
    // As if nobody had listened: whoever started the program sees the signal.
    let _ = signal_hook::low_level::emulate_default_handler(signal);
    std::process::exit(AT_ONCE);
}

/// Whether whoever started the program wants a signal to be ignored, as `nohup` and shells do for work in the background.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Elsewhere only those who asked for the flag hear of Ctrl-C.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn watch() -> io::Result<()> {
    Ok(())
}

#[cfg(not(unix))]
fn listen(flag: &Arc<AtomicBool>) {
    use signal_hook::consts::SIGINT;
    // In this order: the first time the flag is not set yet when the first action asks for it. Without a handler the program
    // ends as it would have.
    let _ = signal_hook::flag::register_conditional_shutdown(SIGINT, AT_ONCE, Arc::clone(flag))
        .and_then(|_| signal_hook::flag::register(SIGINT, Arc::clone(flag)));
}
