//! TUlip falls, on film: the page plays, pauses and is scrubbed by mouse and keyboard; what it shows agrees with the simulation.
use super::browser::Browser;
use super::example::root;
use super::{PHONE, WIDE, assert_quiet, browser, folder};
use bipedc::film::Recorder;
use bipedc::simulation::{filmed_model, plant};
use bipedc_analysis::report::{Film, LARGEST_PAGE, render_film, write_film, write_strobe};
use bipedc_analysis::robot::Side;
use bipedc_analysis::simulate::{Mechanics, Run, Scenario, Simulation};
use bipedc_compiler::Robot;
use std::sync::OnceLock;

const DROP: &str = "duration = 0.6\n[initial]\nclearance = 0.1\nbase_rotation = [0.1, 0.05, 0.3]\n[control]\nstiffness = 100.0\ndamping = 0.5\n";
const COLLAPSE: &str =
    "duration = 0.6\n[initial]\nbase_rotation = [0.0, 0.1, 0.0]\n[control]\ndamping = 0.1\n";

/// Simulates a scenario of TUlip.
fn filmed(name: &str, scenario: &str) -> Film {
    let robot = Robot::read(&root().join("robots/tulip")).unwrap();
    let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
    let path = folder("film").join(format!("{name}.toml"));
    std::fs::write(&path, scenario).unwrap();
    let scenario = Scenario::open(&path, &plant).unwrap();
    let model = filmed_model(&robot, &[]).unwrap();
    let mechanics = Mechanics::new(&model, plant.layout.base).unwrap();
    let mut recorder = Recorder::new(&robot, mechanics, scenario.duration, 600).unwrap();
    let simulation = Simulation::new(mechanics, &plant, &scenario).unwrap();
    let simulation = simulation.watched(|sample| recorder.take(sample));
    let (mut row, progress, stop) = (|_: &[f64]| Ok(()), |_: f64| (), || false);
    simulation.run(&mut Run { row: &mut row, progress: &progress, stop: &stop }).unwrap();
    recorder.finish()
}

fn drop() -> &'static Film {
    static DROPPED: OnceLock<Film> = OnceLock::new();
    DROPPED.get_or_init(|| filmed("drop", DROP))
}

fn page(film: &Film, name: &str) -> String {
    let path = folder("film").join(format!("{name}.html"));
    write_film(film, &path).unwrap();
    let size = std::fs::metadata(&path).unwrap().len();
    println!("{}: {size} bytes", path.display());
    assert!(size < LARGEST_PAGE as u64);
    format!("file://{}", path.canonicalize().unwrap().display())
}

const TIME: &str = "Number(document.getElementById('scrub').value)";

fn time(browser: &mut Browser) -> f64 {
    browser.evaluate(TIME).as_f64().unwrap()
}

/// Frames, marks and curves against what mechanics says.
#[test]
#[ignore = "in a browser"]
fn what_is_shown_is_what_happened() {
    let film = drop();
    assert_eq!((film.frames.len(), film.time.len()), (36, 600));
    let legs = |side: Option<Side>| film.parts.iter().filter(|part| part.side == side).count();
    assert!(
        legs(Some(Side::Left)) > 4 && legs(Some(Side::Left)) == legs(Some(Side::Right)) && legs(None) == 4
    );
    let fall = (2.0 * 0.1 / 9.81_f64).sqrt();
    let landing = film.time.iter().zip(&film.loads[0]).find(|(_, load)| **load > 1.0).unwrap().0;
    assert!((landing - fall).abs() < 0.003, "{landing} s for a fall of {fall} s");
    for frame in film.frames.iter().filter(|frame| frame.time < 0.13) {
        let fallen = film.frames[0].center_of_mass[2] - frame.center_of_mass[2];
        assert!((fallen - 0.5 * 9.81 * frame.time.powi(2)).abs() < 1e-6, "{fallen} at {}", frame.time);
        assert_eq!(frame.center_of_pressure, None, "in the air");
    }
    // The lowest contact point of the first frame is where the scenario put it, by the poses alone.
    let first = &film.frames[0];
    let heights = film.points.iter().map(|point| first.at(point.body, point.place)[2]);
    let lowest = heights.fold(f64::MAX, f64::min);
    assert!((lowest - 0.1).abs() < 1e-9, "{lowest}");
    // Of standing frames: the centre of pressure lies between the loaded corners, and its foot's load is theirs.
    let mut pressed = 0;
    for frame in &film.frames {
        let Some(pressure) = frame.center_of_pressure else { continue };
        pressed += 1;
        for (axis, at) in pressure.into_iter().enumerate() {
            let carrying = film.points.iter().zip(&frame.forces).filter(|(_, force)| force[2] > 0.0);
            let places: Vec<f64> = carrying.map(|(p, _)| frame.at(p.body, p.place)[axis]).collect();
            let (low, high) = places.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
            assert!(low - 1e-9 <= at && at <= high + 1e-9, "{low} {at} {high}");
        }
    }
    assert!(pressed > 15, "{pressed}");
    // Nothing makes energy in the air, and nothing takes it.
    let energy = &film.plots[1];
    assert_eq!(energy.title, "Energy of the links");
    let sum = &energy.curves[2].values;
    let air = film.time.iter().zip(sum).filter(|(t, _)| **t < 0.13).map(|(_, e)| e.abs()).fold(0.0, f64::max);
    println!("energy in the air changes by {air:.1e} J");
    assert!(air < 1e-3, "{air}");
    let kinetic = &energy.curves[0].values;
    let expected = 0.5 * film.weight / 9.81 * (9.81 * film.time[130]).powi(2);
    assert!((kinetic[130] / expected - 1.0).abs() < 1e-4, "{} {expected}", kinetic[130]);
}

#[test]
#[ignore = "in a browser"]
fn the_film_is_played_and_scrubbed() {
    let film = drop();
    let address = page(film, "drop");
    let pictures = write_strobe(film, &folder("film").join("svg")).unwrap();
    assert_eq!(pictures.len(), 2);
    let Some(mut browser) = browser() else { return };
    browser.open(&address, WIDE, "light");
    let last = film.frames[film.frames.len() - 1].time;
    let blank = "['side', 'front', 'solid', 'above', 'strip'].filter(id => { const c = document.getElementById(id);\
        return new Set(new Uint32Array(c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer)).size < 6; })";
    assert_eq!(browser.evaluate(blank), serde_json::json!([]), "blank canvases");
    assert_eq!(browser.evaluate("document.querySelectorAll('.plot canvas').length"), 5);
    // Scrubbing: three times, three pictures, in every view.
    let mut seen = Vec::new();
    for part in [0.0, 0.4, 0.9] {
        let scrub = format!(
            "(() => {{ const s = document.getElementById('scrub'); s.value = {}; s.dispatchEvent(new Event('input')); }})()",
            part * last
        );
        browser.evaluate(&scrub);
        browser.settle();
        assert!((time(&mut browser) - part * last).abs() < 1e-6);
        let views = ["side", "front", "solid", "above"].map(|id| {
            let picture = browser.evaluate(&format!("document.getElementById('{id}').toDataURL()"));
            picture.as_str().unwrap().to_owned()
        });
        let shot = browser.screenshot();
        std::fs::write(folder("film").join(format!("drop-{part}.png")), &shot).unwrap();
        for (other, earlier) in &seen {
            assert_ne!(other, &shot);
            let earlier: &[String; 4] = earlier;
            assert!(views.iter().zip(earlier).all(|(a, b)| a != b), "a view stands still at {part}");
        }
        seen.push((shot, views));
    }
    keys(&mut browser, film, last);
    playing(&mut browser, last);
    pointer(&mut browser, last);
    assert_quiet(&browser, &address);
}

fn keys(browser: &mut Browser, film: &Film, last: f64) {
    browser.press("Home");
    assert_eq!(time(browser), 0.0);
    browser.press("ArrowRight");
    browser.press("ArrowRight");
    assert!((time(browser) - film.frames[2].time).abs() < 1e-5);
    browser.press("ArrowLeft");
    assert!((time(browser) - film.frames[1].time).abs() < 1e-5);
    browser.press("End");
    assert!((time(browser) - last).abs() < 1e-5);
    browser.press("<");
    assert_eq!(browser.evaluate("document.getElementById('speed').value"), "0.5");
}

/// Plays at the slowest speed, so that a busy machine does not reach the end before it is looked at.
fn playing(browser: &mut Browser, last: f64) {
    let pressed = "document.getElementById('play').getAttribute('aria-pressed')";
    let select = "(() => { document.getElementById('speed').value = '0.02'; document.getElementById('play').click(); })()";
    browser.evaluate(select);
    browser.wait_for(&format!("{TIME} > 0"));
    let first = time(browser);
    assert!(first > 0.0 && first < last, "from the end it begins anew: {first}");
    browser.wait_for(&format!("{TIME} > {first}"));
    browser.press(" ");
    let paused = time(browser);
    assert!(paused > first && paused < last, "it plays: {first} {paused}");
    browser.settle();
    browser.settle();
    assert_eq!(time(browser), paused, "it pauses");
    assert_eq!(browser.evaluate(pressed), "false");
    // To the end, where it stops by itself.
    browser.evaluate("document.getElementById('speed').value = '2'");
    browser.press(" ");
    browser.wait_for(&format!("{pressed} === 'false'"));
    assert!((time(browser) - last).abs() < 1e-5);
}

fn pointer(browser: &mut Browser, last: f64) {
    let boxes = |browser: &mut Browser, selector: &str| {
        let found = browser.evaluate(&format!(
            "(() => {{ const e = document.querySelector('{selector}'); e.scrollIntoView({{block: 'center'}});\
             const r = e.getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; }})()"
        ));
        [0, 1, 2, 3].map(|i| found[i].as_f64().unwrap())
    };
    let [x, y, width, _] = boxes(browser, "#strip");
    browser.drag((x + 0.5 * width, y + 5.0), (x + 0.5 * width, y + 5.0), false);
    assert!((time(browser) / last - 0.5).abs() < 0.01, "{}", time(browser));
    let [x, y, width, height] = boxes(browser, "#film-plots .u-over");
    browser.drag((x + 0.25 * width, y + 0.5 * height), (x + 0.25 * width, y + 0.5 * height), false);
    assert!((time(browser) / last - 0.25).abs() < 0.03, "{}", time(browser));
    let picture = "document.getElementById('solid').toDataURL()";
    let before = browser.evaluate(picture);
    let [x, y, width, height] = boxes(browser, "#solid");
    browser.drag((x + 0.3 * width, y + 0.5 * height), (x + 0.6 * width, y + 0.4 * height), false);
    assert_ne!(browser.evaluate(picture), before, "a drag turns the view");
    // Another joint, other plots.
    browser.evaluate(
        "for (const box of document.querySelectorAll('#joints input')) if (box.checked !== (box.value === 'left_knee_pitch')) box.click()",
    );
    let titles =
        browser.evaluate("[...document.querySelectorAll('.plot h4')].map(h => h.textContent).join()");
    assert!(titles.as_str().unwrap().contains("Position of left_knee_pitch (rad)"), "{titles}");
    // Several at once.
    let count = "document.querySelectorAll('.plot').length";
    browser.evaluate("document.querySelector('#joints input:not(:checked)').click()");
    assert_eq!(browser.evaluate(count), 7);
    browser.evaluate("document.querySelector('#joints input:checked').click()");
    browser.settle();
    let heads = "[...document.querySelectorAll('.plot')].map(p => Math.abs(p.plot.valToPos(Number(document.getElementById('scrub').value), 'x')\
        - parseFloat(p.plot.head.style.left)))";
    let heads = browser.evaluate(heads);
    assert_eq!(heads.as_array().unwrap().len(), 5);
    assert!(
        heads.as_array().unwrap().iter().all(|off| off.as_f64().unwrap() < 0.5),
        "times are off by {heads} px"
    );
}

/// Nothing wider than the window, in both themes, and on paper; the pictures are for people.
#[test]
#[ignore = "in a browser"]
fn the_film_fits_wide_and_narrow_dark_and_light() {
    let film = filmed("collapse", COLLAPSE);
    let address = page(&film, "collapse");
    let Some(mut browser) = browser() else { return };
    for (shape, size) in [("wide", WIDE), ("phone", PHONE)] {
        for theme in ["light", "dark"] {
            browser.open(&address, size, theme);
            browser.evaluate("(() => { const s = document.getElementById('scrub'); s.value = 0.43; s.dispatchEvent(new Event('input')); })()");
            browser.settle();
            let width = browser.evaluate("document.documentElement.scrollWidth").as_u64().unwrap();
            assert!(width <= u64::from(size.0), "{shape}: {width} px wide");
            let shot = browser.screenshot();
            std::fs::write(folder("film").join(format!("{shape}-{theme}.png")), shot).unwrap();
        }
    }
    let paper = browser.print();
    assert!(paper.starts_with(b"%PDF"));
    std::fs::write(folder("film").join("print.pdf"), paper).unwrap();
    assert_quiet(&browser, &address);
}

/// Names that try to break out, values that are no numbers, nothing at all: still a page.
#[test]
#[ignore = "in a browser"]
fn hostile_and_poor_films_make_a_page() {
    let mut film = drop().clone();
    film.title = "</script><script>document.title = 'broken'</script>".to_owned();
    film.feet[0].name = film.title.clone();
    film.plots[0].curves[0].values[7] = f64::NAN;
    film.frames[3].poses[2].position[1] = f64::NAN;
    film.frames[4].center_of_mass = [f64::NAN; 3];
    film.frames.truncate(12);
    assert!(!render_film(&film).contains("<script>document"));
    let (address, empty) = (page(&film, "hostile"), page(&Film::default(), "empty"));
    let Some(mut browser) = browser() else { return };
    browser.open(&empty, PHONE, "dark");
    assert_quiet(&browser, &empty);
    browser.events.clear();
    browser.open(&address, WIDE, "light");
    assert_eq!(browser.evaluate("document.title"), film.title.as_str());
    browser.press("End");
    assert_quiet(&browser, &address);
}
