//! What the pages of `compare` and `diagnose` open with: cards, the robot, grouped words, commands; rows by the size of their error.
use super::{PHONE, WIDE, assert_quiet, browser, example, folder, page};
use crate::cli::{bipedc, text};
use serde_json::Value;

/// A page that a command writes, as the browser opens it.
fn written(name: &str, arguments: &[&str]) -> String {
    let path = folder(name).join("report.html");
    bipedc(&[arguments, &["--report", text(&path)]].concat()).ok();
    format!("file://{}", path.canonicalize().unwrap().display())
}

fn texts(value: &Value) -> Vec<String> {
    value.as_array().unwrap().iter().map(|text| text.as_str().unwrap().replace('\u{a0}', " ")).collect()
}

const CARDS: &str = "[...document.querySelectorAll('.card .figure')].map(e => e.textContent)";
const WORDS: &str = "[...document.querySelectorAll('.summary p')].map(e => e.textContent)";
const ROWS: &str = "[...document.querySelectorAll('#rows tbody tr')].map(e => e.innerText)";
const COMMANDS: &str = "[...document.querySelectorAll('.command code')].map(e => e.textContent)";

#[test]
#[ignore = "in a browser"]
fn a_comparison_opens_with_its_answer() {
    let log = "tests/data/examples/coulomb/validation.csv.gz";
    let address = written("compare", &["compare", "robots/tulip", log]);
    let Some(mut browser) = browser() else { return };
    for (shape, size) in [("wide", WIDE), ("phone", PHONE)] {
        browser.open(&address, size, "light");
        std::fs::write(folder("compare").join(format!("{shape}.png")), browser.screenshot()).unwrap();
        let width = browser.evaluate("document.documentElement.scrollWidth").as_u64().unwrap();
        assert!(width <= u64::from(size.0), "{shape}: {width} px wide");
    }
    let cards = texts(&browser.evaluate(CARDS));
    assert_eq!(cards[..3], ["validation.csv.gz", "10 of 12 joints", "0.399 N m"]);
    // Of the log's noise of 0.02 to 0.05 N m, which is told from the log.
    let noise: Vec<f64> = cards[3].split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(matches!(noise[..], [0.018..0.021, 0.05..0.056]) && cards[3].ends_with("N m"), "{cards:?}");
    let words = texts(&browser.evaluate(WORDS));
    assert!(words.len() == 3 && words[0].starts_with("left_knee_pitch: the residual follows"), "{words:?}");
    assert!(words[2].starts_with("10 joints: nothing but noise is left: "), "{words:?}");
    assert_eq!(
        texts(&browser.evaluate(COMMANDS)),
        [format!("bipedc diagnose robots/tulip {log} --report diagnosis.html")]
    );
    let errors: Vec<f64> =
        texts(&browser.evaluate("[...document.querySelectorAll('#rows .error')].map(e => e.textContent)"))
            .iter()
            .map(|error| error.split(' ').next().unwrap().parse().unwrap())
            .collect();
    assert!(errors.len() == 12 && errors.is_sorted_by(|a, b| a >= b), "{errors:?}");
    // The robot stands beside the cards, above where a large screen ends.
    browser.open(&address, WIDE, "light");
    let bottom = "document.querySelector('.opening').getBoundingClientRect().bottom";
    assert!(browser.evaluate(bottom).as_f64().unwrap() < f64::from(WIDE.1));
    let beside = "document.querySelector('#robot').getBoundingClientRect().left > document.querySelector('.cards').getBoundingClientRect().right";
    assert_eq!(browser.evaluate(beside), true);
    assert_quiet(&browser, &address);
}

/// Forces, moments and efforts are not held against one another.
#[test]
#[ignore = "in a browser"]
fn units_stand_apart() {
    let log = "tests/data/examples/swaying/validation.csv.gz";
    let address = written("units", &["compare", "robots/tulip", log]);
    let Some(mut browser) = browser() else { return };
    browser.open(&address, PHONE, "dark");
    let rows = texts(&browser.evaluate(ROWS));
    let heads: Vec<usize> = (0..rows.len()).filter(|&k| rows[k].starts_with("errors in ")).collect();
    let units: Vec<&str> = heads.iter().map(|&k| rows[k].as_str()).collect();
    assert_eq!(units, ["errors in N", "errors in N m", "errors in m"]);
    let numbers: Vec<u64> = browser
        .evaluate("[...document.querySelectorAll('#rows button')].map(e => Number(e.dataset.row))")
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n.as_u64().unwrap())
        .collect();
    assert!(numbers.iter().copied().eq(0..numbers.len() as u64), "{numbers:?}");
    let cards = texts(&browser.evaluate(CARDS));
    // Heights of the soles have nothing but noise left: nothing is said of them.
    let told =
        |unit: &str| cards.iter().filter(|card| card.ends_with(unit) && !card.contains(" to ")).count();
    assert_eq!([told(" N"), told(" N m"), cards.len()], [1, 1, 5], "{cards:?}");
    std::fs::write(folder("units").join("phone.png"), browser.screenshot()).unwrap();
    assert_quiet(&browser, &address);
}

/// A diagnosis: what it found, and the commands that write it down, which run as they stand.
#[test]
#[ignore = "in a browser"]
fn a_diagnosis_opens_with_its_answer() {
    let train = "tests/data/examples/coulomb/train.csv.gz";
    let judge = "tests/data/examples/coulomb/validation.csv.gz";
    let options = ["--validate", judge, "--inertial", "none", "--most", "1", "--cutoff", "16"];
    let address = written("diagnose", &[&["diagnose", "robots/tulip", train], &options[..]].concat());
    let Some(mut browser) = browser() else { return };
    browser.open(&address, WIDE, "light");
    std::fs::write(folder("diagnose").join("wide.png"), browser.screenshot()).unwrap();
    let cards = texts(&browser.evaluate(CARDS));
    assert_eq!(cards[0], "validation.csv.gz");
    assert!(cards.iter().any(|card| card.starts_with("0.399 → 0.05")), "{cards:?}");
    let commands = texts(&browser.evaluate(COMMANDS));
    let expected = format!(
        "bipedc diagnose robots/tulip {train} --validate {judge} --cutoff 16 --inertial none --most 1 --json > diagnosis.json && bipedc amend robots/tulip --from diagnosis.json"
    );
    assert_eq!(commands[0], expected);
    browser.open(&address, PHONE, "dark");
    std::fs::write(folder("diagnose").join("phone.png"), browser.screenshot()).unwrap();
    assert_quiet(&browser, &address);
}

/// A click copies a command or, where the browser refuses that, marks it.
#[test]
#[ignore = "in a browser"]
fn commands_are_copied() {
    let address = page(&example::report(), "copied");
    let Some(mut browser) = browser() else { return };
    browser.open(&address, WIDE, "light");
    let said = browser.evaluate(
        "(() => { const b = document.querySelector('[data-copy]'); b.click(); return b.textContent; })()",
    );
    assert!(said == "Copied" || said == "Marked", "{said}");
    let marked = browser.evaluate("getSelection().toString()");
    assert_eq!(marked, "bipedc amend robots/tulip --from diagnosis.json");
    browser.settle();
    assert_eq!(browser.evaluate("document.querySelector('[data-copy]').textContent"), "Copy");
    assert_quiet(&browser, &address);
}
