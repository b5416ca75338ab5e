//! Everything that can be derived, by name.
mod list;

use super::Context;
use super::quantity::Quantity;
use crate::description::model::Phase;
use crate::program::Order;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::spelling::suggest;

/// What a function is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// The whole robot.
    Robot,
    /// One link or contact point.
    Frame,
    /// All contact points.
    Contacts,
    /// One phase of the description.
    Phase,
    /// One change from a phase to the next with an impact.
    Impact,
    /// The drive trains of the description.
    Drives,
    /// The swap of left and right that the description's phases ask for.
    Relabelling,
}

/// How a function is derived.
#[derive(Clone, Copy)]
pub enum Derivation {
    /// From the robot alone.
    Robot(for<'g, 't> fn(&Context<'g, 't>) -> Quantity<'g>),
    /// From the robot, where something can be missing.
    Analysed(for<'g, 't> fn(&Context<'g, 't>) -> Result<Quantity<'g>, Diagnostic>),
    /// For one frame.
    Frame(for<'g, 't> fn(&Context<'g, 't>, &crate::tree::Frame) -> Quantity<'g>),
    /// For one phase.
    Phase(for<'g, 't> fn(&Context<'g, 't>, &Phase) -> Result<Quantity<'g>, Diagnostic>),
}

/// One function of the catalogue.
#[derive(Clone, Copy)]
pub struct Entry {
    /// Its name in code, on the command line and in `biped.toml`.
    pub name: &'static str,
    /// What it is: symbol, frame, sign.
    pub summary: &'static str,
    /// Where the equation stands.
    pub source: &'static str,
    /// What it is about.
    pub scope: Scope,
    /// Order of execution that measured fastest.
    pub order: Order,
    /// Emitted in an order that counts registers, both limbs' work as one, see [`Function::by_pairs`](super::Function::by_pairs).
    pub by_pairs: bool,
    /// Not emitted unless the description names it: another function holds it already.
    pub on_demand: bool,
    /// Most entries are zero in every state: code holds the others alone, too.
    pub packed: bool,
    derivation: Derivation,
}

impl Entry {
    const fn robot(
        name: &'static str,
        source: &'static str,
        summary: &'static str,
        derive: for<'g, 't> fn(&Context<'g, 't>) -> Quantity<'g>,
    ) -> Self {
        Self {
            name,
            summary,
            source,
            scope: Scope::Robot,
            order: Order::Derivation,
            by_pairs: false,
            on_demand: false,
            packed: false,
            derivation: Derivation::Robot(derive),
        }
    }
    const fn analysed(
        name: &'static str,
        source: &'static str,
        summary: &'static str,
        derive: for<'g, 't> fn(&Context<'g, 't>) -> Result<Quantity<'g>, Diagnostic>,
    ) -> Self {
        let derivation = Derivation::Analysed(derive);
        Self {
            name,
            summary,
            source,
            scope: Scope::Robot,
            order: Order::DepthFirst,
            by_pairs: false,
            on_demand: false,
            packed: false,
            derivation,
        }
    }
    const fn contacts(
        name: &'static str,
        source: &'static str,
        summary: &'static str,
        derive: for<'g, 't> fn(&Context<'g, 't>) -> Quantity<'g>,
    ) -> Self {
        Self {
            name,
            summary,
            source,
            scope: Scope::Contacts,
            order: Order::Derivation,
            by_pairs: false,
            on_demand: false,
            packed: false,
            derivation: Derivation::Robot(derive),
        }
    }
    const fn frame(
        name: &'static str,
        summary: &'static str,
        derive: for<'g, 't> fn(&Context<'g, 't>, &crate::tree::Frame) -> Quantity<'g>,
    ) -> Self {
        let source = "forward kinematics";
        Self {
            name,
            summary,
            source,
            scope: Scope::Frame,
            order: Order::Derivation,
            by_pairs: false,
            on_demand: false,
            packed: false,
            derivation: Derivation::Frame(derive),
        }
    }

    const fn on_demand(mut self) -> Self {
        self.on_demand = true;
        self
    }

    const fn packed(mut self) -> Self {
        self.packed = true;
        self
    }

    const fn ordered(mut self, order: Order) -> Self {
        self.order = order;
        self
    }

    const fn by_pairs(mut self) -> Self {
        self.by_pairs = true;
        self
    }

    const fn scoped(mut self, scope: Scope) -> Self {
        self.scope = scope;
        self
    }

    const fn phase(
        name: &'static str,
        source: &'static str,
        summary: &'static str,
        scope: Scope,
        derive: for<'g, 't> fn(&Context<'g, 't>, &Phase) -> Result<Quantity<'g>, Diagnostic>,
    ) -> Self {
        let derivation = Derivation::Phase(derive);
        Self {
            name,
            summary,
            source,
            scope,
            order: Order::DepthFirst,
            by_pairs: false,
            on_demand: false,
            packed: false,
            derivation,
        }
    }

    /// Whether it depends on more than the base parameters of the equations of motion on any base.
    pub fn needs_whole_robot(&self) -> bool {
        const WHOLE: [&str; 5] = ["center_of_mass", "momentum", "centroidal", "zero_moment", "ground_wrench"];
        let regressor = self.name.ends_with("_regressor");
        !regressor
            && (self.name == "potential_energy" || WHOLE.iter().any(|name| self.name.starts_with(name)))
    }

    /// Derives the function.
    ///
    /// # Errors
    /// A frame that the robot does not have, or none where one is needed.
    pub fn derive<'g>(
        &self,
        context: &Context<'g, '_>,
        subject: Option<&str>,
    ) -> Result<Quantity<'g>, Diagnostic> {
        match (self.derivation, subject) {
            (Derivation::Robot(derive), _) => Ok(derive(context)),
            (Derivation::Analysed(derive), _) => derive(context),
            (Derivation::Frame(derive), Some(name)) => {
                let tree = context.folded.tree;
                let frame = tree.frame(name).ok_or_else(|| unknown_frame(context, name))?;
                Ok(derive(context, frame))
            }
            (Derivation::Phase(derive), name) => derive(context, find_phase(context, self.name, name)?),
            (Derivation::Frame(_), None) => {
                Err(Diagnostic::error(format!("`{}` is about one frame", self.name))
                    .help("name it with --link NAME or --point FOOT/POINT"))
            }
        }
    }
}

fn find_phase<'t>(
    context: &Context<'_, 't>,
    function: &str,
    name: Option<&str>,
) -> Result<&'t Phase, Diagnostic> {
    let phases = &context.description.phases;
    phases.iter().find(|phase| Some(phase.name.as_str()) == name).ok_or_else(|| {
        let known: Vec<&str> = phases.iter().map(|phase| phase.name.as_str()).collect();
        let what =
            name.map_or_else(|| format!("`{function}` is about one phase"), |n| format!("no phase `{n}`"));
        Diagnostic::error(what).help(if known.is_empty() {
            "the description has no [[phase]]; add them to biped.toml".to_owned()
        } else {
            format!("name it with --phase; phases are: {}", known.join(", "))
        })
    })
}

fn unknown_frame(context: &Context<'_, '_>, name: &str) -> Diagnostic {
    let tree = context.folded.tree;
    let known: Vec<&str> = tree.links.iter().chain(&tree.points).map(|f| f.name.as_str()).collect();
    Diagnostic::error(format!("`{name}` is neither a link nor a contact point of `{}`", tree.name))
        .help(format!("known are: {}", known.join(", ")))
}

/// The entry of a name and what it is about: `jacobian_of_tool`, `impact_map_of_single_support`, or a whole family.
///
/// # Errors
/// There is no such function.
pub fn entry_and_subject(name: &str) -> Result<(&'static Entry, Option<&str>), Diagnostic> {
    let whole = entry(name).map(|entry| (entry, None));
    let parts = name.match_indices("_of_").map(|(at, of)| (&name[..at], &name[at + of.len()..]));
    // `center_of_mass` has an `_of_` of its own.
    let about = |(family, subject)| {
        let entry = entry(family).ok()?;
        matches!(entry.scope, Scope::Frame | Scope::Phase | Scope::Impact).then_some((entry, Some(subject)))
    };
    whole.or_else(|error| parts.filter_map(about).next().ok_or(error))
}

/// The entry with this name.
///
/// # Errors
/// There is none: the message lists all.
pub fn entry(name: &str) -> Result<&'static Entry, Diagnostic> {
    catalogue().iter().find(|entry| entry.name == name).ok_or_else(|| {
        let known: Vec<&str> = catalogue().iter().map(|entry| entry.name).collect();
        let help = suggest(name, known.iter().copied(), || format!("functions are: {}", known.join(", ")));
        Diagnostic::error(format!("there is no function `{name}`")).help(help)
    })
}

/// All functions, in the order in which they are emitted.
pub fn catalogue() -> &'static [Entry] {
    list::CATALOGUE
}
