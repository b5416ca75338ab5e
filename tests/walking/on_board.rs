//! The crate of a controller: whole, checked, the same in Rust and in C.
use super::amended::{SOFT_ANKLE, amended, told as told_of};
use crate::cli::{bipedc, scratch, text};
use std::path::Path;
use std::process::Command;

/// What `generate --controller` writes is what `--check` wants; nobody's numbers are missing.
#[test]
fn the_crate_of_a_controller_is_whole() {
    let folder = scratch("walking-controller").join("tulip_controller");
    let asked = ["generate", "robots/tulip", "--controller", "--out", text(&folder)];
    bipedc(&asked).ok();
    bipedc(&[&asked[..], &["--check"]].concat()).ok();
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let (controller, header) = (read("src/walking.rs"), read("c/include/tulip_controller.h"));
    assert!(controller.contains("pub const JOINTS: usize = 12;") && header.contains("_JOINTS 12"));
    for name in
        ["src/walking.rs", "c/include/tulip_controller.h", "c/src/lib.rs", "c/example.c", "c/CMakeLists.txt"]
    {
        let file = read(name);
        assert!(file.contains("@generated"), "{name}");
        let left = ["@CRATE@", "@ROBOT@", "@JOINTS@", "@TYPE@", "@GUARD@", "@NAMES@", "@GAINS@", " inf"];
        assert!(left.iter().all(|mark| !file.contains(mark)), "{name}");
    }
    // The one that is committed is what is written today.
    bipedc(&["generate", "robots/tulip", "--controller", "--check"]).ok();
    // A robot without two flat feet has no such controller.
    let refused =
        bipedc(&["generate", "robots/five_link", "--controller", "--out", text(&folder.join("none"))]);
    assert!(refused.code == Some(1) && refused.err.contains("floating base"), "{}", refused.err);
}

fn printed(command: &mut Command) -> String {
    let run = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(run.status.success(), "{command:?}: {}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap()
}

#[test]
#[ignore = "builds crates; needs a C compiler"]
fn rust_and_c_print_the_same_torques() {
    let folder = scratch("walking-replayed");
    let [made, scenario, log, told, example] =
        ["tulip_controller", "walk.toml", "log.csv", "told.csv", "example"].map(|name| folder.join(name));
    // A joint behind a spring: there motors are read too.
    let known = amended("replayed", SOFT_ANKLE);
    bipedc(&["generate", text(&known), "--controller", "--out", text(&made)]).ok();
    let walk = std::fs::read_to_string("robots/tulip/scenarios/walk.toml").unwrap();
    let walk =
        walk.replace("duration = 16.0", "duration = 3.0").replace("log_step = 0.005", "log_step = 0.001");
    std::fs::write(&scenario, told_of(&walk, &known) + SOFT_ANKLE).unwrap();
    let simulate = ["simulate", "robots/tulip", "--scenario", text(&scenario), "--out", text(&log)];
    bipedc(&[&simulate[..], &["--told", text(&told)]].concat()).ok();
    let cargo = |at: &Path| {
        let mut command = Command::new(env!("CARGO"));
        command.current_dir(at).env("CARGO_TARGET_DIR", folder.join("target"));
        command
    };
    let of_rust =
        printed(cargo(&made).args(["run", "--quiet", "--release", "--example", "replay", "--", text(&told)]));
    printed(cargo(&made.join("c")).args(["build", "--quiet", "--release"]));
    let library = folder.join("target/release/libtulip_controller_c.a");
    let c = made.join("c");
    let (source, include) = (c.join("example.c"), c.join("include"));
    printed(Command::new("cc").args(["-O2", "-I", text(&include), text(&source), text(&library)]).args([
        "-lm",
        "-lpthread",
        "-ldl",
        "-o",
        text(&example),
    ]));
    let of_c = printed(Command::new(&example).arg(&told));
    assert!(of_rust.lines().count() == 3000 && of_rust == of_c);
    let apart = farthest_from_simulated(&of_c, &std::fs::read_to_string(&told).unwrap());
    println!("{apart:e} N m");
    assert!(apart < 1e-6, "{apart} N m");
}

/// Largest difference between printed torques and those that the simulation's controller asked for, N m: the crate fuses
/// multiplications and additions where the processor can.
fn farthest_from_simulated(printed: &str, told: &str) -> f64 {
    let mut rows = told.lines();
    let names: Vec<&str> = rows.next().unwrap().split(',').collect();
    let efforts: Vec<usize> = (0..names.len()).filter(|k| names[*k].ends_with("/effort")).collect();
    assert_eq!(efforts.len(), 12);
    let of_row = |(printed, row): (&str, &str)| {
        let cells: Vec<&str> = row.split(',').collect();
        let bits = printed.split(' ').map(|bits| f64::from_bits(u64::from_str_radix(bits, 16).unwrap()));
        let apart = bits.zip(&efforts).map(|(torque, k)| (torque - cells[*k].parse::<f64>().unwrap()).abs());
        apart.fold(0.0, f64::max)
    };
    printed.lines().zip(rows).map(of_row).fold(0.0, f64::max)
}

/// The class for ros2_control: whole, and of types that headers state. Nothing here has ROS.
#[test]
fn the_class_for_ros_compiles_against_what_it_needs() {
    if Command::new("g++").arg("--version").output().is_err() {
        eprintln!("skipped: there is no g++");
        return;
    }
    let folder = scratch("walking-ros").join("tulip_controller");
    bipedc(&["generate", "robots/tulip", "--controller", "--out", text(&folder)]).ok();
    let ros = folder.join("ros2_control");
    let read = |name: &str| std::fs::read_to_string(ros.join(name)).unwrap();
    for name in [
        "CMakeLists.txt",
        "package.xml",
        "plugin.xml",
        "src/controller.cpp",
        "include/tulip_controller_ros2_control/controller.hpp",
    ] {
        let file = read(name);
        assert!(file.to_lowercase().contains("never run on ros here"), "{name}");
        let left =
            ["@CRATE@", "@ROBOT@", "@JOINTS@", "@GUARD@", "@HEADER@", "@C_NAMES@", "@RIGHT@", "@LEFT@"];
        assert!(left.iter().all(|mark| !file.contains(mark)), "{name}");
    }
    for name in ["package.xml", "plugin.xml"] {
        roxmltree::Document::parse(&read(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    for values in ["-DOLDER_VALUES", "-DOPTIONAL_VALUES"] {
        printed(&mut ros_compiler(
            &folder,
            &["-fsyntax-only", values, text(&ros.join("src/controller.cpp"))],
        ));
    }
}

fn ros_compiler(made: &Path, more: &[&str]) -> Command {
    let mut compiler = Command::new("g++");
    compiler.args(["-std=c++17", "-O2", "-Wall", "-Wextra", "-Werror", "-Itests/walking/ros2_control/stubs"]);
    for include in ["ros2_control/include", "c/include"] {
        compiler.arg("-I").arg(made.join(include));
    }
    compiler.args(more);
    compiler
}

/// Called as a controller manager calls it, it asks for what the library for C asks for.
#[test]
#[ignore = "builds crates; needs a C++ compiler"]
fn the_class_for_ros_asks_for_the_same_torques() {
    let folder = scratch("walking-ros-called");
    let [made, scenario, log, called] =
        ["tulip_controller", "walk.toml", "log.csv", "called"].map(|name| folder.join(name));
    // A joint behind a spring: there motors are read too.
    let known = amended("called", SOFT_ANKLE);
    bipedc(&["generate", text(&known), "--controller", "--out", text(&made)]).ok();
    let walk = std::fs::read_to_string("robots/tulip/scenarios/walk.toml").unwrap();
    let walk =
        walk.replace("duration = 16.0", "duration = 3.0").replace("log_step = 0.005", "log_step = 0.001");
    std::fs::write(&scenario, told_of(&walk, &known) + SOFT_ANKLE).unwrap();
    bipedc(&["simulate", "robots/tulip", "--scenario", text(&scenario), "--out", text(&log)]).ok();
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(made.join("c")).env("CARGO_TARGET_DIR", folder.join("target"));
    printed(cargo.args(["build", "--quiet", "--release"]));
    let library = folder.join("target/release/libtulip_controller_c.a");
    let class = made.join("ros2_control/src/controller.cpp");
    let files = ["tests/walking/ros2_control/called.cpp", text(&class), text(&library)];
    for values in ["-DOLDER_VALUES", "-DOPTIONAL_VALUES"] {
        let ends = [values, "-lm", "-lpthread", "-ldl", "-o", text(&called)];
        printed(&mut ros_compiler(&made, &[&files[..], &ends].concat()));
        let said = printed(Command::new(&called).arg(&log));
        assert!(said.starts_with("3000 rows"), "{said}");
    }
}
