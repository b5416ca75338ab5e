//! A plan on film: the robot that walks it, footprints, zero moment point, divergent component, margins over time.
use super::Plan;
use super::check::Quantity;
use crate::film::Recorder;
use bipedc_analysis::report::{Curve, Fact, Film, FilmPart, Form, Picture, Plot};
use bipedc_analysis::simulate::{FUNCTIONS, Mechanics, Sample};
use bipedc_analysis::walking::{Point, Settings, corner_forces, margin};
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_effects::diagnostic::Diagnostic;

/// Thickness of a footprint, m.
const THIN: f64 = 0.001;

impl Plan {
    /// The film of the plan.
    ///
    /// # Errors
    /// Functions that cannot be derived.
    pub fn film(&self) -> Result<Film, Diagnostic> {
        let shown = ["kinetic_energy", "potential_energy", "center_of_mass"];
        let requests: Vec<FunctionRequest> =
            FUNCTIONS.iter().chain(&shown).map(|family| FunctionRequest::of_robot(*family)).collect();
        let model = ProgramModel::new(self.legs.robot.compile_only(&requests)?);
        let mechanics = Mechanics::new(&model, self.legs.tree.base)?;
        let mut recorder = Recorder::new(&self.legs.robot, mechanics, self.duration(), self.rows.len())?;
        for index in 0..self.rows.len() {
            recorder.take(&self.sample(index));
        }
        let mut film = recorder.finish();
        let method = self.method_name();
        film.title = format!("{}: {method} walk, planned", film.robot);
        film.summary = format!("{}\n\n{}", self.summary(), self.verdict());
        film.warnings = self.violation.iter().map(|first| first.sentence()).collect();
        film.facts = self.facts();
        film.parts.extend(self.footprints());
        film.plots.splice(0..0, self.plots());
        film.pictures = vec![Picture {
            title: "Footprints".to_owned(),
            caption: "From above. Filled: soles on the ground; lines: centre of mass, zero moment point, divergent component.".to_owned(),
            svg: self.picture(),
        }];
        Ok(film)
    }

    fn sample(&self, index: usize) -> Sample {
        let row = &self.rows[index];
        let joints = &self.legs.joints;
        let mut forces = vec![[0.0; 3]; self.legs.tree.points.len()];
        for k in 0..2 {
            let sole = &row.instant.soles[k];
            let corners = self.legs.corners(k, [sole[0][0], sole[1][0]], sole[3][0]);
            let prefix = format!("{}/", self.legs.feet[k]);
            let points = (0..forces.len()).filter(|p| self.legs.tree.points[*p].name.starts_with(&prefix));
            let own = corner_forces(&row.wrenches[k], &corners);
            points.zip(own).for_each(|(point, force)| forces[point] = force);
        }
        Sample {
            soles: Vec::new(),
            time: row.instant.time,
            q: row.state.q.clone(),
            v: row.state.v.clone(),
            effort: row.effort.clone(),
            reference: joints.iter().map(|joint| row.state.q[joint.column + 1]).collect(),
            forces,
            motor: vec![f64::NAN; joints.len()],
            current: vec![f64::NAN; joints.len()],
        }
    }

    fn plots(&self) -> Vec<Plot> {
        let curve = |name: &str, of: &dyn Fn(&super::Row) -> f64| Curve {
            name: name.to_owned(),
            values: self.rows.iter().map(of).collect(),
        };
        let plot = |title: &str, curves: Vec<Curve>| Plot {
            title: title.to_owned(),
            joint: None,
            unit: "m".to_owned(),
            curves,
        };
        let balance = |i: usize| {
            vec![
                curve("zero moment point", &|row| row.zmp[i]),
                curve("centre of mass", &|row| row.center[i][0]),
                curve("divergent component", &|row| row.divergent[i]),
            ]
        };
        let limit = self.settings.margin;
        let margins = vec![
            curve("zero moment point", &|row| margin(&row.support, row.zmp)),
            curve("centre of mass", &|row| margin(&row.support, [row.center[0][0], row.center[1][0]])),
            curve("limit", &|_| limit),
        ];
        vec![
            plot("Balance, forward", balance(0)),
            plot("Balance, to the left", balance(1)),
            plot("Distance from the edge of the support polygon (negative: outside)", margins),
        ]
    }

    fn footprints(&self) -> Vec<FilmPart> {
        let start = (0..2).map(|k| (k, self.start.soles[k]));
        let steps = self.footsteps.iter().map(|step| (step.foot, step.sole));
        let part = |(foot, sole): (usize, bipedc_analysis::walking::Sole)| {
            let outline: Vec<Point> = self.legs.footprint(foot, sole.place, sole.yaw);
            let n = outline.len();
            let corners =
                [-THIN, 0.0].into_iter().flat_map(|z| outline.iter().map(move |[x, y]| [*x, *y, z]));
            let mut faces = vec![(0..n).rev().collect::<Vec<_>>(), (n..2 * n).collect()];
            faces.extend((0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]));
            let side = [bipedc_analysis::robot::Side::Right, bipedc_analysis::robot::Side::Left][foot];
            FilmPart { body: None, side: Some(side), form: Form::Solid { corners: corners.collect(), faces } }
        };
        start.chain(steps).map(part).collect()
    }

    fn facts(&self) -> Vec<Fact> {
        let numbers = Settings::KEYS.iter().filter_map(|(name, unit, ..)| {
            let all = serde_json::to_value(self.settings).ok()?;
            let value = all.get(*name)?.as_f64()?;
            Some(Fact::new(*name, format!("{} {unit}", (value * 1e6).round() / 1e6)))
        });
        let nearest = self.nearest.iter().filter(|n| n.quantity != Quantity::VerticalForce);
        nearest.map(|n| Fact::new("nearest", n.sentence())).chain(numbers).collect()
    }
}
