//! Everything that can be derived, by name.
use super::families::{contacts, drives, regressors};
use super::quantity::Quantity;
use super::{Context, families};
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
            on_demand: false,
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
        Self { name, summary, source, scope, order: Order::DepthFirst, on_demand: false, derivation }
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
        "center_of_mass_with_jacobian",
        "(4.35)",
        "Centre of mass (first column) and its Jacobian with respect to `v`, together, world axes.",
        families::center_of_mass_with_jacobian,
    )
    .on_demand(),
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
        "ground_wrench",
        "(4.40)–(4.42)",
        "Force and moment about the world's origin that the ground has to provide, world axes.",
        families::ground_wrench,
    ),
    Entry::analysed(
        "inertial_parameters",
        "(5.1)",
        "Ten parameters per body, in the frame of its main link and about its origin.",
        regressors::values,
    ),
    Entry::analysed(
        "base_parameters",
        "(5.2)",
        "Base parameters of the equations of motion: all that the inverse dynamics depends on.",
        regressors::base_values,
    ),
    Entry::analysed(
        "inverse_dynamics_regressor",
        "(5.1)",
        "Regressor of the inverse dynamics: `regressor · inertial_parameters = tau`.",
        regressors::inverse_dynamics,
    ),
    Entry::analysed(
        "inverse_dynamics_base_regressor",
        "(5.2)",
        "Base regressor of the inverse dynamics: `regressor · base_parameters = tau`, of full column rank.",
        regressors::inverse_dynamics_base,
    ),
    Entry::analysed(
        "energy_regressor",
        "(5.1), (4.36), (4.37)",
        "Regressor of kinetic and potential energy.",
        regressors::energy,
    ),
    Entry::analysed(
        "center_of_mass_regressor",
        "(5.19)",
        "Regressor of total mass times centre of mass, world axes.",
        regressors::center_of_mass,
    ),
    Entry::analysed(
        "ground_wrench_regressor",
        "(5.26)–(5.29)",
        "Regressor of the ground's wrench about the world's origin, whose ratios are the zero moment point.",
        regressors::ground_wrench,
    ),
    Entry::contacts(
        "contact_distances",
        "κ_N of (4.2)",
        "Heights of the contact points above the ground z = 0.",
        contacts::distances,
    ),
    Entry::contacts(
        "contact_positions",
        "κ_T of (4.3)",
        "Tangential positions of the contact points, world axes (planar: x alone).",
        contacts::positions,
    ),
    Entry::contacts(
        "contact_normal_directions",
        "W_N of (4.6), corrected",
        "`W_N`: `W_Nᵀ v` are the normal velocities of the contact points, `W_N λ_N` their generalised force.",
        contacts::normal_directions,
    ),
    Entry::contacts(
        "contact_tangential_directions",
        "W_T of (4.6), corrected",
        "`W_T`: `W_Tᵀ v` are the tangential velocities of the contact points, `W_T λ_T` their generalised force.",
        contacts::tangential_directions,
    ),
    Entry::contacts(
        "contact_normal_rate",
        "w_N = (d/dt W_Nᵀ) v",
        "Normal accelerations of the contact points when `a = 0`.",
        contacts::normal_rate,
    ),
    Entry::contacts(
        "contact_tangential_rate",
        "w_T = (d/dt W_Tᵀ) v",
        "Tangential accelerations of the contact points when `a = 0`.",
        contacts::tangential_rate,
    ),
    Entry::phase(
        "constrained_dynamics",
        "(4.23), Table 4.1, corrected",
        "Accelerations of a phase under its contacts, then the contact forces λ: `D a + H = tau + W λ`, `Wᵀ a + w = 0`.",
        Scope::Phase,
        contacts::constrained_dynamics,
    ),
    Entry::phase(
        "impact_map",
        "(4.20)–(4.22), corrected",
        "Velocity just after the impact that ends a phase, then the impulses; legs keep their names.",
        Scope::Impact,
        contacts::impact_map,
    ),
    Entry::analysed(
        "relabelled_configuration",
        "R of (4.19b), corrected",
        "Configuration after left and right have swapped their roles.",
        contacts::relabelled_configuration,
    )
    .scoped(Scope::Relabelling),
    Entry::analysed(
        "relabelled_velocity",
        "R of (4.19b), corrected",
        "Velocity after left and right have swapped their roles.",
        contacts::relabelled_velocity,
    )
    .scoped(Scope::Relabelling),
    Entry::robot(
        "drive_regressor",
        "(5.10) without Coulomb friction",
        "Regressor of the motor torques less the rotors' share: viscous frictions, then spring stiffnesses.",
        drives::regressor,
    )
    .scoped(Scope::Drives),
    Entry::robot(
        "drive_inverse_dynamics",
        "(4.26), (4.30)",
        "Generalised forces for an acceleration, with the rotor inertias of stiff drives reflected through their gears.",
        drives::inverse_dynamics,
    )
    .scoped(Scope::Drives),
    Entry::robot(
        "spring_torques",
        "(4.29b)",
        "Torques on the joints by the springs of elastic drives, and by springs and dampers of passive joints.",
        drives::spring_torques,
    )
    .scoped(Scope::Drives),
    Entry::robot(
        "gear_torques",
        "(4.29a)",
        "Torques of elastic drives at the gears' outputs.",
        drives::gear_torques,
    )
    .scoped(Scope::Drives),
    Entry::robot(
        "motor_torques",
        "(4.26), (4.31) without Coulomb friction",
        "Torques at the motor shafts; add the Coulomb friction times the sign of the motor's velocity.",
        drives::motor_torques,
    )
    .scoped(Scope::Drives),
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
