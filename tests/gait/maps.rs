//! `bipedc gait map`: cells are steps, the findings of the thesis (7.2.1), files that go on, pictures.
use super::gait;
use crate::cli::{bipedc, command, scratch, text};
use bipedc::gait::{Assumptions, GaitBench, GaitMap, MapOptions, Over, Range, StepOptions};
use bipedc::progress::{Run, Silent};
use roxmltree::Document;
use std::cell::Cell;
use std::path::Path;

fn over(name: &str, low: f64, high: f64, count: usize) -> Over {
    Over { name: name.to_owned(), range: Range { low, high, count } }
}

/// A map without a file, uninterrupted.
fn map(bench: &GaitBench, options: &MapOptions) -> GaitMap {
    bench.map(options, None, &Run { progress: &Silent, stop: &|| false }).unwrap_or_else(|e| panic!("{e}"))
}

/// Figure 7.2, coarsely.
fn three_link(speeds: &[f64], count: usize) -> MapOptions {
    MapOptions {
        speeds: speeds.to_vec(),
        over: vec![over("step_length", 0.1, 1.4, count), over("torso_lean", -2.0, 2.0, count)],
        ..MapOptions::default()
    }
}

/// Every cell against `gait step` with its parameters, to the last bit; how many pass.
fn cells_are_steps(bench: &GaitBench, options: &MapOptions) -> usize {
    let found = map(bench, options);
    let [x, y] = &found.over;
    let mut passes = 0;
    for (row, b) in y.values.iter().enumerate() {
        for (column, a) in x.values.iter().enumerate() {
            for one in &found.maps {
                let mut set = options.set.clone();
                set.extend([(x.name.clone(), *a), (y.name.clone(), *b)]);
                let asked = StepOptions {
                    speed: one.speed,
                    set,
                    from: options.from.clone(),
                    ..StepOptions::default()
                };
                let step = bench.step(&asked).unwrap().step;
                let reason = found.reasons[one.reason[row][column]].code();
                assert_eq!(step.next_speed, one.next_speed[row][column], "{a} {b} {}", one.speed);
                let words = step.reason.unwrap_or_default();
                match reason {
                    "passes" => assert!(words.is_empty(), "{words}"),
                    "falls_back" => assert!(words.contains("falls back"), "{words}"),
                    "singular" => assert!(words.contains("angular momentum"), "{words}"),
                    "turns_back" => assert!(words.contains("turns back"), "{words}"),
                    "guard_not_reached" => assert!(words.contains("guard"), "{words}"),
                    _ => panic!("{reason}: {words}"),
                }
                passes += usize::from(reason == "passes");
            }
        }
    }
    passes
}

#[test]
#[ignore = "takes long"]
fn cells_of_a_map_are_steps_to_the_last_bit() {
    let three = gait("robots/three_link", "thesis");
    let wide = MapOptions {
        over: vec![over("step_length", 0.1, 2.4, 9), over("torso_lean", -2.0, 2.0, 7)],
        ..three_link(&[0.7, 1.9], 2)
    };
    assert!(cells_are_steps(&three, &wide) > 20);
    let five = gait("robots/five_link", "thesis");
    let knees = MapOptions {
        speeds: vec![1.2],
        over: vec![over("step_length", 0.15, 0.7, 5), over("knee", 0.05, 0.8, 4)],
        set: vec![("torso_lean".to_owned(), 0.3)],
        ..MapOptions::default()
    };
    assert!(cells_are_steps(&five, &knees) > 5);
    let bent = super::bent();
    let iterated = MapOptions {
        over: vec![over("step_length", 0.3, 0.9, 3), over("torso_lean", -0.6, 0.2, 3)],
        ..three_link(&[1.5], 2)
    };
    assert!(cells_are_steps(&bent, &iterated) > 3);
}

/// With `from` the step before is the same for all cells.
#[test]
fn cells_after_another_step_are_steps_too() {
    let three = gait("robots/three_link", "thesis");
    let from = vec![("step_length".to_owned(), 0.4), ("torso_lean".to_owned(), -0.5)];
    let options = MapOptions {
        over: vec![over("step_length", 0.3, 0.9, 4), over("torso_lean", -0.8, -0.2, 4)],
        from: from.clone(),
        ..three_link(&[1.5], 2)
    };
    let found = map(&three, &options);
    for (row, b) in found.over[1].values.iter().enumerate() {
        for (column, a) in found.over[0].values.iter().enumerate() {
            let set = vec![("step_length".to_owned(), *a), ("torso_lean".to_owned(), *b)];
            let asked = StepOptions { speed: 1.5, set, from: from.clone(), ..StepOptions::default() };
            assert_eq!(three.step(&asked).unwrap().step.next_speed, found.maps[0].next_speed[row][column]);
        }
    }
}

/// "The influence of step size and torso lean" (7.2.1, figure 7.2): longer steps are slower where steps are not short, leaning forward is
/// faster, and the faster a robot is, the more steps are possible and the smaller is the gain.
#[test]
fn the_map_of_the_three_link_robot_is_that_of_the_thesis() {
    let speeds = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0];
    let found = map(&gait("robots/three_link", "thesis"), &three_link(&speeds, 27));
    let mut compared = [0; 2];
    for one in &found.maps {
        for (row, speeds) in one.next_speed.iter().enumerate() {
            for (column, next) in speeds.iter().enumerate() {
                let Some(next) = *next else { continue };
                // Longer than 0.6 m: the impact takes more than the longer fall gives.
                let longer = speeds.get(column + 1).copied().flatten();
                if let Some(longer) = longer.filter(|_| found.over[0].values[column] >= 0.6) {
                    assert!(longer < next, "{} at {column}, {row}", one.speed);
                    compared[0] += 1;
                }
                // Within the bounds of the lean, negative forward.
                let back = one.next_speed.get(row + 1).and_then(|speeds| speeds[column]);
                let [lean, upper] = [found.over[1].values[row], 0.5];
                if let Some(back) = back.filter(|_| (-1.0..upper).contains(&lean)) {
                    assert!(back < next, "{} at {column}, {row}", one.speed);
                    compared[1] += 1;
                }
            }
        }
    }
    assert!(compared.iter().all(|count| *count > 300), "{compared:?}");
    let passes: Vec<usize> = found.maps.iter().map(|one| one.counts["passes"]).collect();
    assert!(passes.windows(2).all(|pair| pair[0] < pair[1]), "{passes:?}");
    let gains: Vec<f64> = found.maps.iter().map(|one| one.fastest.unwrap().next_speed - one.speed).collect();
    assert!(gains.windows(2).all(|pair| pair[0] > pair[1]) && gains[5] > 0.0, "{gains:?}");
    // "The highest acceleration does not necessarily occur at the smallest step size"; it lies where the lean is most forward.
    let first = found.maps[0].fastest.unwrap();
    assert!(first.at[0] > 0.3 && first.at[1] < -0.9, "{first:?}");
}

/// Figure 7.4: "very similar"; here positive leans forward.
#[test]
fn the_map_of_the_five_link_robot_is_that_of_the_thesis() {
    let options = MapOptions {
        speeds: vec![1.0, 2.0, 3.0],
        over: vec![over("step_length", 0.1, 1.0, 19), over("torso_lean", -0.3, 0.8, 12)],
        ..MapOptions::default()
    };
    let found = map(&gait("robots/five_link", "thesis"), &options);
    let mut compared = 0;
    for one in &found.maps {
        for pair in one.next_speed.windows(2) {
            for (back, forward) in pair[0].iter().zip(&pair[1]) {
                if let (Some(back), Some(forward)) = (back, forward) {
                    assert!(forward > back, "{back} {forward}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 200, "{compared}");
    let passes: Vec<usize> = found.maps.iter().map(|one| one.counts["passes"]).collect();
    assert!(passes.windows(2).all(|pair| pair[0] < pair[1]), "{passes:?}");
}

/// A cell passes with assumptions if and only if it passes without and the margins of its step are none below zero.
#[test]
fn assumptions_are_the_margins_of_the_step() {
    let three = gait("robots/three_link", "thesis");
    let assume =
        Assumptions { friction: true, pull: true, torque: true, joints: true, ..Assumptions::default() };
    let options = MapOptions {
        over: vec![over("step_length", 0.3, 1.1, 4), over("torso_lean", -1.0, 0.0, 3)],
        assume,
        ..three_link(&[2.0], 2)
    };
    let found = map(&three, &options);
    let mut seen = std::collections::BTreeSet::new();
    for (row, b) in found.over[1].values.iter().enumerate() {
        for (column, a) in found.over[0].values.iter().enumerate() {
            let set = vec![("step_length".to_owned(), *a), ("torso_lean".to_owned(), *b)];
            let step = three.step(&StepOptions { speed: 2.0, set, ..StepOptions::default() }).unwrap().step;
            let bad = |margins: &[Option<f64>]| margins.iter().any(|margin| margin.is_none_or(|x| x < 0.0));
            let m = step.margins;
            let expected = match (&step.reason, bad(&[m.pull, m.impact_pull, m.lift_off])) {
                (Some(_), _) => "falls_back",
                (None, true) => "pulls",
                _ if bad(&[m.friction, m.impact_friction]) => "slips",
                _ if bad(&[m.torque]) => "torque",
                _ if m.joint.is_some_and(|joint| joint < 0.0) => "joint_stop",
                _ => "passes",
            };
            let code = found.reasons[found.maps[0].reason[row][column]].code();
            assert_eq!(code, expected, "{a} {b}: {m:?}");
            seen.insert(code);
        }
    }
    assert!(seen.len() >= 2, "{seen:?}");
    // The robot scuffs always (7.1).
    let scuffs = MapOptions { assume: Assumptions { clearance: true, ..Assumptions::default() }, ..options };
    assert!(!map(&three, &scuffs).maps[0].counts.contains_key("passes"));
}

#[test]
fn joints_keep_off_their_stops_where_it_is_asked() {
    let bench = gait("robots/three_link", "thesis");
    let assume = Assumptions { joints: true, ..Assumptions::default() };
    let (free, kept) = (three_link(&[1.5], 12), MapOptions { assume, ..three_link(&[1.5], 12) });
    let (free, kept) = (map(&bench, &free), map(&bench, &kept));
    let count = |map: &GaitMap, code: &str| map.maps[0].counts.get(code).copied().unwrap_or(0);
    let stopped = count(&kept, "joint_stop");
    assert!(stopped > 0, "{:?}", kept.maps[0].counts);
    assert_eq!(count(&free, "passes"), count(&kept, "passes") + stopped);
}

/// Writes to a file, and is asked to stop after so many questions.
fn until(bench: &GaitBench, options: &MapOptions, file: &Path, questions: usize) -> GaitMap {
    let asked = Cell::new(0);
    let stop = || {
        asked.set(asked.get() + 1);
        asked.get() > questions
    };
    bench.map(options, Some(file), &Run { progress: &Silent, stop: &stop }).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn an_interrupted_map_goes_on_to_the_same_bytes() {
    let (folder, bench) = (scratch("gait_map_resume"), gait("robots/three_link", "thesis"));
    let (whole, parts) = (folder.join("whole.csv"), folder.join("parts.csv"));
    let options = three_link(&[0.5, 2.0], 40);
    let uninterrupted = until(&bench, &options, &whole, usize::MAX);
    let first = until(&bench, &options, &parts, 3);
    assert!(!first.complete && uninterrupted.complete);
    let missing = |text: &str| text.lines().filter(|line| line.ends_with(",not computed")).count();
    let written = std::fs::read_to_string(&parts).unwrap();
    let left = missing(&written);
    assert!(left > 0 && left < 3200, "{left}");
    assert!(first.to_string().contains("interrupted"));
    assert!(first.maps[0].counts["not computed"] > 0);
    let last = until(&bench, &options, &parts, usize::MAX);
    assert_eq!(std::fs::read(&whole).unwrap(), std::fs::read(&parts).unwrap());
    assert_eq!(last, uninterrupted);
    assert_eq!(serde_json::to_string(&last).unwrap(), serde_json::to_string(&uninterrupted).unwrap());
}

#[test]
fn a_file_of_another_map_is_not_written_over() {
    let (folder, bench) = (scratch("gait_map_other"), gait("robots/three_link", "thesis"));
    let file = folder.join("map.csv");
    let options = three_link(&[1.0], 5);
    until(&bench, &options, &file, usize::MAX);
    let written = std::fs::read_to_string(&file).unwrap();
    let refused = |options: &MapOptions, words: &str| {
        let found = bench.map(options, Some(&file), &Run { progress: &Silent, stop: &|| false }).unwrap_err();
        assert!(found.to_string().contains(words), "{found}");
    };
    refused(&three_link(&[1.1], 5), "not a map of this robot");
    refused(&MapOptions { set: vec![("torso_lean".to_owned(), 0.1)], ..three_link(&[1.0], 5) }, "range");
    let damaged = [
        written.replacen("0.1,", "0.11,", 1),
        written.trim_end().rsplit_once('\n').unwrap().0.to_owned(),
        format!("{written}0,0,0,,passes\n"),
        written.replace(",falls_back", ",fell"),
        written.replacen(",passes", "x,passes", 1),
    ];
    for text in damaged {
        assert_ne!(text, written);
        std::fs::write(&file, &text).unwrap();
        let found =
            bench.map(&options, Some(&file), &Run { progress: &Silent, stop: &|| false }).unwrap_err();
        assert!(found.to_string().contains("map.csv"), "{found}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    }
}

#[cfg(unix)]
#[test]
#[ignore = "takes long"]
fn a_signal_ends_a_map_and_keeps_what_is_done() {
    let folder = scratch("gait_map_signal");
    let file = folder.join("map.csv");
    let grid = ["--over", "step_length=0.1:1:1500", "--over", "torso_lean=-0.6:1.2:1500"];
    let fixed = ["gait", "map", "robots/five_link", "--gait", "thesis", "--speed", "1", "--csv", text(&file)];
    let mut run = command(&[&fixed[..], &grid].concat());
    let mut child =
        run.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap();
    // Signals are listened to from the first answer on: before that they end the program at once.
    std::thread::sleep(std::time::Duration::from_secs(3));
    // Twice, as `timeout` does, which sends its signal to the program and to its group.
    let kill = || std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(kill().unwrap().success());
    std::thread::sleep(std::time::Duration::from_millis(20));
    // A program that has ended at once can still be sent signals, until it is waited for.
    assert!(kill().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let written = std::fs::read_to_string(&file).unwrap();
    assert_eq!(written.lines().count(), 2 + 1500 * 1500);
    assert!(written.contains(",not computed\n") && written.contains(",passes\n"));
}

fn cli(arguments: &[&str]) -> crate::cli::Run {
    bipedc(&[&["gait", "map", "robots/three_link", "--gait", "thesis"], arguments].concat())
}

const TWO: [&str; 4] = ["--over", "step_length=0.2:1:4", "--over", "torso_lean=-1:0.5:3"];

#[test]
fn wrong_maps_are_named() {
    let lean = "torso_lean=-1:0.5:3";
    let pairs = [
        ("step_lenght=0.2:1:4", "did you mean `step_length`?"),
        ("step_length=0.2:1:0", "at least 2"),
        ("step_length=0.2:1:1", "at least 2"),
        ("step_length=0.2:1:100000", "at most 2000"),
        ("step_length=NaN:1:4", "not possible"),
        ("step_length=0.2:inf:4", "not possible"),
        ("step_length=1:0.2:4", "the smaller end first"),
        ("step_length=1:1:4", "the smaller end first"),
        ("step_length=0.2:1e300:4", "too large"),
        ("torso_lean=0:1:4", "two ranges"),
    ];
    for (range, words) in pairs {
        cli(&["--speed", "1", "--over", range, "--over", lean]).fails_with(&[words, "help: "]);
    }
    for speed in ["0", "-1", "nan", "inf"] {
        let speed = format!("--speed={speed}");
        cli(&[&[speed.as_str()], &TWO[..]].concat()).fails_with(&["a speed of", "above 0, in rad/s"]);
    }
    cli(&["--speed", "1", "--over", lean]).fails_with(&["two ranges, not 1", "twice"]);
    cli(&[&["--speed", "1", "--over", "step_length=0:1:3"], &TWO[..]].concat()).fails_with(&["two ranges"]);
    cli(&[&["--speed", "1", "--set", "step_length=0.4"], &TWO[..]].concat())
        .fails_with(&["fixed and has a range"]);
    cli(&[&["--speed", "1", "--set", "knee=0.4"], &TWO[..]].concat()).fails_with(&["no parameter `knee`"]);
    let speeds: Vec<String> = (1..=3).map(|k| k.to_string()).collect();
    let huge =
        ["--speed", &speeds.join(","), "--over", "step_length=0:1:2000", "--over", "torso_lean=0:1:2000"];
    cli(&huge).fails_with(&["cells are too many", "fewer"]);
    for wrong in
        ["step_length", "step_length=1:2", "step_length=a:1:4", "step_length=0:1:2.5", "step_length=0:1:-3"]
    {
        assert_eq!(cli(&["--speed", "1", "--over", wrong, "--over", lean]).code, Some(2), "{wrong}");
    }
    assert_eq!(cli(&[&["--speed", "1", "--assume", "luck"], &TWO[..]].concat()).code, Some(2));
}

#[test]
fn outputs_may_not_be_inputs() {
    let gait_file = "robots/three_link/gaits/thesis.toml";
    for option in ["--csv", "--svg", "--page"] {
        cli(&[&["--speed", "1", option, gait_file], &TWO[..]].concat()).fails_with(&["the gait"]);
    }
}

#[test]
fn the_picture_and_the_page_are_whole_and_escaped() {
    let folder = scratch("gait_map_pictures");
    let (svg, page) = (folder.join("map.svg"), folder.join("map.html"));
    let files = ["--speed", "0.5", "1", "2", "--svg", text(&svg), "--page", text(&page)];
    cli(&[&files[..], &["--over", "step_length=0.1:1.4:20", "--over", "torso_lean=-2:2:20"]].concat()).ok();
    let picture = std::fs::read_to_string(&svg).unwrap();
    let document = Document::parse(&picture).unwrap();
    let count =
        |class: &str| document.descendants().filter(|node| node.attribute("class") == Some(class)).count();
    assert_eq!((count("raster"), count("line isocline")), (3, 4));
    assert_eq!((count("mark fastest"), count("mark slowest"), count("bounds")), (4, 4, 4));
    assert!(picture.contains("falls back before the dead centre") && picture.contains("step_length (m)"));
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("<h2 id=\"extremes\">") && !html.contains("http://127"), "{html}");
    assert!(html.matches("class=\"raster\"").count() == 3);
}

/// What a gait file calls itself is no markup.
#[test]
fn names_from_files_are_escaped() {
    let bench = super::files::open(
        "a<b&c",
        &super::files::changed("robots/three_link", "default = 0.5", "default = 0.5"),
    );
    let bench = bench.unwrap_or_else(|e| panic!("{e}"));
    let figure = map(&bench, &three_link(&[1.0], 4)).figure();
    let svg = bipedc_analysis::report::map_svg(&figure);
    Document::parse(&svg).unwrap();
    assert!(svg.contains("a&lt;b&amp;c") && !svg.contains("a<b"), "{svg}");
    assert!(!bipedc_analysis::report::render_map(&figure).contains("a<b&c"));
}

#[test]
fn the_keys_of_a_map() {
    let json = cli(&[&["--speed", "1", "2", "--json"], &TWO[..]].concat()).ok().json();
    assert_eq!(json["speed_unit"], "rad/s");
    assert_eq!(json["assume"], serde_json::json!(["step"]));
    assert_eq!((&json["complete"], json["maps"].as_array().unwrap().len()), (&serde_json::json!(true), 2));
    let one = &json["maps"][0];
    assert_eq!(
        (one["next_speed"].as_array().unwrap().len(), one["next_speed"][0].as_array().unwrap().len()),
        (3, 4)
    );
    let counts: u64 = one["counts"].as_object().unwrap().values().map(|x| x.as_u64().unwrap()).sum();
    assert_eq!(counts, 12);
    // Written to the output stream, the table is the output.
    let table = cli(&[&["--speed", "1", "--csv", "/dev/stdout"], &TWO[..]].concat());
    assert_eq!(table.code, Some(0), "{}", table.err);
}
