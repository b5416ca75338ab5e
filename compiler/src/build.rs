//! For build scripts: a robot's code in Cargo's output folder.
use crate::compile::crate_name;
use crate::description::SourceFiles;
use crate::emit::{Text, documentation, ident, robot_type, type_name};
use crate::front::{ATTRIBUTES, Request, items_for};
use bipedc_effects::diagnostic::Diagnostics;
use bipedc_effects::files::write_with_folders;
use std::path::{Path, PathBuf};

/// Compiles a robot from a build script: its folder, its `biped.toml` or a URDF, relative to `Cargo.toml`.
///
/// Writes `$OUT_DIR/<name>.rs`, where `<name>` is the robot's, holding a module `<name>` with the robot's
/// functions, constants and a type that implements `bipedc_runtime::Model`. The script runs again when the
/// files change. With everything wrong on standard error, it ends the script with failure.
///
/// ```no_run
/// // build.rs
/// bipedc_compiler::build::robot("robots/tulip");
/// ```
///
/// ```ignore
/// // src/lib.rs
/// include!(concat!(env!("OUT_DIR"), "/tulip.rs"));
/// let torques = tulip::inverse_dynamics(&q, &v, &a);
/// ```
///
/// # Panics
/// Outside of a build script, where Cargo gives no output folder.
pub fn robot(path: impl AsRef<Path>) {
    robot_as(path, &Request::default());
}

/// The same with another base or other functions than the description says.
///
/// # Panics
/// As [`robot`].
pub fn robot_as(path: impl AsRef<Path>, request: &Request) {
    let out = std::env::var_os("OUT_DIR").expect("Cargo sets OUT_DIR for build scripts");
    match write(path.as_ref(), request, Path::new(&out)) {
        Ok(written) => {
            for file in &written.sources {
                println!("cargo::rerun-if-changed={}", file.display());
            }
        }
        Err(error) => {
            // A script that fails runs again in any case.
            eprintln!("{error}");
            std::process::exit(1);
        }
    }
}

/// What [`write()`] read and wrote.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The file with the code.
    pub file: PathBuf,
    /// The files it depends on.
    pub sources: Vec<PathBuf>,
}

/// Compiles a robot and writes `<name>.rs` into `folder`, whole or not at all.
///
/// # Errors
/// Everything wrong with the description, or what the file system refuses.
pub fn write(path: &Path, request: &Request, folder: &Path) -> Result<Written, Diagnostics> {
    let files = SourceFiles::load(path)?;
    let mut sources = vec![files.urdf_path.clone(), files.toml_path.clone()];
    sources.dedup();
    let (name, text, gait) = code(files, request)?;
    sources.extend(gait);
    let file = folder.join(format!("{name}.rs"));
    write_with_folders(&file, &text).map_err(|error| Diagnostics(vec![error]))?;
    Ok(Written { file, sources })
}

/// Name and text of the module, and the gait's file.
fn code(files: SourceFiles, request: &Request) -> Result<(String, String, Option<PathBuf>), Diagnostics> {
    let robot = request.robot(files)?;
    let compiled = robot.compile()?;
    let gait = request.gait(&robot)?;
    let name = crate_name(&compiled.name);
    let type_name = type_name(&name);
    let mut text = Text::default();
    text.lines(ATTRIBUTES);
    text.open(&format!("pub mod {} {{", ident(&name)));
    documentation(&compiled, &mut text);
    text.line("");
    text.lines(&robot_type(&compiled, &type_name));
    text.lines(&items_for(&compiled, &type_name, request));
    gait.iter().for_each(|(code, _)| text.lines(&code.inline()));
    text.close("}");
    Ok((name, text.finish(), gait.map(|(_, file)| file)))
}
