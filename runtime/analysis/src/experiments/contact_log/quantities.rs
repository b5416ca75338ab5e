//! Quantities that a report shows beside the rows.
use super::ContactExperiment;
use super::rows::Ground;
use bipedc_effects::effect::Effect;
use nalgebra::Vector3;

/// A foot carries load from this part of the weight on.
const LOADED: f64 = 0.2;

/// A quantity over the samples of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Such as `cop/x` or `right_foot/sole/tilt`.
    pub name: String,
    /// SI.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// One per sample; NaN where it does not exist.
    pub values: Vec<f64>,
}

impl Quantity {
    /// Root mean square over the samples where it exists; 0 if there are none.
    pub fn rms(&self) -> f64 {
        let finite = self.values.iter().filter(|v| v.is_finite());
        let (sum, count) = finite.fold((0.0, 0_usize), |(sum, count), v| (sum + v * v, count + 1));
        (sum / count.max(1) as f64).sqrt()
    }
}

impl ContactExperiment<'_> {
    /// Errors of the centre of pressure of all feet against the zero moment point and against the ground projection
    /// of the centre of mass (m, world axes), and for each foot how far its sole is from level (rad) and how high (m)
    /// while it carries load, as base and joints tell; all under these effects besides the description's.
    pub fn quantities(&self, effects: &[Effect]) -> Vec<Quantity> {
        let change = self.change(effects);
        let quantity = |name: String, unit, meaning| Quantity { name, unit, meaning, values: Vec::new() };
        let mut out = Vec::new();
        for (what, meaning) in [
            ("cop", "centre of pressure minus zero moment point"),
            ("cop_static", "centre of pressure minus ground projection of the centre of mass"),
        ] {
            out.extend(["x", "y"].map(|axis| quantity(format!("{what}/{axis}"), "m", meaning)));
        }
        for foot in self.robot.feet {
            out.push(quantity(
                format!("{}/sole/tilt", foot.name),
                "rad",
                "angle between loaded sole and level",
            ));
            out.push(quantity(format!("{}/sole/height", foot.name), "m", "height of the loaded sole"));
        }
        let center = self.calls.find("center_of_mass").ok();
        let weight = self.parameters.mass() * self.gravity.norm();
        for i in 0..self.samples() {
            let reported = self.reported(i, &change);
            let ground = self.ground(i, &change);
            let loaded = reported.force.z > LOADED * weight;
            let values = if loaded { self.centers(i, &change, &ground, center) } else { [f64::NAN; 4] };
            out.iter_mut().zip(values).for_each(|(q, value)| q.values.push(value));
            let [q, ..] = self.kinematics(i, &change);
            let level = change.world.tilt.transpose() * Vector3::z();
            for (f, foot) in self.robot.feet.iter().enumerate() {
                let record = &self.recording.feet[f];
                let loaded = record.is_logged && record.signals[i][2] > LOADED * weight;
                let sole = self.feet[f].sole(&self.calls, foot, &q);
                let normal = sole.rotation.column(2).into_owned();
                let tilt = normal.cross(&level).norm().atan2(normal.dot(&level));
                let values = if loaded { [tilt, sole.origin.z] } else { [f64::NAN; 2] };
                out[4 + 2 * f].values.push(values[0]);
                out[5 + 2 * f].values.push(values[1]);
            }
        }
        for quantity in &mut out {
            quantity.values = self.recording.pick(&quantity.values);
        }
        out
    }

    /// Centre of pressure minus zero moment point, and minus the centre of mass.
    fn centers(&self, i: usize, change: &super::Change, ground: &Ground, center: Option<usize>) -> [f64; 4] {
        let measured = ground.pressure(&self.reported(i, change));
        let needed = ground.pressure(&self.needed(&self.moved_state(i, change), change));
        let mut mass = [f64::NAN; 3];
        if let Some(function) = center {
            let [q, ..] = self.kinematics(i, change);
            self.calls.at(function, &q, &mut mass);
        }
        [measured[0] - needed[0], measured[1] - needed[1], measured[0] - mass[0], measured[1] - mass[1]]
    }
}
