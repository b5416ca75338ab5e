//! Everything that can be derived, by name.
use super::Context;
use super::families;
use super::quantity::Quantity;
use crate::program::Order;
use bipedc_runtime::diagnostic::Diagnostic;

/// What a function is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// The whole robot.
    Robot,
    /// One link or contact point.
    Frame,
    /// All contact points.
    Contacts,
}

/// How a function is derived.
#[derive(Clone, Copy)]
pub enum Derivation {
    /// From the robot alone.
    Robot(for<'g, 't> fn(&Context<'g, 't>) -> Quantity<'g>),
    /// For one frame.
    Frame(for<'g, 't> fn(&Context<'g, 't>, &crate::tree::Frame) -> Quantity<'g>),
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
    /// Not emitted unless the description names it: another function holds it already.
    pub on_demand: bool,
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
            on_demand: false,
            derivation: Derivation::Robot(derive),
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
            on_demand: false,
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
            on_demand: false,
            derivation: Derivation::Frame(derive),
        }
    }

    const fn on_demand(mut self) -> Self {
        self.on_demand = true;
        self
    }

    const fn ordered(mut self, order: Order) -> Self {
        self.order = order;
        self
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
            (Derivation::Frame(derive), Some(name)) => {
                let tree = context.folded.tree;
                let frame = tree.frame(name).ok_or_else(|| unknown_frame(context, name))?;
                Ok(derive(context, frame))
            }
            (Derivation::Frame(_), None) => {
                Err(Diagnostic::error(format!("`{}` is about one frame", self.name))
                    .help("name it with --link NAME or --point FOOT/POINT"))
            }
        }
    }
}

fn unknown_frame(context: &Context<'_, '_>, name: &str) -> Diagnostic {
    let tree = context.folded.tree;
    let known: Vec<&str> = tree.links.iter().chain(&tree.points).map(|f| f.name.as_str()).collect();
    Diagnostic::error(format!("`{name}` is neither a link nor a contact point of `{}`", tree.name))
        .help(format!("known are: {}", known.join(", ")))
}

/// The entry with this name.
///
/// # Errors
/// There is none: the message lists all.
pub fn entry(name: &str) -> Result<&'static Entry, Diagnostic> {
    catalogue().iter().find(|entry| entry.name == name).ok_or_else(|| {
        let known: Vec<&str> = catalogue().iter().map(|entry| entry.name).collect();
        Diagnostic::error(format!("there is no function `{name}`"))
            .help(format!("functions are: {}", known.join(", ")))
    })
}

/// All functions, in the order in which they are emitted.
pub fn catalogue() -> &'static [Entry] {
    CATALOGUE
}

const CATALOGUE: &[Entry] = &[
    Entry::robot(
        "inverse_dynamics",
        "(4.25), by Newton–Euler in body frames",
        "Generalised forces for an acceleration: `D a + H`.",
        families::inverse_dynamics,
    ),
    Entry::robot(
        "inverse_dynamics_with_forces",
        "(4.25), (4.13)",
        "Generalised forces for an acceleration under external forces at the contact points (world axes).",
        families::inverse_dynamics_with_forces,
    ),
    Entry::robot(
        "forward_dynamics",
        "(4.25), by factoring the mass matrix along the tree",
        "Accelerations under generalised forces: `D⁻¹ (tau − H)`.",
        families::forward_dynamics,
    ),
    Entry::robot(
        "forward_dynamics_with_forces",
        "(4.25), (4.13)",
        "Accelerations under generalised forces and external forces at the contact points (world axes).",
        families::forward_dynamics_with_forces,
    )
    .ordered(Order::DepthFirst),
    Entry::robot(
        "mass_matrix",
        "(4.19a), by composite rigid bodies",
        "Mass matrix `D`, symmetric, all entries.",
        families::mass_matrix,
    )
    .ordered(Order::Balanced),
    Entry::robot(
        "mass_matrix_upper",
        "(4.19a), by composite rigid bodies",
        "Mass matrix `D`, upper triangle; zeros below the diagonal.",
        families::mass_matrix_upper,
    )
    .ordered(Order::Balanced),
    Entry::robot(
        "coriolis_matrix",
        "(4.19a), Echeandia and Wensing 2021",
        "Coriolis matrix `C` with `C v = H − G`; `Ḋ − 2 C` is skew-symmetric.",
        families::coriolis_matrix,
    ),
    Entry::robot(
        "inverse_dynamics_derivatives",
        "Carpentier and Mansard 2018",
        "Derivatives of the inverse dynamics `[∂τ/∂q, ∂τ/∂v, ∂τ/∂a]`; q in its tangent space, right increment.",
        families::inverse_dynamics_derivatives,
    )
    .ordered(Order::DepthFirst),
    Entry::robot(
        "forward_dynamics_derivatives",
        "Carpentier and Mansard 2018",
        "Derivatives of the forward dynamics `[∂a/∂q, ∂a/∂v, ∂a/∂τ]`; q in its tangent space, right increment.",
        families::forward_dynamics_derivatives,
    ),
    Entry::robot(
        "inverse_dynamics_dq",
        "Carpentier and Mansard 2018",
        "`∂τ/∂q` alone; q in its tangent space, right increment.",
        families::inverse_dynamics_dq,
    )
    .on_demand()
    .ordered(Order::DepthFirst),
    Entry::robot(
        "inverse_dynamics_dv",
        "Carpentier and Mansard 2018",
        "`∂τ/∂v` alone; q in its tangent space, right increment.",
        families::inverse_dynamics_dv,
    )
    .on_demand()
    .ordered(Order::DepthFirst),
    Entry::robot(
        "forward_dynamics_dq",
        "Carpentier and Mansard 2018",
        "`∂a/∂q` alone; q in its tangent space, right increment.",
        families::forward_dynamics_dq,
    )
    .on_demand()
    .ordered(Order::DepthFirst),
    Entry::robot(
        "forward_dynamics_dv",
        "Carpentier and Mansard 2018",
        "`∂a/∂v` alone; q in its tangent space, right increment.",
        families::forward_dynamics_dv,
    )
    .on_demand()
    .ordered(Order::DepthFirst),
    Entry::robot(
        "forward_dynamics_dtau",
        "Carpentier and Mansard 2018",
        "`∂a/∂τ = D⁻¹` alone; q in its tangent space, right increment.",
        families::forward_dynamics_dtau,
    )
    .on_demand()
    .ordered(Order::DepthFirst),
    Entry::robot("bias", "(4.19a)", "Bias `H = C v + G`.", families::bias),
    Entry::robot("gravity", "(4.19a)", "Gravity's generalised forces `G`.", families::gravity),
    Entry::robot("kinetic_energy", "(4.36)", "Kinetic energy.", families::kinetic_energy),
    Entry::robot(
        "potential_energy",
        "(4.37)",
        "Potential energy, zero at the world's origin.",
        families::potential_energy,
    ),
    Entry::robot("center_of_mass", "(4.35)", "Centre of mass in the world.", families::center_of_mass),
    Entry::robot(
        "center_of_mass_jacobian",
        "(4.35)",
        "Jacobian of the centre of mass with respect to `v`, world axes.",
        families::center_of_mass_jacobian,
    ),
    Entry::robot(
        "center_of_mass_velocity",
        "(4.35)",
        "Velocity of the centre of mass, world axes.",
        families::center_of_mass_velocity,
    ),
    Entry::robot(
        "center_of_mass_acceleration",
        "(4.35)",
        "Acceleration of the centre of mass, world axes.",
        families::center_of_mass_acceleration,
    ),
    Entry::robot(
        "momentum",
        "(4.38), (4.39)",
        "Linear momentum ρ and angular momentum σ about the world's origin, world axes.",
        families::momentum,
    ),
    Entry::robot(
        "momentum_rate",
        "(4.40), (4.41 corrected)",
        "Rates of linear momentum ρ and of angular momentum σ about the world's origin, world axes.",
        families::momentum_rate,
    ),
    Entry::robot(
        "centroidal_momentum",
        "(4.38), (4.39)",
        "Linear momentum, and angular momentum about the centre of mass, world axes.",
        families::centroidal_momentum,
    ),
    Entry::robot(
        "centroidal_momentum_rate",
        "(4.40), (4.41 corrected)",
        "Rate of the centroidal momentum, world axes; gravity is not subtracted.",
        families::centroidal_momentum_rate,
    ),
    Entry::robot(
        "zero_moment_point",
        "(4.42)",
        "Zero moment point on the ground plane z = 0.",
        families::zero_moment_point,
    ),
    Entry::robot(
        "inverse_dynamics_regressor",
        "(5.1)",
        "Regressor of the inverse dynamics: `regressor · parameters = tau`; ten parameters per body.",
        families::inverse_dynamics_regressor,
    )
    .ordered(Order::DepthFirst),
    Entry::frame("position", "Position in the world.", families::position),
    Entry::frame("rotation", "Rotation: columns are the frame's axes in the world.", families::rotation),
    Entry::frame(
        "jacobian",
        "Jacobian with respect to `v` at the frame's origin, world axes, linear rows first.",
        families::jacobian,
    ),
    Entry::frame(
        "jacobian_rate_times_velocity",
        "Rate of the Jacobian times `v`: the frame's acceleration when `a = 0`, world axes.",
        families::jacobian_rate_times_velocity,
    ),
];
