//! The edges of the pipeline: reading a robot, compiling it, writing its crate.
use crate::compile::{
    CompiledGait, CompiledModel, CompiledPhases, Entry, FunctionRequest, Solvable, catalogue, compile,
    compile_gait, compile_phases, compile_what_there_is, inertia_help, no_inertia, requested_functions,
};
use crate::derive::effects::JointLaws;
use crate::description::gait::{AnyGait, Gait, PhasedGait, gait_path, read_any_gait};
use crate::description::model::{Base, RobotDescription};
use crate::description::{SourceFiles, mesh_file};
use crate::emit::{GaitCode, Origin, Package, Runtime, gait_code, package, phases_code};
use crate::self_check::self_check;
use crate::tree::Tree;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, line_and_column};
use bipedc_effects::files::Ledger;
use std::path::{Path, PathBuf};

/// A robot as read from its folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// What the files say.
    pub description: RobotDescription,
    /// What is odd about them.
    pub warnings: Vec<Diagnostic>,
    /// The files' texts.
    pub sources: SourceFiles,
}

/// A gait of a robot with its functions.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotGait {
    /// What the file says, with its functions.
    pub derived: DerivedGait,
    /// What is odd about it.
    pub warnings: Vec<Diagnostic>,
    /// Where it was read from.
    pub file: PathBuf,
}

/// A gait with its functions.
#[derive(Debug, Clone, PartialEq)]
pub enum DerivedGait {
    /// A step is one phase on one point.
    OnePhase(Box<(Gait, CompiledGait)>),
    /// A step is a sequence of phases.
    Phased(Box<(PhasedGait, CompiledPhases)>),
}

impl RobotGait {
    /// The gait's functions with those of the robot in its world.
    pub fn model(&self) -> &CompiledModel {
        match &self.derived {
            DerivedGait::OnePhase(of) => &of.1.model,
            DerivedGait::Phased(of) => &of.1.model,
        }
    }

    /// As Rust, programs with more instructions than `split_above` in several functions.
    ///
    /// # Errors
    /// A function is missing: a fault of the compiler.
    pub fn code(&self, split_above: Option<usize>) -> Result<GaitCode, Diagnostic> {
        let code = match &self.derived {
            DerivedGait::OnePhase(of) => gait_code(&of.1, &of.0, split_above),
            DerivedGait::Phased(of) => phases_code(&of.1, &of.0, split_above),
        };
        code.map_err(|error| error.or_in_file(&self.file))
    }
}

impl Robot {
    /// Reads a robot's folder, its `biped.toml` or a URDF.
    ///
    /// # Errors
    /// Everything that has no meaning, all at once.
    pub fn read(path: &Path) -> Result<Self, Diagnostics> {
        let sources = SourceFiles::load(path)?;
        let (description, warnings) = sources.parse()?;
        Ok(Self { description, warnings, sources })
    }

    /// Notes the files that describe it: URDF, description, meshes and their textures.
    pub fn note(&self, ledger: &mut Ledger) {
        let SourceFiles { urdf_path, urdf_text, toml_path, .. } = &self.sources;
        ledger.reads("the robot's URDF", urdf_path);
        ledger.reads("the robot's description", toml_path);
        let folder = urdf_path.parent().unwrap_or(Path::new(""));
        let Ok(document) = roxmltree::Document::parse(urdf_text) else { return };
        for name in document.descendants().filter_map(|node| node.attribute("filename")) {
            if let Some(path) = mesh_file(folder, name) {
                ledger.reads("a mesh of the robot", &path);
            }
        }
    }

    /// The same robot on another base.
    ///
    /// # Errors
    /// `kind` is none of `floating`, `planar`, `fixed`, or `root` names no link or contact point.
    pub fn with_base(mut self, kind: &str, root: Option<&str>) -> Result<Self, Diagnostic> {
        let present = match &self.description.base {
            Base::Floating { root } | Base::Planar { root } => root.clone(),
            Base::Fixed { link } => link.clone(),
            Base::Pivot { .. } => self.description.root_link.clone(),
        };
        let root = root.map_or(present, str::to_owned);
        self.description.base = match kind {
            "floating" => Base::Floating { root },
            "planar" => Base::Planar { root },
            "fixed" => Base::Fixed { link: root },
            "pivot" => Base::Pivot { about: root },
            other => {
                return Err(Diagnostic::error(format!("there is no base `{other}`"))
                    .help("bases are: floating, planar, fixed, pivot"));
            }
        };
        Ok(self)
    }

    /// The rigid-body model alone: the same robot without its `[[effect]]`s.
    #[must_use]
    pub fn without_effects(mut self) -> Self {
        self.description = self.description.without_effects();
        self
    }

    /// The tree on the description's base.
    ///
    /// # Errors
    /// A base that names nothing of this robot.
    pub fn tree(&self) -> Result<Tree, Diagnostic> {
        Tree::new(&self.description, &self.description.base)
    }

    /// Functions that are derived for whoever names them, of those that this robot can have.
    ///
    /// # Errors
    /// A base that names nothing of this robot, effects that have no value.
    pub fn on_demand(&self) -> Result<Vec<&'static Entry>, Diagnostic> {
        let tree = self.tree()?;
        let laws = JointLaws::new(&tree, &self.description)?;
        let solvable = Solvable::new(&self.description, &tree, &laws);
        let possible = |entry: &&Entry| {
            entry.on_demand
                && laws.refusal(entry.name).is_none()
                && solvable.refusal(entry.name, None).is_none()
        };
        Ok(catalogue().iter().filter(possible).collect())
    }

    /// Motions that nothing resists, each a warning at its joint in the URDF: inverse dynamics is as good as ever,
    /// but no acceleration follows from torques.
    ///
    /// # Errors
    /// A base that names nothing of this robot, effects that have no value.
    pub fn without_inertia(&self) -> Result<Vec<Diagnostic>, Diagnostic> {
        let tree = self.tree()?;
        let laws = JointLaws::new(&tree, &self.description)?;
        let solvable = Solvable::new(&self.description, &tree, &laws);
        let (base, joints): (Vec<String>, Vec<String>) =
            solvable.without_inertia().iter().cloned().partition(|row| row.starts_with("base/"));
        let warning = |rows: &[String]| {
            let message = format!("{}: forward dynamics has no solution", no_inertia(&tree, rows));
            let warning = Diagnostic::warning(message).in_file(&self.sources.urdf_path);
            warning.help(format!("{}; functions that need it are left out", inertia_help(rows)))
        };
        let of_joint = |row: &String| {
            let warning = warning(std::slice::from_ref(row));
            match self.sources.joint_place(row) {
                Some((line, column)) => warning.at(line, column),
                None => warning,
            }
        };
        let of_base = (!base.is_empty()).then(|| warning(&base));
        Ok(of_base.into_iter().chain(joints.iter().map(of_joint)).collect())
    }

    /// All functions that the description asks for.
    ///
    /// # Errors
    /// Functions, frames and phases that there are not, where the description names them.
    pub fn requests(&self, tree: &Tree) -> Result<Vec<FunctionRequest>, Diagnostic> {
        requested_functions(&self.description, tree).map_err(|error| {
            let generate = &self.description.generate;
            let text = &self.sources.toml_text;
            let named = generate.functions.iter().chain(&generate.frames);
            let here = named
                .filter(|name| error.message.contains(&format!("`{name}`")))
                .find_map(|name| text.find(&format!("\"{name}\"")));
            let Some(offset) = here else { return error };
            let (line, column) = line_and_column(text, offset);
            error.or_in_file(&self.sources.toml_path).at(line, column)
        })
    }

    /// Compiles everything that the description asks for, and tries it ([`self_check`]).
    ///
    /// # Errors
    /// Functions or frames that do not exist; a mistake of this compiler.
    pub fn compile(&self) -> Result<CompiledModel, Diagnostic> {
        let tree = self.tree()?;
        let requests = self.requests(&tree)?;
        let compiled = if self.description.generate.functions.is_empty() {
            compile_what_there_is(&self.description, &tree, &requests)?
        } else {
            compile(&self.description, &tree, &requests)?
        };
        self_check(&self.description, &compiled)?;
        Ok(compiled)
    }

    /// Compiles the wished functions alone; [`self_check`] is left to the caller.
    ///
    /// # Errors
    /// Functions or frames that do not exist.
    pub fn compile_only(&self, requests: &[FunctionRequest]) -> Result<CompiledModel, Diagnostic> {
        compile(&self.description, &self.tree()?, requests)
    }

    /// A hash of all inputs and of the compiler: equal hashes mean equal output.
    pub fn hash(&self) -> String {
        let mut parts = vec![
            env!("CARGO_PKG_VERSION").to_owned(),
            bipedc_runtime::FORMAT.to_string(),
            self.sources.urdf_text.clone(),
            self.sources.toml_text.clone(),
            // May differ from what the files say.
            format!("{:?}", self.description.base),
        ];
        // So may these; without any the hash stays what it was before there were effects.
        if !self.description.effects.is_empty() {
            parts.push(format!("{:?}", self.description.effects));
        }
        format!("{:016x}", fnv1a(&parts.join("\0")))
    }

    /// The robot's crate. `source` is what its header names, `runtime` where it finds `bipedc-runtime`: the
    /// dependency's value, such as `path = "../../runtime/core"`, or [`Runtime::Carried`].
    ///
    /// # Errors
    /// Functions or frames that do not exist.
    pub fn package(&self, source: &str, runtime: impl Into<Runtime>) -> Result<Package, Diagnostic> {
        Ok(self.package_of(&self.compile()?, None, source, runtime))
    }

    /// [`Self::package`] of what was compiled already, with a gait beside it.
    pub fn package_of(
        &self,
        compiled: &CompiledModel,
        gait: Option<&GaitCode>,
        source: &str,
        runtime: impl Into<Runtime>,
    ) -> Package {
        package(compiled, gait, &self.origin(gait, source, runtime))
    }

    /// What the header of this robot's crate says of it, limbs of the same make being computed at once.
    pub fn origin(&self, gait: Option<&GaitCode>, source: &str, runtime: impl Into<Runtime>) -> Origin {
        let hash = match gait {
            None => self.hash(),
            Some(gait) => format!("{:016x}", fnv1a(&[self.hash(), gait.inputs.clone()].join("\0"))),
        };
        Origin { source: source.to_owned(), hash, runtime: runtime.into(), limbs_apart: false }
    }

    /// A gait by its name in `gaits/` or by a path, compiled.
    ///
    /// # Errors
    /// No such gait; everything in the file that has no meaning, with line and column; functions that cannot be derived.
    pub fn gait(&self, name: &str) -> Result<RobotGait, Diagnostics> {
        let file = gait_path(&self.sources, name)?;
        let (gait, warnings) = read_any_gait(&file, &self.sources, &self.description)?;
        let described = &self.description;
        let derived = match gait {
            AnyGait::OnePhase(gait) => {
                compile_gait(described, &gait).map(|made| DerivedGait::OnePhase(Box::new((*gait, made))))
            }
            AnyGait::Phased(gait) => {
                compile_phases(described, &gait).map(|made| DerivedGait::Phased(Box::new((gait, made))))
            }
        };
        let derived = derived.map_err(|error| error.or_in_file(&file))?;
        Ok(RobotGait { derived, warnings, file })
    }
}

/// FNV-1a, 64 bits: enough to notice a change, the same on every machine.
pub fn fnv1a(text: &str) -> u64 {
    text.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
