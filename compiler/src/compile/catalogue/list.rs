//! All functions, in the order in which they are emitted.
use super::{Entry, Scope};
use crate::compile::families::{self, contacts, drives, regressors};
use crate::program::Order;

pub(super) const CATALOGUE: &[Entry] = &[
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
    )
    .by_pairs(),
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
    .ordered(Order::Balanced)
    .packed(),
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
        "center_of_mass_motion",
        "(4.35)",
        "Position, velocity and acceleration of the centre of mass, together, world axes.",
        families::center_of_mass_motion,
    )
    .by_pairs()
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
    )
    .by_pairs(),
    Entry::robot(
        "centroidal_momentum_matrix",
        "(4.38), (4.39)",
        "Centroidal momentum per unit of each element of `v`: `matrix · v = centroidal_momentum`.",
        families::centroidal_momentum_matrix,
    )
    .on_demand(),
    Entry::robot(
        "centroidal_momentum_with_matrix",
        "(4.38), (4.39)",
        "Centroidal momentum (first column) and its matrix with respect to `v`, together.",
        families::centroidal_momentum_with_matrix,
    )
    .on_demand(),
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
    )
    .packed(),
    Entry::analysed(
        "inverse_dynamics_base_regressor",
        "(5.2)",
        "Base regressor of the inverse dynamics: `regressor · base_parameters = tau`, of full column rank.",
        regressors::inverse_dynamics_base,
    )
    .packed(),
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
    )
    .packed(),
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
    )
    .by_pairs(),
    Entry::phase(
        "impact_map",
        "(4.20)–(4.22), corrected",
        "Velocity just after the impact that ends a phase, then the impulses; legs keep their names.",
        Scope::Impact,
        contacts::impact_map,
    )
    .by_pairs(),
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
        "body_jacobian",
        "Jacobian with respect to `v` at the frame's origin, in the frame's own axes, linear rows first.",
        families::body_jacobian,
    )
    .on_demand()
    .packed(),
    Entry::frame(
        "jacobian_rate_times_velocity",
        "Rate of the Jacobian times `v`: the frame's acceleration when `a = 0`, world axes.",
        families::jacobian_rate_times_velocity,
    ),
];
