//! Static postures on force plates (thesis 5.4.1).
use super::ground::{Center, Ground, InMetres, Mass, ModelErrors, parameters, values};
use super::standing::{Root, StandingRobot};
use super::{Identified, Job};
use crate::measurements::{Log, Measured};
use bipedc_analysis::experiments::postures::PostureExperiment;
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::identify::cop::{
    Confounded, PostureTable, TILTED, check_postures, confounded, held_out, least_squares, pressure_errors,
    simplified, swing_tilt,
};
use bipedc_analysis::identify::physical::Bound;
use bipedc_analysis::identify::{
    BaseSet, BatchRegressor, Feed, Identification, IdentificationResult, Judge, Options, RobotAndLogs,
    Survey, identify,
};
use bipedc_analysis::report::Row;
use bipedc_analysis::robot::inertial_parameters::{body_of, element_of};
use bipedc_analysis::robot::{Batch, LinkInertias};
use bipedc_compiler::exact::Model;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::PathBuf;

/// Rows come from tables: no regressor is evaluated.
pub struct NoRegressor;

impl BatchRegressor for NoRegressor {
    fn nq(&self) -> usize {
        0
    }
    fn nv(&self) -> usize {
        0
    }
    fn pattern(&self) -> &[Vec<usize>] {
        &[]
    }
    fn evaluate(&self, _batch: &Batch<'_>, _out: &mut [f64]) {}
}

/// Total mass and how it was come by.
struct Weighed {
    mass: f64,
    error: Option<f64>,
    source: &'static str,
}

/// Tables and what is asked of them.
struct Tables<'a> {
    job: &'a Job<'a>,
    standing: &'a StandingRobot,
    measured: &'a Measured,
    training: Vec<PostureExperiment<'a>>,
    judging: Vec<PostureExperiment<'a>>,
    weighed: Weighed,
    /// Base parameters of the full model, and of the one that is estimated.
    full: BaseSet,
    base: BaseSet,
}

/// Reads, estimates; pictures there are none of.
pub fn run(job: &mut Job<'_>) -> Result<(Identified, Vec<Row>), Diagnostics> {
    let Job { robot, options, progress, .. } = *job;
    let standing = StandingRobot::new(robot, options.stance.as_deref(), Root::Link)?;
    let measured = progress.stage("deriving", || Measured::new(&standing.robot))?;
    let (logs, judge) = (job.logs, job.judge);
    let mut read = |log: &Log| {
        let stance = Some(standing.stance.as_str());
        let found = PostureExperiment::read(measured.robot(), log, stance)?;
        let odd = check_postures(&found, &measured.layout);
        job.pass(odd.into_iter().map(|d| d.in_file(log.path())).collect())?;
        Ok::<_, Diagnostics>(found)
    };
    let training = logs.iter().map(|log| read(log)).collect::<Result<Vec<_>, _>>()?;
    let judging = judge.into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let weighed = weighed(options.total_mass, &training, &standing)?;
    let rows: &[&str] = if training.iter().any(|t| t.is_oriented()) { &["x", "y", "z"] } else { &["x", "y"] };
    let flat = training.iter().filter_map(swing_tilt).all(|(_, _, tilt)| tilt <= TILTED);
    let full = progress.stage("deriving", || standing.base(Model::CenterOfMass, rows, flat))?;
    let smaller = progress.stage("deriving", || reduced(&standing, &full));
    let base = if options.symmetric { smaller? } else { full.clone() };
    let (standing, measured) = (&standing, &measured);
    Tables { job, standing, measured, training, judging, weighed, full, base }.answer()
}

/// The thesis' simplified model.
fn reduced(standing: &StandingRobot, full: &BaseSet) -> Result<BaseSet, Diagnostic> {
    let zeros = standing.zeros()?;
    let ten = ["m", "m*cx", "m*cy", "m*cz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];
    let names: Vec<String> =
        standing.link_inertias.bodies.iter().flat_map(|body| ten.map(|p| format!("{body}.{p}"))).collect();
    Ok(simplified(full, &names, &|k| zeros.contains(&k)))
}

fn weighed(
    given: Option<f64>,
    tables: &[PostureExperiment<'_>],
    standing: &StandingRobot,
) -> Result<Weighed, Diagnostic> {
    if let Some(mass) = given {
        if !(mass.is_finite() && mass > 0.0) {
            return Err(
                Diagnostic::error(format!("--total-mass is {mass}")).help("give the robot's mass in kg")
            );
        }
        return Ok(Weighed { mass, error: None, source: "--total-mass" });
    }
    let described: f64 = standing.link_inertias.parameters().mass();
    let carried: Option<Vec<Vec<f64>>> = tables.iter().map(PostureExperiment::carried).collect();
    let Some(all) = carried.map(|c| c.concat()).filter(|all| !all.is_empty()) else {
        return Ok(Weighed {
            mass: described,
            error: None,
            source: "the description: no corner forces of all feet are logged",
        });
    };
    let n = all.len() as f64;
    let mass = all.iter().sum::<f64>() / n;
    let spread = (all.iter().map(|m| (m - mass).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
    if !(mass > 0.2 * described && mass < 5.0 * described) {
        return Err(Diagnostic::error(format!(
            "the corner forces carry {mass:.3} kg on average, and the description weighs {described:.3} kg"
        ))
        .help(
            "are `<foot>/<corner>/force/z` in N, positive upwards on the foot? --total-mass states the mass",
        ));
    }
    Ok(Weighed { mass, error: Some(spread / n.sqrt()), source: "corner forces" })
}

impl Tables<'_> {
    fn answer(&self) -> Result<(Identified, Vec<Row>), Diagnostics> {
        let job = self.job;
        let tables: Vec<PostureTable> =
            self.training.iter().map(|t| PostureTable::new(t, self.weighed.mass)).collect();
        let judges: Vec<PostureTable> =
            self.judging.iter().map(|t| PostureTable::new(t, self.weighed.mass)).collect();
        let feeds: Vec<&dyn Experiment> = tables.iter().map(|t| t as &dyn Experiment).collect();
        let judging: Vec<&dyn Experiment> = judges.iter().map(|t| t as &dyn Experiment).collect();
        let joints = self.measured.layout.joints.len();
        let survey = |(table, from): (&PostureTable, &PostureExperiment<'_>)| Survey {
            assumptions: from.assumptions.clone(),
            ..Survey::of_table(table, joints, 0.0)
        };
        let surveys: Vec<Survey> = tables.iter().zip(&self.training).map(survey).collect();
        let judge_surveys: Vec<Survey> = judges.iter().zip(&self.judging).map(survey).collect();
        let link_inertias = self.prior(job.options.symmetric)?;
        let files: Vec<PathBuf> = job.logs.iter().map(|log| log.path().to_path_buf()).collect();
        let parts = RobotAndLogs {
            layout: &self.measured.layout,
            link_inertias: &link_inertias,
            base: &self.base,
            regressor: &NoRegressor,
            rows: &[],
            files: &files,
            surveys: &surveys,
        };
        let judge = job.judge.zip(judge_surveys.first()).map(|(log, survey)| Judge {
            feed: Feed::Tables(&judging),
            survey,
            file: log.path(),
        });
        let options = self.options()?;
        let feed = Feed::Tables(&feeds);
        let answer = job
            .progress
            .counted("identifying", |progress| identify(&parts, &feed, judge.as_ref(), &options, progress))?;
        let ground = self.ground(&answer, (&tables, &judges));
        Ok(Identified::new(answer, Some(ground)))
    }

    /// The description near which bodies stay; of a robot taken as symmetric, with what is zero there.
    fn prior(&self, symmetric: bool) -> Result<LinkInertias, Diagnostic> {
        let mut link_inertias = self.standing.link_inertias.clone();
        let zeros = if symmetric { self.standing.zeros()? } else { Vec::new() };
        for link in &mut link_inertias.links {
            let of_body = zeros.iter().filter(|k| body_of(**k) == link.body);
            of_body.for_each(|k| link.center[element_of(*k) - 1] = 0.0);
        }
        Ok(link_inertias)
    }

    /// The total mass is known.
    fn options(&self) -> Result<Options, Diagnostic> {
        let mut options = self.job.options.estimation()?;
        options.scarce = true;
        if self.job.options.total_mass.is_none() {
            options.bounds.push(Bound::TotalMass(self.weighed.mass));
        }
        Ok(options)
    }

    fn ground(
        &self,
        answer: &IdentificationResult,
        (tables, judges): (&[PostureTable], &[PostureTable]),
    ) -> Ground {
        let nominal = self.standing.link_inertias.parameters();
        let physical = parameters(&self.standing.link_inertias, &answer.links);
        let identification = &answer.identification;
        let models = self.models((tables, judges), (&nominal, &physical), identification);
        let joints = self.training.iter().flat_map(|t| t.positions()).collect::<Vec<_>>();
        let mean = (0..self.measured.layout.joints.len())
            .map(|j| joints.iter().map(|q| q[j]).sum::<f64>() / joints.len().max(1) as f64)
            .collect::<Vec<f64>>();
        let root = &self.standing.torso;
        let confounded = self
            .training
            .first()
            .map_or_else(Confounded::default, |t| confounded(t, &[Channel::Cop, Channel::BaseForce], root));
        let metres = identification.parameters.iter().filter(|p| p.unit == "kg m").map(|p| InMetres {
            name: p.name.clone(),
            value: p.value / self.weighed.mass,
            standard_error: p.standard_error / self.weighed.mass,
            nominal: p.nominal / self.weighed.mass,
        });
        Ground {
            stance: Some(self.standing.stance.clone()),
            mass: Mass {
                value: self.weighed.mass,
                standard_error: self.weighed.error,
                described: nominal.mass(),
                source: self.weighed.source,
            },
            center_of_mass: Center::new(self.measured, &mean, &nominal, &physical),
            in_metres: metres.collect(),
            models,
            confounded,
        }
    }

    /// Centres of pressure by the description, full and simplified least squares, and possible bodies; of the first
    /// table, and of the validation.
    fn models(
        &self,
        (tables, judges): (&[PostureTable], &[PostureTable]),
        (nominal, physical): (&[f64], &[f64]),
        found: &Identification,
    ) -> Vec<ModelErrors> {
        let Some(table) = tables.first() else { return Vec::new() };
        let errors = |model, base: &BaseSet, values: &[f64], fitted: bool| ModelErrors {
            model,
            parameters: base.sums.len(),
            training: pressure_errors(table, base, values),
            held_out: (fitted && tables.len() == 1).then(|| held_out(table, base, &base.values(nominal))),
            validation: judges.first().map(|judge| pressure_errors(judge, base, values)),
        };
        let fit = |base: &BaseSet| {
            let (w, y) = table.regression(base);
            least_squares(&w, &y, &base.values(nominal)).as_slice().to_vec()
        };
        let mut all = vec![errors("description", &self.full, &self.full.values(nominal), false)];
        if self.base == self.full {
            all.push(errors("full", &self.full, &values(&self.full, found, nominal), true));
            if let Ok(smaller) = reduced(self.standing, &self.full) {
                all.push(errors("simplified", &smaller, &fit(&smaller), true));
            }
        } else {
            all.push(errors("full", &self.full, &fit(&self.full), true));
            all.push(errors("simplified", &self.base, &values(&self.base, found, nominal), true));
        }
        all.push(errors("physical", &self.full, &self.full.values(physical), false));
        all
    }
}
