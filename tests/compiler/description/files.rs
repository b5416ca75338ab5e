//! Reading a robot's files from disk: where they are looked for, and what is said when they are not there.
use bipedc_compiler::description::{SourceFiles, init, read};
use std::fs;
use std::path::{Path, PathBuf};

const URDF: &str = include_str!("../../../robots/three_link/robot.urdf");

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn a_folder_its_description_or_a_bare_urdf() {
    let folder = folder("a_folder");
    fs::write(folder.join("robot.urdf"), URDF).unwrap();
    fs::write(folder.join("biped.toml"), "name = \"walker\"\n").unwrap();
    assert_eq!(read(&folder).unwrap().0.name, "walker");
    assert_eq!(read(&folder.join("biped.toml")).unwrap().0.name, "walker");
    assert_eq!(read(&folder.join("robot.urdf")).unwrap().0.name, "three_link");
}

#[test]
fn the_description_may_name_its_urdf() {
    let folder = folder("named_urdf");
    fs::write(folder.join("other.urdf"), URDF).unwrap();
    fs::write(folder.join("biped.toml"), "urdf = \"other.urdf\"\n").unwrap();
    let files = SourceFiles::load(&folder).unwrap();
    assert_eq!(files.urdf_path, folder.join("other.urdf"));
    assert_eq!((files.urdf_text.as_str(), files.toml_text.as_str()), (URDF, "urdf = \"other.urdf\"\n"));
    assert!(files.parse().is_ok());
    // The guess for a URDF with another name than usual says that name.
    assert!(init(&folder.join("other.urdf")).unwrap().contains("urdf = \"other.urdf\"\n"));
}

#[test]
fn missing_files_are_named() {
    let folder = folder("missing");
    let message = read(&folder).unwrap_err().to_string();
    assert!(message.starts_with("error: cannot read the file: "), "{message}");
    assert!(message.contains("biped.toml") && message.contains("bipedc init"), "{message}");
    fs::write(folder.join("biped.toml"), "").unwrap();
    let message = read(&folder).unwrap_err().to_string();
    assert!(message.contains("robot.urdf\nhelp:"), "{message}");
}

#[test]
fn files_that_are_not_text() {
    let folder = folder("not_text");
    fs::write(folder.join("robot.urdf"), b"<robot name='\xe4'/>").unwrap();
    let message = read(&folder.join("robot.urdf")).unwrap_err().to_string();
    assert!(message.starts_with("error: the file is not UTF-8 text (byte 13)\n"), "{message}");
}
