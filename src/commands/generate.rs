//! `bipedc generate`: a robot's crate, written or checked.
use super::compare::Compare;
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::{Failure, Outcome};
use crate::terminal::output;
use crate::terminal::progress::spin;
use bipedc::Workbench;
use bipedc::crate_paths::{folder_name, refuse_foreign, runtime_dependency, source_name};
use bipedc::gait::PhasedBench;
use bipedc::table::table;
use bipedc::walking::{Legs, controller_crate, robots_own};
use bipedc_compiler::compile::{CompiledModel, Function};
use bipedc_compiler::emit::{GaitCode, Origin, Package, Runtime, package, pairs_at_once};
use bipedc_compiler::robot::RobotGait;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use clap::Args;
use serde::Serialize;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  bipedc generate robots/tulip              writes generated/tulip
  bipedc generate robots/tulip --check      is that what would be written?
  bipedc generate robots/tulip --out my_workspace/tulip
  bipedc generate robots/five_link --gait thesis --out my_workspace/five_link
  bipedc generate robots/leg --out my_workspace/leg --runtime my_workspace/tulip/bipedc-runtime
  bipedc generate robots/tulip --limbs-apart --out my_workspace/tulip
  bipedc generate robots/tulip --controller writes generated/tulip_controller: it walks on flat feet by itself

With --out the crate has the small runtime that it needs in its folder; with --runtime two crates of one program share one.
The crate never allocates. On x86-64 its default feature `dispatch` takes the better instructions where the processor has them; with \
`default-features = false` it is `no_std`. What it holds is chosen by `[generate]` in biped.toml; by default \
everything. The crate is written whole or not at all; files that bipedc did not generate stay. --check writes nothing: it names \
missing, changed (stale or edited) and extra files, exit code 1.
JSON: {\"folder\", \"functions\": [{\"name\", \"rows\", \"columns\", \"operations\", \"pairs_at_once\"}], \"files\", \"bytes\", \"seconds\"}; with --check {\"folder\", \"up_to_date\", \"files\", \"missing\", \"changed\", \"extra\": [file]}.";

/// Write a robot's equations of motion as a Rust crate
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Generate {
    #[command(flatten)]
    robot: RobotArguments,
    /// Folder of the crate [default: generated/<name of the robot's folder>]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Only compare with what is there; write nothing
    #[arg(long)]
    check: bool,
    /// Where the crate finds `bipedc-runtime`: a folder, or a version [default: the one of the repository that it
    /// is written into, elsewhere a copy in the crate's own folder]
    #[arg(long, value_name = "PATH|VERSION")]
    runtime: Option<String>,
    /// Also a gait of the robot: its functions, what its controller needs, and an example that walks; a name in gaits/
    /// beside the robot's description, or a file
    #[arg(long, value_name = "NAME|FILE.toml")]
    gait: Option<String>,
    /// Instead: the crate of its controller, which walks on flat feet by what sensors tell; numbers are those of walking.toml
    /// beside the description. With a library for C
    #[arg(long, conflicts_with_all = ["gait", "compare"])]
    controller: bool,
    /// Compute limbs of the same make one after the other, not both at once: the same bits by more instructions
    #[arg(long, conflicts_with = "controller")]
    limbs_apart: bool,
    /// Then compare the model's torques with this log, as `bipedc compare` does
    #[arg(long, value_name = "LOG.csv", conflicts_with = "check")]
    compare: Option<PathBuf>,
    /// Print what was written, or what differs, as JSON
    #[arg(long, conflicts_with = "compare")]
    json: bool,
}

/// What was written.
#[derive(Serialize)]
struct Json {
    folder: String,
    functions: Vec<Costs>,
    files: usize,
    bytes: usize,
    seconds: f64,
}

#[derive(Serialize)]
struct Costs {
    name: String,
    rows: usize,
    columns: usize,
    operations: usize,
    /// Of them, pairs that are computed at once for two limbs of the same make.
    pairs_at_once: usize,
    /// Operations by kind, for people.
    #[serde(skip)]
    by_kind: String,
}

/// What a crate is compared with.
#[derive(Serialize)]
struct Differs<'a> {
    folder: String,
    up_to_date: bool,
    files: usize,
    missing: &'a [String],
    changed: &'a [String],
    extra: &'a [String],
}

impl Generate {
    /// Compiles everything that the description asks for.
    pub fn run(self) -> Outcome {
        let started = Instant::now();
        let bench = self.robot.open()?;
        let robot = bench.robot();
        let folder = folder_name(&self.robot.path) + if self.controller { "_controller" } else { "" };
        let out = self.out.clone().unwrap_or_else(|| Path::new("generated").join(folder));
        if !self.check {
            refuse_foreign(&out)?;
        }
        let runtime = runtime_dependency(self.runtime.as_deref(), &out)?;
        output::diagnostics(&robot.without_inertia()?);
        if self.controller {
            return self.controller(&bench, runtime, &out, started);
        }
        let compiled = spin("deriving", || robot.compile())?;
        let gait = self.gait.as_deref().map(|name| spin("deriving", || robot.gait(name))).transpose()?;
        let code = gait.as_ref().map(|gait| emitted(&bench, gait)).transpose()?;
        let source = source_name(&self.robot.path);
        let origin = robot.origin(code.as_ref(), &source, runtime);
        let origin = Origin { limbs_apart: self.limbs_apart, ..origin };
        let package = spin("writing Rust", || package(&compiled, code.as_ref(), &origin));
        if self.check {
            return self.difference(&package, &out);
        }
        self.write((&bench, gait.as_ref()), &package, &out)?;
        let costs = self.costs(&compiled, gait.as_ref().map(RobotGait::model));
        self.said(&package, &out, costs, started)?;
        match self.compare {
            Some(log) => {
                output::print(&format!(
                    "\nthe same programs, run in process, against {}:\n\n",
                    log.display()
                ))?;
                Compare::of_log(self.robot, log).run()
            }
            None => Ok(ExitCode::SUCCESS),
        }
    }

    /// The crate of a controller.
    fn controller(&self, bench: &Workbench, runtime: Runtime, out: &Path, started: Instant) -> Outcome {
        let robot = bench.robot();
        let (stated, numbers) = robots_own(robot)?;
        let source = source_name(&self.robot.path);
        let package = spin("deriving", || controller_crate(&Legs::new(robot, &stated)?, &source, runtime))?;
        if self.check {
            return self.difference(&package, out);
        }
        if let Some(numbers) = numbers {
            bench.ledger().reads("the numbers of the walk", &numbers);
        }
        self.write((bench, None), &package, out)?;
        self.said(&package, out, Vec::new(), started)?;
        Ok(ExitCode::SUCCESS)
    }

    /// Of each model's functions. A gait's own are written with its limbs together.
    fn costs(&self, robot: &CompiledModel, gait: Option<&CompiledModel>) -> Vec<Vec<Costs>> {
        let of = |model: &CompiledModel, apart: bool| {
            let pairs = if apart { vec![0; model.functions.len()] } else { pairs_at_once(model) };
            model.functions.iter().zip(pairs).map(|(f, pairs)| Costs::of(f, pairs)).collect()
        };
        std::iter::once(of(robot, self.limbs_apart)).chain(gait.map(|model| of(model, false))).collect()
    }

    /// What was written, for people or programs; `costs`: per model.
    fn said(
        &self,
        package: &Package,
        out: &Path,
        costs: Vec<Vec<Costs>>,
        started: Instant,
    ) -> io::Result<()> {
        let bytes: usize = package.files.values().map(String::len).sum();
        let (files, seconds, folder) =
            (package.files.len(), started.elapsed().as_secs_f64(), out.display().to_string());
        if self.json {
            let functions = costs.into_iter().flatten().collect();
            return output::print_json(&Json { folder, functions, files, bytes, seconds });
        }
        if costs.is_empty() {
            return output::print(&format!("{folder}: {files} files, {bytes} bytes\n"));
        }
        let count: usize = costs.iter().map(Vec::len).sum();
        // Of a gait there are two models: the robot's own, and what its controller takes.
        let heads = ["", "of the gait: what its controller and its zero dynamics take\n"];
        let with_head = |(head, costs): (&str, &Vec<Costs>)| format!("{head}{}", functions(costs));
        let tables: Vec<String> = heads.into_iter().zip(&costs).map(with_head).collect();
        let last = format!("{folder}: {count} functions, {files} files, {bytes} bytes, {seconds:.2} s");
        output::print(&format!("{}\n{last}\n", tables.join("\n")))
    }

    fn write(
        &self,
        (bench, gait): (&Workbench, Option<&RobotGait>),
        package: &Package,
        out: &Path,
    ) -> Result<(), Diagnostic> {
        let mut ledger = bench.ledger();
        gait.iter().for_each(|gait| ledger.reads("the gait", &gait.file));
        self.compare.iter().for_each(|log| ledger.reads("the log", log));
        package
            .files
            .keys()
            .try_for_each(|name| ledger.writes_source(&format!("`{name}`"), &out.join(name)))?;
        for name in package.write(out)? {
            output::diagnostics(&[Diagnostic::warning("the file was not generated by bipedc: left alone")
                .in_file(&out.join(name))
                .help("`bipedc generate --check` fails as long as it is there: move it away")]);
        }
        Ok(())
    }

    fn difference(&self, package: &Package, out: &Path) -> Outcome {
        let difference = package.compare(out)?;
        if self.json {
            output::print_json(&Differs {
                folder: out.display().to_string(),
                up_to_date: difference.is_empty(),
                files: package.files.len(),
                missing: &difference.missing,
                changed: &difference.changed,
                extra: &difference.extra,
            })?;
        }
        if difference.is_empty() && self.json {
            return Ok(ExitCode::SUCCESS);
        }
        if difference.is_empty() {
            output::print(&format!("{} is up to date ({} files)\n", out.display(), package.files.len()))?;
            return Ok(ExitCode::SUCCESS);
        }
        let refresh = format!("refresh with: {}", self.refresh_command(out));
        let lists = [
            (&difference.missing, "is missing"),
            (&difference.changed, "differs from what would be generated: stale, or edited by hand"),
            (&difference.extra, "would not be generated: left over, or added by hand"),
        ];
        let message = |file: &String, what: &str| {
            Diagnostic::error(format!("`{file}` {what}")).in_file(&out.join(file))
        };
        let mut all: Vec<Diagnostic> = lists
            .into_iter()
            .flat_map(|(files, what)| files.iter().map(move |file| message(file, what)))
            .collect();
        // Said once: it is the same for all.
        if let Some(last) = all.last_mut() {
            last.help = Some(refresh);
        }
        Err(Failure(all))
    }

    fn refresh_command(&self, out: &Path) -> String {
        let runtime =
            self.runtime.as_ref().map_or_else(String::new, |runtime| format!(" --runtime {runtime}"));
        let gait = self.gait.as_ref().map_or_else(String::new, |gait| format!(" --gait {gait}"));
        let gait = if self.controller { " --controller".to_owned() } else { gait };
        let apart = if self.limbs_apart { " --limbs-apart" } else { "" };
        let overrides = self.robot.overrides();
        format!(
            "bipedc generate {} --out {}{gait}{apart}{runtime}{overrides}",
            self.robot.path.display(),
            out.display()
        )
    }
}

impl Costs {
    fn of(function: &Function, pairs_at_once: usize) -> Self {
        Self {
            name: function.name.clone(),
            rows: function.rows.len(),
            columns: function.columns.len(),
            operations: function.operations.total(),
            pairs_at_once,
            by_kind: function.operations.to_string(),
        }
    }
}

/// A gait as Rust; what is odd about it is said.
fn emitted(bench: &Workbench, found: &RobotGait) -> Result<GaitCode, Diagnostics> {
    output::diagnostics(&found.warnings);
    let code = found.code(None)?;
    let Some(phased) = PhasedBench::derived_before(found) else { return Ok(code) };
    let specs = bench.phases()?;
    match spin("walking", || phased.walk_of_example(&specs)) {
        Ok(walk) => Ok(code.walking(walk)),
        Err(refused) => {
            let message = format!("the crate has no example that walks: {refused}");
            output::diagnostics(&[Diagnostic::warning(message)
                .in_file(&found.file)
                .help("`bipedc gait cycle` looks for walking that repeats itself; the controller is written all the same")]);
            Ok(code)
        }
    }
}

fn functions(costs: &[Costs]) -> String {
    let row = |f: &Costs| {
        let shape = format!("{} × {}", f.rows, f.columns);
        vec![f.name.clone(), shape, f.pairs_at_once.to_string(), f.by_kind.clone()]
    };
    table(&["function", "shape", "pairs at once", "operations"], costs.iter().map(row).collect(), 4)
}
