//! The links in their bodies, for tools that change or estimate inertial parameters.
use bipedc_analysis::robot::link_inertias::{Link, LinkInertias};
use bipedc_compiler::description::model::{self, Inertial, RobotDescription};
use bipedc_compiler::tree::{Placement, Rotation, Tree};

/// All links with the bodies that they belong to, bodies in the order of the inertial parameters.
///
/// The virtual bodies of a planar base have parameters too (that play no part), so they are counted.
pub fn link_inertias(description: &RobotDescription, tree: &Tree) -> LinkInertias {
    let mut link_inertias = LinkInertias {
        links: Vec::new(),
        bodies: tree.bodies.iter().map(|body| body.name.clone()).collect(),
    };
    for link in &description.links {
        let Some(frame) = tree.frame(&link.name) else { continue };
        // Links of the world have no parameters.
        let Some(body) = frame.body else { continue };
        let placement: Placement = tree.bodies[body].main_link.inverse().then(&frame.placement);
        link_inertias.links.push(Link {
            body,
            rotation: placement.rotation.matrix(),
            translation: placement.translation,
            ..by_itself(link)
        });
    }
    link_inertias
}

/// A link by itself, in its own axes.
pub fn by_itself(link: &model::Link) -> Link {
    let none = Inertial { mass: 0.0, origin: Default::default(), inertia: [0.0; 6] };
    let inertial = link.inertial.unwrap_or(none);
    Link {
        name: link.name.clone(),
        body: 0,
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
        mass: inertial.mass,
        center: inertial.origin.xyz,
        inertia: about_center(&inertial),
    }
}

/// The inertia about the centre of mass in link axes.
pub fn about_center(inertial: &Inertial) -> [[f64; 3]; 3] {
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let given = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let r = Rotation::from_rpy(inertial.origin.rpy).matrix();
    let half = |i: usize, k: usize| (0..3).map(|l| given[k][l] * r[i][l]).sum::<f64>();
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| r[j][k] * half(i, k)).sum()))
}
