//! A plan as a table: a log that has not happened yet.
use super::Plan;
use super::kinematics::root_rotation;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::Output;
use nalgebra::Vector3;
use std::fmt::Write;
use std::path::Path;

const AXES: [&str; 3] = ["x", "y", "z"];

impl Plan {
    /// Names of the columns, as in logs (`docs/logs.md`) and, of what only a plan has, as in `docs/walking.md`.
    pub fn columns(&self) -> Vec<String> {
        let mut names = vec!["time".to_owned()];
        for joint in &self.legs.joints {
            names.extend(
                ["position", "velocity", "acceleration", "effort"]
                    .map(|what| format!("{}/{what}", joint.name)),
            );
        }
        let mut of =
            |what: &str, axes: &[&str]| names.extend(axes.iter().map(|axis| format!("{what}/{axis}")));
        of("base/position", &AXES);
        of("base/orientation", &["x", "y", "z", "w"]);
        for what in ["linear_velocity", "angular_velocity", "linear_acceleration", "angular_acceleration"] {
            of(&format!("base/{what}"), &AXES);
        }
        for what in ["center_of_mass", "center_of_mass_velocity", "center_of_mass_acceleration"] {
            of(what, &AXES);
        }
        of("zero_moment_point", &AXES[..2]);
        of("divergent_component", &AXES[..2]);
        for foot in &self.legs.feet {
            of(&format!("{foot}/sole"), &["x", "y", "z", "yaw"]);
            of(&format!("{foot}/force"), &AXES);
            of(foot, &["contact"]);
        }
        of("zero_moment_point", &["margin"]);
        of("plan", &["step", "phase"]);
        names
    }

    /// Writes the plan: it appears whole or not at all.
    ///
    /// # Errors
    /// What the file system refuses.
    pub fn write(&self, path: &Path) -> Result<(), Diagnostic> {
        let mut file = Output::create_with_folders(path)?;
        file.put(&(self.columns().join(",") + "\n"))?;
        for index in 0..self.rows.len() {
            let mut text = String::new();
            for (k, value) in self.row_of(index).into_iter().enumerate() {
                if k > 0 {
                    text.push(',');
                }
                // Ten nanometres of a nanometre are enough; writing to a string cannot fail. Adding zero takes the sign of zero away.
                let rounded = (value * 1e11).round() / 1e11 + 0.0;
                let _ = write!(text, "{rounded}");
            }
            text.push('\n');
            file.put(&text)?;
        }
        file.commit()
    }

    /// A row in the order of [`Plan::columns`].
    pub fn row_of(&self, index: usize) -> Vec<f64> {
        let row = &self.rows[index];
        let (state, instant) = (&row.state, &row.instant);
        let (q, v, a) = (&state.q, &state.v, &state.a);
        let mut values = vec![instant.time];
        for (k, joint) in self.legs.joints.iter().enumerate() {
            values.extend([q[joint.column + 1], v[joint.column], a[joint.column], row.effort[k]]);
        }
        values.extend(&q[..7]);
        let turn = root_rotation(q);
        let [linear, angular] = [Vector3::from_column_slice(&v[..3]), Vector3::from_column_slice(&v[3..6])];
        // The model's acceleration is the rate of the velocity's components in axes that turn.
        let linear_acceleration = Vector3::from_column_slice(&a[..3]) + angular.cross(&linear);
        values.extend((turn * linear).iter());
        values.extend(angular.iter());
        values.extend((turn * linear_acceleration).iter());
        values.extend(&a[3..6]);
        for order in 0..3 {
            values.extend(row.center.map(|x| x[order]));
        }
        values.extend(row.zmp);
        values.extend(row.divergent);
        for k in 0..2 {
            values.extend(instant.soles[k].map(|x| x[0]));
            values.extend(&row.wrenches[k][..3]);
            values.push(f64::from(instant.contact[k]));
        }
        values.push(bipedc_analysis::walking::margin(&row.support, row.zmp));
        let phase = &self.schedule.phases[instant.phase];
        values.extend([phase.step.map_or(0.0, |step| step as f64 + 1.0), instant.phase as f64]);
        values
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }
}
