//! A gait of several phases beside its robot.
use super::super::layout;
use super::super::model::{Options, items};
use super::super::package::type_name;
use super::super::text::Text;
use super::{GaitCode, RUNTIME, effort_limits, introduction, parameters, robot};
use crate::compile::{CompiledPhases, identifier};
use crate::description::gait::PhasedGait;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{PhaseLayout, PhaseSurfaceLayout, PhasedLayout, StandingFoot};

/// Emits a gait of several phases, its programs split as those of the robot.
///
/// # Errors
/// A function is missing: a fault of the compiler.
pub fn phases_code(
    compiled: &CompiledPhases,
    gait: &PhasedGait,
    split_above: Option<usize>,
) -> Result<GaitCode, Diagnostic> {
    let type_name = format!("{}Gait", type_name(&identifier(&gait.name)));
    let usual = Options::new(&type_name);
    let options = Options { split_above: split_above.unwrap_or(usual.split_above), ..usual };
    let mut text = Text::default();
    robot((&compiled.model.name, &gait.name), (&type_name, "PhasedGait"), &mut text);
    text.lines(&items(&compiled.model, &options));
    text.line("");
    constants(compiled, gait, &mut text)?;
    text.line("");
    implementation(&type_name, &mut text);
    Ok(GaitCode {
        name: gait.name.clone(),
        module: format!("gait_{}", identifier(&gait.name)),
        inputs: format!("{gait:?}"),
        documentation: documentation(compiled, gait),
        items: text.finish(),
        type_name,
        phase: Default::default(),
        closed: false,
        walk: None,
    })
}

fn documentation(compiled: &CompiledPhases, gait: &PhasedGait) -> Vec<String> {
    let head = format!(
        "Gait `{}` of `{}` in {} phases: virtual constraints and Lie derivatives on the dynamics of each.",
        gait.name,
        compiled.model.name,
        gait.phases.len()
    );
    let mut all = introduction(head, compiled.description.gravity, &gait.parameters);
    all.extend(compiled.model.functions.chunk_by(|f, g| f.family == g.family).map(layout::in_the_list));
    all
}

/// What a controller has to know.
fn constants(compiled: &CompiledPhases, gait: &PhasedGait, text: &mut Text) -> Result<(), Diagnostic> {
    let sizes = compiled.layout(gait);
    let PhasedLayout { parameters: count, joints, phases, outputs, forces, friction, least_push } = sizes;
    text.doc("///", "Sizes of the gait.");
    text.open(&format!("pub const LAYOUT: {RUNTIME}::PhasedLayout = {RUNTIME}::PhasedLayout {{"));
    let sizes = [
        ("parameters", count),
        ("joints", joints),
        ("phases", phases),
        ("outputs", outputs),
        ("forces", forces),
    ];
    sizes.iter().for_each(|(name, value)| text.line(&format!("{name}: {value},")));
    text.line(&format!("friction: {friction:?},"));
    text.line(&format!("least_push: {least_push:?},"));
    text.close("};");
    text.doc(
        "///",
        "Length of `parameters`: φ, φ₊, φ₋, gait parameters, value and slope of each output's h_p.",
    );
    text.line("pub const ARGUMENTS: usize = LAYOUT.arguments();");
    text.doc("///", "The phases, in the order in which they follow each other.");
    text.open(&format!("pub const PHASES: [{RUNTIME}::PhaseLayout; {phases}] = ["));
    for index in 0..phases {
        phase(&compiled.phase(gait, index)?, text);
    }
    text.close("];");
    parameters(&gait.parameters, text);
    effort_limits(&compiled.effort_limits(), text);
    Ok(())
}

fn phase(of: &PhaseLayout, text: &mut Text) {
    text.open(&format!("{RUNTIME}::PhaseLayout {{"));
    for (name, value) in [
        ("phase", of.phase),
        ("outputs", of.outputs),
        ("forces", of.forces),
        ("controlled", of.controlled),
        ("wanted", of.wanted),
        ("end", of.end),
        ("feedforward", of.feedforward),
        ("lie_derivatives", of.lie_derivatives),
    ] {
        text.line(&format!("{name}: {value},"));
    }
    let PhaseSurfaceLayout { held, equations, slopes, rates, curvatures } = of.surface;
    text.line(&format!(
        "surface: {RUNTIME}::PhaseSurfaceLayout {{ held: {held}, equations: {equations}, slopes: {slopes}, rates: {rates}, curvatures: {curvatures} }},"
    ));
    text.line(&format!("rate_ratio: {},", of.rate_ratio));
    text.line(&format!("impact_matching: {},", of.impact_matching));
    text.line(&format!("feedback: {:?},", of.feedback));
    text.open("feet: [");
    of.feet.iter().for_each(|foot| text.line(&format!("{},", standing(foot.as_ref()))));
    text.close("],");
    text.close("},");
}

/// As it stands in Rust.
fn standing(foot: Option<&StandingFoot>) -> String {
    let Some(StandingFoot { force, moment, sole, holds, level }) = foot else { return "None".to_owned() };
    format!(
        "Some({RUNTIME}::StandingFoot {{ force: {force:?}, moment: {moment:?}, sole: {sole:?}, holds: {holds}, level: {level:?} }})"
    )
}

fn implementation(type_name: &str, text: &mut Text) {
    text.open(&format!(
        "impl<R: ::bipedc_runtime::Real> {RUNTIME}::PhasedGait<R> for {} {{",
        super::super::ident(type_name)
    ));
    text.lines(ACCESSORS);
    text.close("}");
}

/// What `PhasedGait` asks.
const ACCESSORS: &str = "\
type Memory = [R; LAYOUT.memory()];
fn memory(&self) -> Self::Memory {
    [R::constant(0.0); LAYOUT.memory()]
}
fn layout(&self) -> ::bipedc_runtime::control::PhasedLayout {
    LAYOUT
}
fn phase(&self, index: usize) -> Option<::bipedc_runtime::control::PhaseLayout> {
    PHASES.get(index).copied()
}
fn parameter(&self, index: usize) -> Option<::bipedc_runtime::control::GaitParameter<'_>> {
    PARAMETERS.get(index).copied()
}
fn effort_limit(&self, joint: usize) -> Option<f64> {
    EFFORT_LIMITS.get(joint).copied().flatten()
}
";
