//! The report page in a headless Chromium, opened from disk: it loads without a complaint and without a request, its
//! plots are drawn, joints are switched by mouse and keyboard. Screenshots go to the target folder.
//!
//! Skipped, and said so, where no browser is installed (Debian: `chromium`).
mod browser;
mod drawing;
mod example;
mod film;
mod opening;

use bipedc_analysis::report::{LARGEST_PAGE, Report, Row, Series, render, write, write_svg};
use browser::Browser;
use std::io::Write;
use std::path::{Path, PathBuf};

const WIDE: (u32, u32) = (1400, 900);
const PHONE: (u32, u32) = (390, 844);

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report_page").join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn browser() -> Option<Browser> {
    let browser = Browser::start(&folder("profiles"));
    if browser.is_none() {
        // Past the harness, which hides what passing tests print.
        let words = "SKIPPED: no Chromium is installed (Debian: apt install chromium): nobody looked at the report page";
        std::io::stderr().write_all(format!("{words}\n").as_bytes()).unwrap();
    }
    browser
}

/// The page as the browser opens it.
fn page(report: &Report, name: &str) -> String {
    let path = folder(name).join("report.html");
    write(report, &path).unwrap();
    let size = std::fs::metadata(&path).unwrap().len();
    println!("{}: {size} bytes", path.display());
    assert!(size < LARGEST_PAGE as u64);
    format!("file://{}", path.canonicalize().unwrap().display())
}

/// Number of colours in each canvas: one means blank.
const CANVASES: &str = "[...document.querySelectorAll('canvas')].map(c => new Set(new Uint32Array(\
    c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer)).size)";
const CHOSEN: &str = "document.getElementById('chosen').textContent";

fn assert_quiet(browser: &Browser, address: &str) {
    assert_eq!(browser.complaints(), Vec::<String>::new());
    let others: Vec<String> = browser.requests().into_iter().filter(|url| url != address).collect();
    assert_eq!(others, Vec::<String>::new(), "the page asked for something");
}

fn assert_drawn(browser: &mut Browser, plots: usize) {
    let colours = browser.evaluate(CANVASES);
    let colours = colours.as_array().unwrap();
    assert_eq!(colours.len(), plots);
    assert!(colours.iter().all(|c| c.as_u64().unwrap() > 5), "a plot is blank: {colours:?}");
    let wider =
        "[...document.querySelectorAll('.plot')].filter(p => p.plot.width > p.clientWidth + 1).length";
    assert_eq!(browser.evaluate(wider), 0, "plots lie over each other");
}

#[test]
#[ignore = "in a browser"]
fn the_page_is_drawn_and_can_be_used() {
    let report = example::report();
    let address = page(&report, "example");
    let pictures = write_svg(&report, &folder("example").join("svg")).unwrap();
    // Robot, causes, staircase; each of the twelve rows over time and against four signals.
    assert_eq!(pictures.len(), 3 + 12 * 5);
    let Some(mut browser) = browser() else { return };
    browser.open(&address, WIDE, "light");
    assert_drawn(&mut browser, 6);
    assert_eq!(browser.evaluate(CHOSEN), "1. left_knee_pitch", "the worst joint comes first");
    let heading = |row: usize| format!("{}. {}", row + 1, report.rows[row].name);
    switching(&mut browser, &heading);
    zooming(&mut browser, report.rows[0].series.len());
    several(&mut browser, &heading);
    themes(&mut browser);
    assert_quiet(&browser, &address);
}

fn switching(browser: &mut Browser, heading: &dyn Fn(usize) -> String) {
    browser.evaluate("document.querySelector('#rows button[data-row=\"3\"]').click()");
    assert_eq!(browser.evaluate(CHOSEN), heading(3));
    assert_drawn(browser, 6);
    browser.evaluate("document.querySelector('#rows button[data-row=\"3\"]').focus()");
    browser.press("ArrowDown");
    assert_eq!(browser.evaluate(CHOSEN), heading(4));
    browser.press("End");
    assert_eq!(browser.evaluate(CHOSEN), heading(11));
    browser.press("ArrowDown");
    assert_eq!(browser.evaluate(CHOSEN), heading(0));
    // In the drawing: by mouse where the disc is seen, and by keyboard.
    let place = browser.evaluate(
        "(() => { const d = document.querySelector('#robot .joint[data-row=\"5\"]'); d.scrollIntoView({block: 'center'});\
         const r = d.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; })()",
    );
    let place = (place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    browser.drag(place, place, false);
    assert_eq!(browser.evaluate(CHOSEN), heading(5));
    browser.evaluate("document.querySelector('#robot .joint[data-row=\"5\"]').focus()");
    browser.press("ArrowLeft");
    assert_ne!(browser.evaluate(CHOSEN), heading(5));
    assert_eq!(
        browser.evaluate("document.querySelectorAll('#rows [tabindex=\"0\"]').length"),
        1,
        "one tab stop"
    );
    browser.evaluate("document.querySelector('[data-show=after]').click()");
    assert_eq!(browser.evaluate("document.querySelectorAll('#robot .joint.u0').length > 12"), true);
    browser.evaluate("document.querySelector('[data-show=before]').click()");
}

fn zooming(browser: &mut Browser, samples_in_all: usize) {
    browser.evaluate("document.querySelector('#rows button[data-row=\"0\"]').click()");
    let windows = "[...document.querySelectorAll('#time-plots .plot')].map(p => p.plot.scales.x.max - p.plot.scales.x.min)";
    let both = |browser: &mut Browser| {
        browser.settle();
        let found = browser.evaluate(windows);
        let (a, b) = (found[0].as_f64().unwrap(), found[1].as_f64().unwrap());
        assert!((a - b).abs() < 1e-9, "the windows differ: {a} {b}");
        a
    };
    let whole = both(browser);
    browser.evaluate("document.querySelector('#time-plots .plot').focus()");
    browser.press("+");
    assert!((both(browser) / whole - 0.5).abs() < 0.01);
    browser.press("0");
    assert!((both(browser) / whole - 1.0).abs() < 0.01);
    // A drag over the middle half of the residual.
    let middle = browser.evaluate(
        "(() => { const d = document.querySelectorAll('#time-plots .u-over')[1]; d.scrollIntoView({block: 'center'});\
         const r = d.getBoundingClientRect(); return [r.x + r.width / 4, r.x + 3 * r.width / 4, r.y + r.height / 2]; })()",
    );
    let [from, to, y] = [0, 1, 2].map(|i| middle[i].as_f64().unwrap());
    browser.drag((from, y), (to, y), false);
    assert!((both(browser) / whole - 0.5).abs() < 0.02);
    // Shift and a drag to the right: an earlier window of the same length.
    let start = "document.querySelector('#time-plots .plot').plot.scales.x.min";
    let before = browser.evaluate(start).as_f64().unwrap();
    browser.drag((from, y), (0.75 * from + 0.25 * to, y), true);
    assert!((both(browser) / whole - 0.5).abs() < 0.02);
    let moved = before - browser.evaluate(start).as_f64().unwrap();
    assert!((moved / whole - 0.0625).abs() < 0.01, "moved by {moved} s");
    let samples = "document.querySelector('#scatter-plots .plot').plot.data[0].length";
    let few = browser.evaluate(samples).as_f64().unwrap();
    assert!(
        (few / samples_in_all as f64 - 0.5).abs() < 0.02,
        "{few} samples of the window in the scatter plot"
    );
    browser.press("0");
    // The cursor of one plot shows in the other, and its sample in the scatter plots.
    browser.drag((to, y), (to, y), false);
    browser.settle();
    let cursors = "[...document.querySelectorAll('#time-plots .plot')].map(p => p.plot.cursor.idx)";
    let cursors = browser.evaluate(cursors);
    assert!(cursors[0].is_u64() && cursors[0] == cursors[1], "{cursors}");
    assert_eq!(browser.evaluate("document.querySelectorAll('.spot:not([hidden])').length"), 4);
}

/// Rows beside one another: by check box, by Ctrl and a click; they show the same times.
fn several(browser: &mut Browser, heading: &dyn Fn(usize) -> String) {
    browser.evaluate("document.querySelector('#rows button[data-row=\"0\"]').click()");
    browser.evaluate("document.querySelector('#rows input[data-also=\"2\"]').click()");
    browser.evaluate(
        "document.querySelector('#rows button[data-row=\"4\"]').dispatchEvent(new MouseEvent('click', { ctrlKey: true, bubbles: true }))",
    );
    assert_eq!(browser.evaluate(CHOSEN), format!("{}, {}, {}", heading(0), heading(2), heading(4)));
    let plots = "document.querySelectorAll('#time-plots .plot').length";
    assert_eq!(browser.evaluate(plots), 6);
    browser.evaluate("document.querySelector('[data-plot=in]').click()");
    browser.settle();
    let windows = "new Set([...document.querySelectorAll('#time-plots .plot')].map(p => p.plot.scales.x.max.toFixed(6))).size";
    assert_eq!(browser.evaluate(windows), 1, "all show the same times");
    // The first goes, the next one takes its place; a plain click shows one again.
    browser.evaluate("document.querySelector('#rows input[data-also=\"0\"]').click()");
    assert_eq!(browser.evaluate(CHOSEN), format!("{}, {}", heading(2), heading(4)));
    browser.evaluate("document.querySelector('#rows button[data-row=\"0\"]').click()");
    assert_eq!(browser.evaluate(plots), 2);
    browser.evaluate("document.querySelector('[data-plot=reset]').click()");
}

fn themes(browser: &mut Browser) {
    let ground = "getComputedStyle(document.body).backgroundColor";
    let automatic = browser.evaluate(ground);
    browser.evaluate("document.getElementById('theme').click()");
    assert_eq!(browser.evaluate(ground), automatic, "light, as the system");
    browser.evaluate("document.getElementById('theme').click()");
    assert_ne!(browser.evaluate(ground), automatic);
    browser.evaluate("document.getElementById('theme').click()");
    assert_eq!(browser.evaluate(ground), automatic);
}

/// Nothing wider than the window, in both themes; the pictures are for people.
#[test]
#[ignore = "in a browser"]
fn it_fits_wide_and_narrow_dark_and_light() {
    let address = page(&example::report(), "shots");
    let Some(mut browser) = browser() else { return };
    for (shape, size) in [("wide", WIDE), ("phone", PHONE)] {
        for theme in ["light", "dark"] {
            browser.open(&address, size, theme);
            assert_drawn(&mut browser, 6);
            let width = browser.evaluate("document.documentElement.scrollWidth").as_u64().unwrap();
            assert!(width <= u64::from(size.0), "{shape}: {width} px wide");
            std::fs::write(folder("shots").join(format!("{shape}-{theme}.png")), browser.screenshot())
                .unwrap();
        }
    }
    fingers(&mut browser);
    let paper = browser.print();
    assert!(paper.starts_with(b"%PDF"));
    std::fs::write(folder("shots").join("print.pdf"), paper).unwrap();
    assert_quiet(&browser, &address);
}

/// On a phone two fingers that part show less time, and one finger moves the window.
fn fingers(browser: &mut Browser) {
    let place = browser.evaluate(
        "(() => { const d = document.querySelector('#time-plots .u-over'); d.scrollIntoView({block: 'center'});\
         const r = d.getBoundingClientRect(); return [r.x, r.width, r.y + r.height / 2]; })()",
    );
    let [left, width, y] = [0, 1, 2].map(|i| place[i].as_f64().unwrap());
    let at = |part: f64| (left + part * width, y);
    let window = |browser: &mut Browser| {
        let scale = "(s => [s.min, s.max])(document.querySelector('#time-plots .plot').plot.scales.x)";
        let found = browser.evaluate(scale);
        [0, 1].map(|i| found[i].as_f64().unwrap())
    };
    let [low, high] = window(browser);
    browser.touch(&[at(0.4), at(0.6)], &[at(0.3), at(0.7)]);
    let [a, b] = window(browser);
    assert!(((b - a) / (high - low) - 0.5).abs() < 0.05, "{low} {high} {a} {b}");
    browser.touch(&[at(0.6)], &[at(0.4)]);
    let [c, d] = window(browser);
    assert!(
        ((c - a) / (b - a) - 0.2).abs() < 0.08 && ((d - c) / (b - a) - 1.0).abs() < 1e-3,
        "{a} {b} {c} {d}"
    );
}

/// A comparison alone: no effects, no diagnosis, no history, no drawing.
#[test]
#[ignore = "in a browser"]
fn a_comparison_alone_makes_a_page() {
    let mut report = example::report();
    (report.diagnosis, report.drawing) = (None, None);
    report.history.clear();
    report.rows.truncate(4);
    for row in &mut report.rows {
        *row =
            Row::new(&row.name, row.channel, &row.unit, 0.0, Series { amended: None, ..row.series.clone() });
    }
    let address = page(&report, "plain");
    let Some(mut browser) = browser() else { return };
    browser.open(&address, WIDE, "light");
    assert_drawn(&mut browser, 6);
    assert_quiet(&browser, &address);
    std::fs::write(folder("plain").join("wide-light.png"), browser.screenshot()).unwrap();
}

/// Twelve joints with 20 000 samples stay below the limit, and the page says what it left out.
#[test]
#[ignore = "in a browser"]
fn long_logs_are_thinned() {
    let mut report = example::report();
    for row in &mut report.rows {
        let series = &mut row.series;
        let length = series.time[series.time.len() - 1] - series.time[0] + 0.004;
        series.time =
            (0..9).flat_map(|k| series.time.iter().map(move |t| t + f64::from(k) * length)).collect();
        let columns = [&mut series.measured, &mut series.nominal].into_iter().chain(&mut series.amended);
        for column in columns.chain(series.signals.iter_mut().map(|signal| &mut signal.values)) {
            *column = column.repeat(9);
        }
    }
    let total = report.rows[0].series.len();
    let address = page(&report, "long");
    let Some(mut browser) = browser() else { return };
    let start = std::time::Instant::now();
    browser.open(&address, WIDE, "dark");
    println!("loaded and drawn in {:.2} s", start.elapsed().as_secs_f64());
    assert_drawn(&mut browser, 6);
    let words = browser.evaluate("document.getElementById('chosen-numbers').textContent");
    assert!(words.as_str().unwrap().contains(&format!("of {total} samples are drawn")), "{words}");
    assert_quiet(&browser, &address);
}

/// Names that try to break out, gaps, nothing but one row: still a page.
#[test]
#[ignore = "in a browser"]
fn hostile_and_poor_input_makes_a_page() {
    let evil = "</script><script>document.title = 'broken'</script><img src=x onerror=alert(1)> & \"knee\"";
    let series = Series {
        time: (0..50).map(|i| if i == 20 { f64::NAN } else { f64::from(i) }).collect(),
        measured: (0..50).map(|i| if i % 7 == 0 { f64::NAN } else { f64::from(i).sin() }).collect(),
        nominal: vec![f64::INFINITY; 50].into_iter().chain([1.0]).collect(),
        ..Series::default()
    };
    let mut report = example::report();
    report.title = evil.to_owned();
    report.rows.truncate(1);
    report.rows[0].name = evil.to_owned();
    report.rows[0].series.measured[10] = f64::NAN;
    report.rows.push(Row::new(evil, report.rows[0].channel, evil, f64::NAN, series));
    report.history[0].label = evil.to_owned();
    let empty = page(&Report::default(), "empty");
    let address = page(&report, "hostile");
    assert!(!render(&report).contains("<script>document"));
    let Some(mut browser) = browser() else { return };
    browser.open(&empty, PHONE, "dark");
    assert_quiet(&browser, &empty);
    browser.events.clear();
    browser.open(&address, WIDE, "light");
    assert_eq!(browser.evaluate("document.title"), evil);
    browser.evaluate("document.querySelector('#rows button[data-row=\"1\"]').click()");
    assert!(browser.evaluate(CHOSEN).as_str().unwrap().contains("</script>"));
    assert_eq!(browser.evaluate("document.images.length"), 0);
    assert_quiet(&browser, &address);
}

/// A page that takes long to build itself, opened three times with one browser: each time it is the new one that is seen,
/// when it is complete.
#[test]
#[ignore = "in a browser"]
fn opening_waits_for_the_page_itself() {
    let work =
        "<script>for (const end = performance.now() + 40; performance.now() < end;);</script><p>more</p>";
    let last = "<script>setTimeout(() => { document.title = String(innerWidth); }, 500);</script>";
    let path = folder("slow").join("slow.html");
    std::fs::write(&path, format!("<!doctype html><title>not yet</title>{}{last}", work.repeat(30))).unwrap();
    let address = format!("file://{}", path.canonicalize().unwrap().display());
    let Some(mut browser) = browser() else { return };
    for width in [700, 800, 900] {
        browser.open(&address, (width, 600), "light");
        assert_eq!(browser.evaluate("document.title"), width.to_string());
    }
    assert_quiet(&browser, &address);
}
