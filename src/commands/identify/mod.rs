//! `bipedc identify`: inertial parameters from logs.
use crate::arguments::RobotArguments;
use crate::failure::Outcome;
use crate::identifying::Identified;
use bipedc_runtime::compare;
use bipedc_runtime::identify::physical::*;
use bipedc_runtime::identify::*;
use bipedc_runtime::log::Mapping;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Find out
#[derive(Args)]
pub struct Identify {
    #[command(flatten)]
    robot: RobotArguments,
    /// The logs
    #[arg(value_name = "LOG.csv", required = true)]
    logs: Vec<PathBuf>,
    #[arg(long)]
    validate: Option<PathBuf>,
    #[arg(long)]
    cutoff: Option<f64>,
}

impl Identify {
    pub fn run(self) -> Outcome {
        let robot = self.robot.read()?;
        let mapping = Mapping::default();
        let options = compare::Options { cutoff_hz: self.cutoff, ..compare::Options::default() };
        let logs: Vec<Log<'_>> = self.logs.iter().map(|p| Log { path: p, mapping: &mapping, options: options.clone() }).collect();
        let t = std::time::Instant::now();
        let id = Identified::new(&robot, &logs, false)?;
        println!("derive {:?}", t.elapsed());
        let extras = ExtraChoice::default().list(&(0..id.subject.joints.len()).collect::<Vec<_>>());
        let design = Design::new(&id.subject, &id.base, &id.regressor, extras, &id.rows);
        println!("{} unknowns {:?}", design.unknowns.len(), t.elapsed());
        let motions = Motions::new(&id.surveys);
        println!("{:?}", motions);
        let settings = Settings { threads: 2, ..Settings::default() };
        let sums = accumulate(&design, &logs, &motions, &settings, None)?;
        println!("accumulated {:?}", t.elapsed());
        let nominal = nalgebra_zero(design.unknowns.len());
        let est = Estimate::weighted(&design, &sums, nominal, Method::Weighted);
        let fit = est.fit(&design, &sums);
        println!("fit {:?}", t.elapsed());
        let se = fit.standard_errors();
        for (k, u) in design.unknowns.iter().enumerate() {
            println!("{:3} {:10.5} ± {:8.5} (white {:8.5}) {}", k, fit.theta[k], se[k], fit.white[(k, k)].sqrt(), u.name);
        }
        println!("noise {:?} cond {:?}", est.noise, est.singular_values().iter().copied().fold((0.0f64, 9.0f64), |a, x| (a.0.max(x), a.1.min(x))));
        let links = Links::new(&id.anatomy);
        let bounds = Bounds::default();
        let problem = Problem::new(&design, &links, &bounds);
        let chans: Vec<_> = total_by_channel(&sums, &design);
        let rel = |th: &_| errors(&chans, &design, th).iter().fold(Held::default(), |s, e| s.plus(e)).relative();
        println!("ls train {:.4}", rel(&fit.theta));
        let folds = motions.folds();
        let held = est.held_out(&design, &sums, &folds, &|t| est.solve(t, &est.seen));
        println!("ls folds {:?}", held.iter().map(|f| f.iter().fold(Held::default(), |s, e| s.plus(e)).relative()).collect::<Vec<_>>());
        let choice = choose(&problem, &design, &sums, &est, &folds, &|_| ())?;
        println!("chosen {:?} {:?}", choice.weight, t.elapsed());
        for tr in &choice.trials {
            let p = problem.solve(&est.total, tr.weight)?;
            println!("{tr:?} train {:.4} {:?}", rel(&p.theta), p.certificate);
            let m: Vec<String> = links.bodies.iter().zip(p.coordinates.chunks(10)).map(|(b, x)| format!("{:.2}/{:.2}", b.inertia(x).mass, b.nominal.mass)).collect();
            println!("   {}", m.join(" "));
        }
        if let Some(v) = &self.validate {
            let vl = [Log { path: v, mapping: &mapping, options: options.clone() }];
            let vs = vec![survey(&vl[0], &id.subject)?];
            let vm = Motions::new(&vs);
            let vsums = accumulate(&design, &vl, &vm, &settings, None)?;
            let ch = total_by_channel(&vsums, &design);
            let rel = |th: &_| errors(&ch, &design, th).iter().fold(Held::default(), |s, e| s.plus(e)).relative();
            println!("validation: ls {:.4} cad {:.4}", rel(&fit.theta), rel(&nalgebra_zero(design.unknowns.len())));
            for tr in &choice.trials {
                let p = problem.solve(&est.total, tr.weight)?;
                println!("{} {:.4}", tr.weight, rel(&p.theta));
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
