//! Where generated crates go, what they are called after and where they find the runtime.
use bipedc_runtime::diagnostic::Diagnostic;
use std::path::{Component, Path, PathBuf, absolute};

/// The name of a robot's folder, for the default of `--out`.
pub fn folder_name(robot: &Path) -> String {
    let folder = if robot.is_dir() { Some(robot) } else { robot.parent() };
    let folder = folder.and_then(|folder| {
        std::fs::canonicalize(if folder.as_os_str().is_empty() { Path::new(".") } else { folder }).ok()
    });
    let name = folder.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    name.unwrap_or_else(|| "robot".to_owned())
}

/// What headers of generated files call the robot: the same on every machine, so relative and with forward
/// slashes. Of an absolute path the last two components remain.
pub fn source_name(robot: &Path) -> String {
    let names = robot.components().filter_map(|component| match component {
        Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
        Component::ParentDir => Some("..".to_owned()),
        _ => None,
    });
    let names: Vec<String> = names.collect();
    let skipped = if robot.is_absolute() { names.len().saturating_sub(2) } else { 0 };
    let name = names[skipped..].join("/");
    // The name stands in a comment and in a TOML comment: one line.
    let name: String = name.chars().map(|c| if c.is_control() { '_' } else { c }).collect();
    if name.is_empty() { ".".to_owned() } else { name }
}

/// The manifest's dependency on the runtime.
///
/// `given` is a path (from here) or a version; without it, the runtime of the repository that we stand in or
/// write into, else the version of this compiler.
///
/// # Errors
/// A path without the crate.
pub fn runtime_dependency(given: Option<&str>, out: &Path) -> Result<String, Diagnostic> {
    match given {
        Some(text) if is_version(text) => Ok(format!("version = \"{text}\"")),
        Some(text) => {
            let path = Path::new(text);
            if !is_runtime(path) {
                return Err(Diagnostic::error("there is no crate `bipedc-runtime`")
                    .in_file(path)
                    .help("--runtime takes the folder of that crate, or a version such as 0.1.0"));
            }
            dependency_on(path, out)
        }
        None => match [Path::new("."), out].into_iter().find_map(runtime_above) {
            Some(path) => dependency_on(&path, out),
            None => Ok(format!("version = \"{}\"", env!("CARGO_PKG_VERSION"))),
        },
    }
}

fn is_version(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_digit())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || ".-+".contains(c))
}

fn is_runtime(folder: &Path) -> bool {
    std::fs::read_to_string(folder.join("Cargo.toml"))
        .is_ok_and(|text| text.lines().any(|line| line.trim() == "name = \"bipedc-runtime\""))
}

fn runtime_above(folder: &Path) -> Option<PathBuf> {
    let folder = absolute(folder).ok()?;
    folder.ancestors().map(|ancestor| ancestor.join("runtime")).find(|path| is_runtime(path))
}

fn dependency_on(runtime: &Path, out: &Path) -> Result<String, Diagnostic> {
    let path = resolved(runtime).and_then(|to| Ok(relative(&resolved(out)?, &to)));
    let path = path.map_err(|error| Diagnostic::error(error.to_string()).in_file(runtime))?;
    let text = path.to_string_lossy().replace('\\', "/");
    Ok(format!("path = \"{}\"", text.replace('"', "\\\"")))
}

/// Absolute, without links as far as it exists.
fn resolved(path: &Path) -> std::io::Result<PathBuf> {
    let path = absolute(path)?;
    for ancestor in path.ancestors() {
        if let (Ok(real), Ok(rest)) = (ancestor.canonicalize(), path.strip_prefix(ancestor)) {
            return Ok(real.join(rest));
        }
    }
    Ok(path)
}

/// From one folder to another; both absolute.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let (from, to): (Vec<_>, Vec<_>) = (from.components().collect(), to.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from[shared..].iter().map(|_| Component::ParentDir);
    up.chain(to[shared..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_the_same_on_every_machine() {
        assert_eq!(source_name(Path::new("./robots/tulip/")), "robots/tulip");
        assert_eq!(source_name(Path::new("/home/somebody/robots/tulip")), "robots/tulip");
        assert_eq!(source_name(Path::new("../a/robot.urdf")), "../a/robot.urdf");
        assert_eq!(source_name(Path::new(".")), ".");
    }

    #[test]
    fn relative_paths_lead_there() {
        let path = relative(Path::new("/a/generated/tulip"), Path::new("/a/runtime"));
        assert_eq!(path, Path::new("../../runtime"));
    }

    #[test]
    fn versions_are_no_paths() {
        assert!(is_version("0.1.0") && is_version("1.2.0-rc.1"));
        assert!(!is_version("../runtime") && !is_version("runtime"));
    }
}
