//! Feet on the ground: corner forces and what pressure sensors make of them.
use bipedc_compiler::description::model::RobotDescription;
use bipedc_effects::effect::Effect;
use nalgebra::{DMatrix, DVector, Vector3};

/// A parameter of the first effect of this kind.
pub fn value(effects: &[Effect], kind: &str, parameter: &str) -> Option<f64> {
    effects.iter().find(|effect| effect.kind.name == kind).map(|effect| effect.value(parameter))
}

/// One corner of a sole.
#[derive(Debug, Clone, PartialEq)]
pub struct Corner {
    /// `left_foot`
    pub foot: String,
    /// `left_foot/front_left`
    pub name: String,
    /// In the foot's link, m.
    pub position: Vector3<f64>,
}

/// The corners of both feet, in the order of the description: that of the model's forces.
pub fn corners(description: &RobotDescription) -> Vec<Corner> {
    let feet = description.feet.iter();
    feet.flat_map(|foot| {
        foot.points.iter().map(|point| Corner {
            foot: foot.name.clone(),
            name: format!("{}/{}", foot.name, point.name),
            position: Vector3::from(point.position),
        })
    })
    .collect()
}

/// Forces at points that make up a force and a moment about the origin: the smallest with these weights (a point
/// of weight 0 has none). Three per point.
pub fn spread(
    points: &[Vector3<f64>],
    weights: &[f64],
    force: Vector3<f64>,
    moment: Vector3<f64>,
) -> Vec<f64> {
    let n = points.len();
    let wrench = DVector::from_iterator(6, force.iter().chain(moment.iter()).copied());
    let grasp = DMatrix::from_fn(6, 3 * n, |row, column| {
        let (point, axis) = (column / 3, column % 3);
        let mut unit = Vector3::zeros();
        unit[axis] = 1.0;
        if row < 3 { unit[row] } else { points[point].cross(&unit)[row - 3] }
    });
    let weighted = DMatrix::from_fn(3 * n, 6, |row, column| weights[row / 3] * grasp[(column, row)]);
    let normal = &grasp * &weighted;
    normal.lu().solve(&wrench).map_or(vec![0.0; 3 * n], |x| (weighted * x).as_slice().to_vec())
}

/// A reading of a sensor: of the whole foot or of one corner.
pub fn reading(effects: &[Effect], foot: &str, corner: &str, force: Vector3<f64>) -> Vector3<f64> {
    let mut force = force;
    for effect in effects {
        let whole = effect.location.sensor.as_deref();
        if !(whole.is_none() || whole == Some(foot) || whole == Some(corner)) {
            continue;
        }
        match effect.kind.name {
            "force_sensor_gain" => force *= effect.value("gain"),
            "force_sensor_bias" => {
                force += Vector3::new(effect.value("x"), effect.value("y"), effect.value("z"))
            }
            "force_sensor_saturation" => force.z = force.z.min(effect.value("limit")),
            _ => {}
        }
    }
    force
}
