//! The example of a gait of several phases: the whole robot, from event to event.
use super::super::text::{Text, quoted};
use super::GaitCode;

/// What the example of a gait of several phases has to know beyond the gait's module.
#[derive(Debug, Clone, PartialEq)]
pub struct PhasedWalk {
    /// q and v (as the model's) where a step of walking that repeats itself begins: the robot is named as the gait's first phase does.
    pub begin: [Vec<f64>; 2],
    /// Mean speed of that walking, m/s along x.
    pub speed: f64,
    /// In the order of the gait.
    pub phases: Vec<WalkedPhase>,
}

/// A phase as the example follows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WalkedPhase {
    /// Name of its constrained dynamics.
    pub dynamics: String,
    /// Contact points that land at its end, by the order of `contact_distances`; none: what stands is let go or tips.
    pub lands: Vec<usize>,
    /// Name of the map of the impact at its end, if there is one.
    pub impact: Option<String>,
    /// Left and right exchange their roles then.
    pub exchanges: bool,
}

impl GaitCode {
    /// The same with what the example of several phases needs; without, there is none.
    #[must_use]
    pub fn walking(self, walk: PhasedWalk) -> Self {
        Self { walk: Some(walk), ..self }
    }

    /// A program that walks by it through all its phases, in the crate of this name.
    pub(super) fn phased_example(&self, crate_name: &str, walk: &PhasedWalk) -> String {
        let Self { name, module, type_name, .. } = self;
        let mut text = Text::default();
        let about = format!(
            "Ten steps by the gait `{name}`, by the crate alone: the whole robot through all phases, under the gait's controller. Feet that \
             stand are held by the ground; a phase ends where a point lands, or where the ground no longer pushes on what is let go."
        );
        for words in [&about, "", "`cargo run --release --example walk`"] {
            text.doc("//!", words);
        }
        text.line("use bipedc_runtime::control::{Controller, JointCommand, Observation, PhasedController};");
        text.line("use bipedc_runtime::{Argument, Model, State};");
        text.line(&format!(
            "use {crate_name}::{module}::{{JOINTS as NAMES, NQ, PHASES, {type_name} as Robot}};"
        ));
        text.line("");
        text.lines(include_str!("../walk_phase.txt"));
        text.doc("///", "In the order of the gait.");
        text.line(&format!("const WALK: [Phase; {}] = [", walk.phases.len()));
        text.indent();
        walk.phases.iter().for_each(|phase| text.lines(&phase.literal()));
        text.unindent();
        text.line("];");
        text.doc("///", "q and v where a step of walking that repeats itself begins.");
        text.line("const BEGIN: State2 = [");
        text.indent();
        for part in &walk.begin {
            let numbers: Vec<String> = part.iter().map(|x| format!("{x:?}")).collect();
            text.list("[", &numbers, "],");
        }
        text.unindent();
        text.line("];");
        text.doc("///", "Mean speed of that walking, m/s.");
        text.line(&format!("const SPEED: f64 = {:?};", walk.speed));
        text.lines(include_str!("../walk_phases.txt"));
        text.finish()
    }
}

impl WalkedPhase {
    /// As it stands in Rust.
    fn literal(&self) -> String {
        let Self { dynamics, lands, impact, exchanges } = self;
        let impact =
            impact.as_ref().map_or_else(|| "None".to_owned(), |map| format!("Some({})", quoted(map)));
        format!(
            "Phase {{\n    dynamics: {},\n    lands: &{lands:?},\n    impact: {impact},\n    exchanges: {exchanges},\n}},\n",
            quoted(dynamics)
        )
    }
}
