//! What links look like whose shape is a mesh: the convex hull of a few dozen of its vertices.
use super::hull::hull;
use bipedc_analysis::report::Form;
use bipedc_compiler::description::mesh_file;
use mesh_loader::Loader;
use std::path::Path;

/// Larger files are not read, bytes.
const LARGEST: u64 = 256 << 20;
/// A hull is made of the farthest vertices in the directions between these many steps along each axis of a cube.
const STEPS: i32 = 2;

/// The hull of a mesh named in a URDF in this folder; `None`: it is not found, cannot be read or is flat.
pub(super) fn mesh(folder: &Path, name: &str, scale: [f64; 3]) -> Option<Form> {
    let path = mesh_file(folder, name)?;
    if path.metadata().ok()?.len() > LARGEST {
        return None;
    }
    let scene = Loader::default().load(path).ok()?;
    let vertices = scene.meshes.iter().flat_map(|mesh| &mesh.vertices);
    let scaled = vertices.map(|v| [0, 1, 2].map(|k| scale[k] * f64::from(v[k])));
    hull(&farthest(scaled.filter(|v| v.iter().all(|x| x.is_finite()))))
}

/// The farthest points in directions all around, each once.
fn farthest(points: impl Iterator<Item = [f64; 3]>) -> Vec<[f64; 3]> {
    let steps = -STEPS..=STEPS;
    let all = steps.clone().flat_map(|x| steps.clone().map(move |y| (x, y)));
    let all = all.flat_map(|(x, y)| steps.clone().map(move |z| [x, y, z]));
    // On the surface of the cube; what lies within has the same directions.
    let directions: Vec<[f64; 3]> =
        all.filter(|d| d.iter().any(|x| x.abs() == STEPS)).map(|d| d.map(f64::from)).collect();
    let mut best = vec![(f64::NEG_INFINITY, [0.0; 3]); directions.len()];
    for point in points {
        for (best, direction) in best.iter_mut().zip(&directions) {
            let reach = (0..3).map(|k| direction[k] * point[k]).sum();
            if reach > best.0 {
                *best = (reach, point);
            }
        }
    }
    let mut found: Vec<[f64; 3]> = Vec::new();
    for (_, point) in best.into_iter().filter(|(reach, _)| reach.is_finite()) {
        if !found.contains(&point) {
            found.push(point);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{env, fs};

    const TETRAHEDRON: &str = "solid t
facet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet
facet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet
facet normal -1 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet
facet normal 1 1 1\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet
endsolid t\n";

    #[test]
    fn meshes_are_found_and_scaled() {
        let root = env::temp_dir().join(format!("bipedc-meshes-{}", std::process::id()));
        let (urdf, meshes) = (root.join("biped_description/urdf"), root.join("biped_description/meshes"));
        fs::create_dir_all(&urdf).unwrap();
        fs::create_dir_all(&meshes).unwrap();
        fs::write(meshes.join("t.stl"), TETRAHEDRON).unwrap();
        fs::write(meshes.join("broken.stl"), &TETRAHEDRON[..70]).unwrap();
        fs::write(meshes.join("broken.dae"), "<COLLADA").unwrap();
        let found = |name: &str| mesh(&urdf, name, [1.0, 2.0, 3.0]);
        for name in ["package://biped_description/meshes/t.stl", "../meshes/t.stl"] {
            let Some(Form::Solid { corners, faces }) = found(name) else { panic!("{name} is not found") };
            assert_eq!((corners.len(), faces.len()), (4, 4));
            assert!(corners.contains(&[0.0, 2.0, 0.0]) && corners.contains(&[0.0, 0.0, 3.0]));
        }
        for name in
            ["../meshes/no.stl", "package://other/t.stl", "../meshes/broken.stl", "../meshes/broken.dae"]
        {
            assert!(found(name).is_none(), "{name}");
        }
        fs::remove_dir_all(&root).unwrap();
    }
}
