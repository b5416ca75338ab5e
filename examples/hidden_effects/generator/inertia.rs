//! Effects that are other numbers in the URDF: masses, centres of mass, inertias, and where down is.
use super::random::Random;
use super::{Failure, failure};
use bipedc_compiler::description::model::{Inertial, RobotDescription};
use bipedc_effects::effect::Effect;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Puts an effect into the description. `false` if it is none of mass, inertia or gravity.
///
/// # Errors
/// The link does not exist or has no inertia.
pub fn apply(description: &mut RobotDescription, effect: &Effect) -> Result<bool, Failure> {
    let xyz = || Vector3::new(effect.value("x"), effect.value("y"), effect.value("z"));
    match effect.kind.name {
        "payload" => add_point_mass(link(description, effect)?, effect.value("mass"), xyz()),
        "com_offset" => {
            let shift = xyz();
            let inertial = link(description, effect)?;
            (0..3).for_each(|i| inertial.origin.xyz[i] += shift[i]);
        }
        "inertia_error" => {
            let inertial = link(description, effect)?;
            to_link_axes(inertial);
            for (value, name) in inertial.inertia.iter_mut().zip(INERTIA) {
                *value += effect.value(name);
            }
        }
        "inertial_correction" => {
            let shift = xyz();
            let inertial = link(description, effect)?;
            to_link_axes(inertial);
            for (value, name) in inertial.inertia.iter_mut().zip(INERTIA) {
                *value += effect.value(name);
            }
            inertial.mass += effect.value("mass");
            (0..3).for_each(|i| inertial.origin.xyz[i] += shift[i]);
        }
        // The same in postures: the sole is the only orientation there is.
        "gravity_tilt" | "ground_slope" => {
            let turn = Rotation3::from_euler_angles(effect.value("roll"), effect.value("pitch"), 0.0);
            description.gravity = (turn.inverse() * Vector3::from(description.gravity)).into();
        }
        _ => return Ok(false),
    }
    Ok(true)
}

/// Order of the URDF.
const INERTIA: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];

fn link<'d>(description: &'d mut RobotDescription, effect: &Effect) -> Result<&'d mut Inertial, Failure> {
    let name = effect.location.link.as_deref().unwrap_or_default();
    let link = description.links.iter_mut().find(|link| link.name == name);
    link.and_then(|link| link.inertial.as_mut())
        .ok_or_else(|| failure(format!("no link `{name}` with inertia")))
}

/// `ixx, ixy, ixz, iyy, iyz, izz` as a matrix.
fn matrix([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// The six numbers of a symmetric matrix.
fn six(m: &Matrix3<f64>) -> [f64; 6] {
    [m[(0, 0)], m[(0, 1)], m[(0, 2)], m[(1, 1)], m[(1, 2)], m[(2, 2)]]
}

/// The inertia in the axes of the link instead of its own.
fn to_link_axes(inertial: &mut Inertial) {
    let [roll, pitch, yaw] = inertial.origin.rpy;
    let turn = Rotation3::from_euler_angles(roll, pitch, yaw);
    inertial.inertia = six(&(turn * matrix(inertial.inertia) * turn.inverse()));
    inertial.origin.rpy = [0.0; 3];
}

/// Inertia of a point mass about a point `d` away.
fn steiner(mass: f64, d: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * mass
}

/// Two bodies become one: Steiner's theorem about the common centre of mass.
fn add_point_mass(inertial: &mut Inertial, mass: f64, at: Vector3<f64>) {
    to_link_axes(inertial);
    let old = Vector3::from(inertial.origin.xyz);
    let total = inertial.mass + mass;
    let center = (old * inertial.mass + at * mass) / total;
    let inertia =
        matrix(inertial.inertia) + steiner(inertial.mass, old - center) + steiner(mass, at - center);
    *inertial = Inertial { mass: total, inertia: six(&inertia), ..*inertial };
    inertial.origin.xyz = center.into();
}

/// What CAD gets wrong: masses by 2 %, centres of mass by 2 mm in a robot of size 1, inertias by 3 % (standard deviations).
pub fn cad_errors(description: &mut RobotDescription, size: f64, random: &mut Random) {
    for inertial in description.links.iter_mut().filter_map(|link| link.inertial.as_mut()) {
        inertial.mass *= 1.0 + 0.02 * random.normal();
        inertial.origin.xyz.iter_mut().for_each(|x| *x += 0.002 * size * random.normal());
        let scale = 1.0 + 0.03 * random.normal();
        inertial.inertia.iter_mut().for_each(|i| *i *= scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_point_masses_have_the_inertia_of_a_dumbbell() {
        let mut inertial = Inertial { mass: 2.0, origin: Default::default(), inertia: [0.0; 6] };
        add_point_mass(&mut inertial, 2.0, Vector3::new(0.0, 0.0, 1.0));
        assert_eq!((inertial.mass, inertial.origin.xyz), (4.0, [0.0, 0.0, 0.5]));
        assert_eq!(inertial.inertia, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    }
}
