//! Where the meshes are that a URDF names.
use std::env;
use std::path::{Path, PathBuf};

/// The file of a mesh named in a URDF in this folder, if there is one.
pub fn mesh_file(folder: &Path, name: &str) -> Option<PathBuf> {
    places(folder, name).into_iter().find(|path| path.is_file())
}

/// Where a mesh may be: as ROS finds packages, and beside the URDF.
fn places(folder: &Path, name: &str) -> Vec<PathBuf> {
    if let Some(path) = name.strip_prefix("file://") {
        return vec![PathBuf::from(path)];
    }
    let Some(name) = ["package://", "model://"].iter().find_map(|scheme| name.strip_prefix(scheme)) else {
        return vec![folder.join(name)];
    };
    let Some((package, rest)) = name.split_once('/') else { return Vec::new() };
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let mut places = Vec::new();
    for above in folder.ancestors() {
        if above.file_name().is_some_and(|name| name == package) {
            places.push(above.join(rest));
        }
        places.push(above.join(package).join(rest));
    }
    let paths =
        |variable: &str| env::var_os(variable).map(|list| env::split_paths(&list).collect::<Vec<_>>());
    places.extend(paths("ROS_PACKAGE_PATH").into_iter().flatten().map(|path| path.join(package).join(rest)));
    let share = |path: PathBuf| path.join("share").join(package).join(rest);
    places.extend(paths("AMENT_PREFIX_PATH").into_iter().flatten().map(share));
    places
}
