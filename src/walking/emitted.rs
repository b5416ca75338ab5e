//! A crate with the controller of a robot that walks on flat feet: `no_std` Rust, a library for C around it, examples.
use super::legs::Legs;
use super::onboard::FootstepWalker;
use bipedc_compiler::compile::crate_name;
use bipedc_compiler::emit::{Package, Runtime, type_name};
use bipedc_effects::diagnostic::Diagnostic;

/// Files of the crate, with names of the robot to be filled in.
const FILES: [(&str, &str); 11] = [
    ("src/walking.rs", include_str!("emitted/walking.rs.txt")),
    ("examples/replay.rs", include_str!("emitted/replay.rs.txt")),
    ("c/src/lib.rs", include_str!("emitted/c_lib.rs.txt")),
    ("c/include/@CRATE@.h", include_str!("emitted/header.h.txt")),
    ("c/example.c", include_str!("emitted/example.c.txt")),
    ("c/CMakeLists.txt", include_str!("emitted/CMakeLists.txt.txt")),
    ("ros2_control/CMakeLists.txt", include_str!("emitted/ros2_control/CMakeLists.txt.txt")),
    ("ros2_control/package.xml", include_str!("emitted/ros2_control/package.xml.txt")),
    ("ros2_control/plugin.xml", include_str!("emitted/ros2_control/plugin.xml.txt")),
    (
        "ros2_control/include/@CRATE@_ros2_control/controller.hpp",
        include_str!("emitted/ros2_control/controller.hpp.txt"),
    ),
    ("ros2_control/src/controller.cpp", include_str!("emitted/ros2_control/controller.cpp.txt")),
];

/// Writes the crate: `source` is where the robot comes from, such as `robots/tulip`.
///
/// # Errors
/// A robot that does not walk; functions that cannot be derived.
pub fn controller_crate(legs: &Legs, source: &str, runtime: Runtime) -> Result<Package, Diagnostic> {
    let walker = FootstepWalker::new(legs)?;
    let (model, ..) = walker.parts();
    let mut compiled = model.compiled().clone();
    compiled.name = format!("{}_controller", compiled.name);
    let mut package = legs.robot.package_of(&compiled, None, source, runtime);
    let refresh = format!("refresh: bipedc generate {source}");
    package
        .files
        .values_mut()
        .for_each(|text| *text = text.replace(&refresh, &format!("{refresh} --controller")));
    let header = package.files.get("src/lib.rs").map_or("", |text| text.split("\n\n").next().unwrap_or(""));
    let header = header.to_owned();
    let names = Names::of(legs, &walker, &crate_name(&compiled.name));
    if let Some(root) = package.files.get_mut("src/lib.rs") {
        root.push_str("#[rustfmt::skip] pub mod walking;\n");
    }
    for (path, text) in FILES {
        let text = match path.rsplit_once('.') {
            Some((_, "rs")) => format!("{header}\n\n{}", names.fill(text)),
            // XML begins with its version.
            Some((_, "xml")) => names.fill(text).replace("@HEADER@", &xml_comment(&header)),
            Some((_, "txt")) => format!("{}\n{}", header.replace("// ", "# "), names.fill(text)),
            _ => format!(
                "{}\n{}",
                header.replace("// ", "/* ").replace('\n', " */\n") + " */",
                names.fill(text)
            ),
        };
        package.files.insert(names.fill(path), text);
    }
    package.files.insert("c/Cargo.toml".to_owned(), names.fill(&manifest(&header)));
    Ok(package)
}

fn xml_comment(header: &str) -> String {
    // Two hyphens end a comment.
    let line = |line: &str| format!("<!-- {} -->", line.trim_start_matches("// ").replace("--", "with its "));
    header.lines().map(line).collect::<Vec<_>>().join("\n")
}

fn manifest(header: &str) -> String {
    let header = header.replace("// ", "# ");
    format!(
        "{header}\n[package]\nname = \"@PACKAGE@-c\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
         [lib]\nname = \"@CRATE@_c\"\ncrate-type = [\"staticlib\", \"cdylib\"]\n\n\
         [dependencies]\n@PACKAGE@ = {{ path = \"..\" }}\n\n[workspace]\n"
    )
}

/// What stands for what in the files.
struct Names(Vec<(&'static str, String)>);

impl Names {
    fn of(legs: &Legs, walker: &FootstepWalker, name: &str) -> Self {
        let (_, robot, gains) = walker.parts();
        let joints: Vec<&str> = legs.joints.iter().map(|joint| joint.name.as_str()).collect();
        let list: Vec<String> =
            joints.iter().enumerate().map(|(k, joint)| format!("     {k} {joint}")).collect();
        let quoted: Vec<String> = joints.iter().map(|joint| format!("{joint:?}")).collect();
        Self(vec![
            ("@ROBOT@", legs.robot.description.name.clone()),
            ("@CRATE@", name.to_owned()),
            ("@PACKAGE@", name.replace('_', "-")),
            ("@GUARD@", name.to_uppercase()),
            ("@TYPE@", type_name(name)),
            ("@JOINTS@", joints.len().to_string()),
            ("@NAMES@", literal(&format!("{joints:?}"))),
            ("@C_NAMES@", quoted.join(", ")),
            ("@JOINT_LIST@", list.join("\n")),
            ("@RIGHT@", legs.feet[0].clone()),
            ("@LEFT@", legs.feet[1].clone()),
            ("@WALKING_ROBOT@", literal(&format!("{robot:?}"))),
            ("@GAINS@", literal(&format!("{gains:?}"))),
            ("@SETTINGS@", literal(&format!("{:?}", walker.estimator()))),
        ])
    }

    fn fill(&self, text: &str) -> String {
        self.0.iter().fold(text.to_owned(), |text, (name, value)| text.replace(name, value))
    }
}

/// Longest line of a value.
const WIDTH: usize = 116;

/// Rust prints its values as Rust, but for infinity and the ends of lines.
fn literal(printed: &str) -> String {
    let printed = printed.replace(" inf", " f64::INFINITY").replace("[inf", "[f64::INFINITY");
    let mut lines = vec![String::new()];
    for word in printed.split_inclusive(", ") {
        let line = lines.last_mut().expect("there is a first line");
        if line.len() + word.trim_end().len() <= WIDTH {
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    if lines.len() == 1 {
        return printed;
    }
    lines.iter().map(|line| format!("\n    {}", line.trim_end())).collect()
}
