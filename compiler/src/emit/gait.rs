//! A gait beside its robot: a module with its functions and with what a controller has to know of them, and an example that walks.
mod phased;
mod walk;

pub use phased::phases_code;
pub use walk::{PhasedWalk, WalkedPhase};

use super::layout;
use super::model::{Options, items};
use super::package::type_name;
use super::text::{Text, quoted};
use crate::compile::{CompiledGait, identifier};
use crate::description::gait::{Gait, GaitParameter};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{GaitLayout, StepEnd};

/// A gait as text.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitCode {
    /// As its file calls it.
    pub name: String,
    /// Name of its module: `gait_NAME`.
    pub module: String,
    /// Tells this gait from others, whatever their names.
    pub inputs: String,
    /// Paragraphs about the module.
    documentation: Vec<String>,
    /// What stands in it.
    pub items: String,
    type_name: String,
    /// Names of the constrained dynamics and of the impact map.
    phase: [String; 2],
    /// The constraint surface has a closed form, which the example walks along.
    closed: bool,
    /// What the example of a gait of several phases walks by.
    walk: Option<PhasedWalk>,
}

/// Emits a gait, its programs split as those of the robot.
///
/// # Errors
/// A function is missing: a fault of the compiler.
pub fn gait_code(
    compiled: &CompiledGait,
    gait: &Gait,
    split_above: Option<usize>,
) -> Result<GaitCode, Diagnostic> {
    let type_name = format!("{}Gait", type_name(&identifier(&gait.name)));
    let usual = Options::new(&type_name);
    let options = Options { split_above: split_above.unwrap_or(usual.split_above), ..usual };
    let layout = compiled.layout(gait)?;
    let function = |family: &str| {
        let found = compiled.model.functions.iter().find(|function| function.family == family);
        found.map_or_else(String::new, |function| function.name.clone())
    };
    let mut text = Text::default();
    robot((&compiled.model.name, &gait.name), (&type_name, "Gait"), &mut text);
    text.lines(&items(&compiled.model, &options));
    text.line("");
    constants(compiled, gait, &layout, &mut text);
    text.line("");
    implementation(&type_name, &mut text);
    Ok(GaitCode {
        name: gait.name.clone(),
        module: format!("gait_{}", identifier(&gait.name)),
        inputs: format!("{gait:?}"),
        documentation: documentation(compiled, gait),
        items: text.finish(),
        type_name,
        phase: ["constrained_dynamics", "impact_map"].map(function),
        closed: matches!(layout.step_end, StepEnd::Closed(_)),
        walk: None,
    })
}

impl GaitCode {
    /// What stands in a file of its own.
    pub(super) fn file(&self) -> String {
        let mut text = Text::default();
        for (k, paragraph) in self.documentation.iter().enumerate() {
            if k > 0 && !(paragraph.starts_with("- ") && self.documentation[k - 1].starts_with("- ")) {
                text.doc("//!", "");
            }
            text.doc("//!", paragraph);
        }
        text.line("");
        text.lines(&self.items);
        text.finish()
    }

    /// A module for others' files.
    pub(crate) fn inline(&self) -> String {
        let mut text = Text::default();
        text.doc("///", &self.documentation[0]);
        text.open(&format!("pub mod {} {{", self.module));
        text.lines(&self.items);
        text.close("}");
        text.finish()
    }

    /// The first paragraph about it.
    pub(super) fn summary(&self) -> &str {
        &self.documentation[0]
    }

    /// A program that walks by it, in the crate of this name, if T has a closed form or what several phases need is known.
    pub(super) fn example(&self, crate_name: &str) -> Option<String> {
        if let Some(walk) = &self.walk {
            return Some(self.phased_example(crate_name, walk));
        }
        if !self.closed {
            return None;
        }
        let Self { name, module, type_name, phase: [dynamics, impact], .. } = self;
        let mut text = Text::default();
        text.doc(
            "//!",
            &format!(
                "Ten steps by the gait `{}`, by the crate alone: the whole robot, its foot held by the ground, under the gait's \
                 controller; speeds at mid-stance against those that the zero dynamics say.",
                name
            ),
        );
        text.doc("//!", "");
        text.doc(
            "//!",
            "`cargo run --release --example walk [SPEED]`, the speed at mid-stance of the first step per s.",
        );
        text.line("use bipedc_runtime::control::{");
        text.line("    Controller, Feedback, Gait, GaitController, GaitLayout, JointCommand, Observation,");
        text.line("};");
        text.line("use bipedc_runtime::{Argument, Model, State};");
        text.line(&format!(
            "use {crate_name}::{module}::{{ARGUMENTS, JOINTS as NAMES, NQ, {type_name} as Robot}};"
        ));
        text.line("");
        text.line("const JOINTS: usize = NAMES.len();");
        text.line(&format!("const DYNAMICS: &str = {};", quoted(dynamics)));
        text.line(&format!("const IMPACT: &str = {};", quoted(impact)));
        text.lines(include_str!("walk_example.txt"));
        Some(text.finish())
    }
}

/// The type that stands for the robot with its gait.
fn robot((robot, gait): (&str, &str), (type_name, role): (&str, &str), text: &mut Text) {
    text.doc(
        "///",
        &format!(
            "Robot `{robot}` with its gait `{gait}`; implements `bipedc_runtime::Model` and `bipedc_runtime::control::{role}`."
        ),
    );
    text.line("#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]");
    text.line(&format!("pub struct {};", super::ident(type_name)));
    text.line("");
}

fn documentation(compiled: &CompiledGait, gait: &Gait) -> Vec<String> {
    let head = format!(
        "Gait `{}` of `{}`: virtual constraints, zero dynamics, Lie derivatives.",
        gait.name, compiled.model.name
    );
    let mut all = introduction(head, compiled.description.gravity, &gait.parameters);
    all.extend(compiled.model.functions.chunk_by(|f, g| f.family == g.family).map(layout::in_the_list));
    all
}

/// Paragraphs about a gait, down to the heading of its functions.
fn introduction(head: String, [x, y, z]: [f64; 3], parameters: &[GaitParameter]) -> Vec<String> {
    let mut all = vec![
        head,
        "Functions of the robot stand here again, because a gait has its own world (gravity, bodies). Legs are named by their roles: \
         the one that stands is the one that the phase of the description names, whichever it is."
            .to_owned(),
        format!("Gravity: {x}, {y}, {z} m/s²."),
        "`parameters`, length [`ARGUMENTS`]: φ, φ₊, φ₋, the gait parameters, then of each output the value and the slope of h_p \
         at φ₊. Gait parameters:"
            .to_owned(),
    ];
    let parameter = |GaitParameter { name, unit, meaning, default, bounds: [low, high] }: &GaitParameter| {
        format!("- `{name}` ({unit}), {default:?} of {low:?} to {high:?}: {meaning}.")
    };
    all.extend(parameters.iter().map(parameter));
    if parameters.is_empty() {
        all.push("- none.".to_owned());
    }
    all.push("# Functions".to_owned());
    all
}

const RUNTIME: &str = "::bipedc_runtime::control";

/// What a controller has to know.
fn constants(compiled: &CompiledGait, gait: &Gait, layout: &GaitLayout, text: &mut Text) {
    let GaitLayout { parameters: count, outputs, controlled, wanted, lie_derivatives, between, .. } = layout;
    text.doc("///", "Sizes of the gait, and places of its functions.");
    text.open(&format!("pub const LAYOUT: {RUNTIME}::GaitLayout = {RUNTIME}::GaitLayout {{"));
    for (name, value) in [
        ("parameters", count),
        ("outputs", outputs),
        ("controlled", controlled),
        ("wanted", wanted),
        ("lie_derivatives", lie_derivatives),
    ] {
        text.line(&format!("{name}: {value},"));
    }
    text.line(&format!("step_end: {},", step_end(layout.step_end)));
    text.line(&format!("between: {between:?},"));
    text.line(&format!("impact_matching: {},", layout.impact_matching));
    text.close("};");
    text.doc(
        "///",
        "Length of `parameters`: φ, φ₊, φ₋, gait parameters, value and slope of each output's h_p.",
    );
    text.line("pub const ARGUMENTS: usize = LAYOUT.arguments();");
    self::parameters(&gait.parameters, text);
    let posture: Vec<String> = compiled.posture(gait).iter().map(|x| format!("{x:?}")).collect();
    text.doc("///", "Where an iteration for the constraint surface begins.");
    text.list("pub const POSTURE: [f64; NQ] = [", &posture, "];");
    effort_limits(&compiled.effort_limits(), text);
}

/// The gait parameters.
fn parameters(parameters: &[GaitParameter], text: &mut Text) {
    text.doc("///", "The gait parameters, in their order.");
    text.open(&format!(
        "pub const PARAMETERS: [{RUNTIME}::GaitParameter<'static>; {}] = [",
        parameters.len()
    ));
    for GaitParameter { name, unit, default, bounds, .. } in parameters {
        let (name, unit) = (quoted(name), quoted(unit));
        text.line(&format!(
            "{RUNTIME}::GaitParameter {{ name: {name}, unit: {unit}, default: {default:?}, bounds: {bounds:?} }},"
        ));
    }
    text.close("];");
}

/// Limits of torques.
fn effort_limits(limits: &[Option<f64>], text: &mut Text) {
    let limits: Vec<String> = limits.iter().map(|limit| format!("{limit:?}")).collect();
    text.doc("///", "Largest torques of the joints (N m), where the description says one.");
    text.list(&format!("pub const EFFORT_LIMITS: [Option<f64>; {}] = [", limits.len()), &limits, "];");
}

/// As it stands in Rust.
fn step_end(of: StepEnd) -> String {
    let value = match of {
        StepEnd::Closed(function) => format!("Closed({function})"),
        StepEnd::Iterated { constraints, jacobian, guard } => {
            format!("Iterated {{ constraints: {constraints}, jacobian: {jacobian}, guard: {guard} }}")
        }
    };
    format!("{RUNTIME}::StepEnd::{value}")
}

fn implementation(type_name: &str, text: &mut Text) {
    text.open(&format!(
        "impl<R: ::bipedc_runtime::Real> {RUNTIME}::Gait<R> for {} {{",
        super::ident(type_name)
    ));
    text.lines(ACCESSORS);
    text.close("}");
}

/// What `Gait` asks.
const ACCESSORS: &str = "\
type Memory = [R; LAYOUT.memory()];
fn memory(&self) -> Self::Memory {
    [R::constant(0.0); LAYOUT.memory()]
}
fn layout(&self) -> ::bipedc_runtime::control::GaitLayout {
    LAYOUT
}
fn parameter(&self, index: usize) -> Option<::bipedc_runtime::control::GaitParameter<'_>> {
    PARAMETERS.get(index).copied()
}
fn posture(&self, index: usize) -> f64 {
    POSTURE.get(index).copied().unwrap_or(0.0)
}
fn effort_limit(&self, joint: usize) -> Option<f64> {
    EFFORT_LIMITS.get(joint).copied().flatten()
}
";
