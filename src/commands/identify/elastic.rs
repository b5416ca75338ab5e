//! `identify --method elastic`: friction and springs of series elastic drives, then bodies.
use super::{Estimator, Identify, parse, say, write_urdf};
use crate::failure::{Failure, Outcome};
use crate::identifying::Drives;
use crate::output;
use crate::reporting::of_identification;
use bipedc_analysis::identify::elastic::{
    Elastic, ElasticParts, Estimator as Kind, Laws, Look, Steps as Way, identify_elastic, look,
};
use bipedc_analysis::identify::{Log, Survey};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use clap::ValueEnum;
use std::process::ExitCode;

/// Motors slower than this part of their largest speed do not tell friction, per cent.
const SLOW: f64 = 3.0;

/// How both regressions are put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Steps {
    /// Motors first, then bodies with the springs so found (5.13, 5.15)
    Two,
    /// One regression, every row by its own noise
    One,
}

/// Reads, estimates, prints.
pub fn run(arguments: &Identify, robot: &Robot, logs: &[Log<'_>], judge: Option<&Log<'_>>) -> Outcome {
    let options = options(arguments)?;
    let drives = Drives::new(robot)?;
    let see = |log: &Log<'_>| look(log, &drives.subject, &drives.trains);
    let looks =
        output::progress("reading", || logs.iter().map(see).collect::<Result<Vec<_>, Diagnostics>>())?;
    let judging =
        judge.map(|log| Ok::<_, Failure>((log, output::progress("reading", || see(log))?))).transpose()?;
    let surveys: Vec<Survey> = looks.iter().map(|look| look.survey.clone()).collect();
    let every: Vec<&Look> = looks.iter().chain(judging.iter().map(|(_, look)| look)).collect();
    let bodies = output::progress("deriving", || drives.bodies(robot, logs, &surveys, &every))?;
    let parts = ElasticParts { parts: bodies.parts(), trains: &drives.trains, looks: &looks, logs };
    let judge = judging.as_ref().map(|(log, look)| (*log, look));
    let work = |progress: &dyn Fn(f64)| identify_elastic(&parts, judge, &options, progress);
    let answer = output::bar("identifying", work)?;
    if let Some(path) = &arguments.write_urdf {
        write_urdf(robot, &answer.links, path)?;
    }
    if arguments.outputs.wanted() {
        let rows = answer.pictures.clone();
        let report = of_identification(robot, &answer.identification, Some(&answer.drives), rows)?;
        arguments.outputs.write(&report)?;
    }
    if arguments.json {
        output::print_json(&answer)?;
    } else {
        output::print(&format!("{}\n{}", say::drives(&answer.drives), say::text(&answer.identification)))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn options(arguments: &Identify) -> Result<Elastic, Diagnostic> {
    let refuse = |option: &str, help: &str| {
        Err(Diagnostic::error(format!("{option} has no meaning with --method elastic")).help(help.to_owned()))
    };
    if !matches!(arguments.rotor.as_slice(), [word] if word == "none") {
        return refuse("--rotor", "rotor inertias are taken from the drive trains of biped.toml");
    }
    if !arguments.coupled.is_empty() {
        return refuse("--coupled", "leave it out: drives act on their own joint");
    }
    if arguments.decimate > 1 {
        return refuse("--decimate", "leave it out: regressor and torque pass the same filter already");
    }
    let mut laws = Laws { viscous: false, coulomb: false, offset: false };
    parse::laws(&arguments.friction, &mut [&mut laws.viscous, &mut laws.coulomb, &mut laws.offset])?;
    Ok(Elastic {
        laws,
        slow: arguments.slow.unwrap_or(SLOW) / 100.0,
        steps: match arguments.steps {
            Steps::Two => Way::Two,
            Steps::One => Way::One,
        },
        estimator: match arguments.estimator {
            Estimator::Ordinary => Kind::Ordinary,
            Estimator::Weighted => Kind::Weighted,
            Estimator::Instrumental => Kind::Instrumental,
            Estimator::Huber => {
                return refuse("--estimator huber", "choose ordinary, weighted or instrumental");
            }
        },
        weight: arguments.weight,
        bounds: parse::bounds(arguments.total_mass, &arguments.center, &arguments.mirror)?,
        anyway: arguments.anyway,
        pictures: arguments.outputs.wanted(),
    })
}
