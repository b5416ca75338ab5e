//! Nanoseconds per call of generated code on the peers' robots.
//!
//! `cargo bench --bench speed` prints a table on random states. As `PROGRAM MODELS_FOLDER ROBOT` it reads the
//! peers' states and prints one JSON line per function, for one table of all in one run (see
//! `benches/README.md`). Build with `RUSTFLAGS="-C target-cpu=native"`, as the peers are.
#![allow(missing_docs)]
mod harness;

use bipedc_macros::Biped;
use bipedc_runtime::lanes::F64Native;
use bipedc_runtime::nalgebra::SMatrix;
use harness::{Bench, State, apart, lanes, used};

/// Lanes of one register.
const LANES: usize = size_of::<F64Native>() / 8;

#[derive(Biped)]
#[biped(description = "benches/robots/lower12", functions = [
    "inverse_dynamics", "mass_matrix", "mass_matrix_upper", "bias", "gravity", "forward_dynamics",
    "center_of_mass_with_jacobian", "center_of_mass_motion", "centroidal_momentum",
    "centroidal_momentum_with_matrix", "zero_moment_point", "body_jacobian_of_left_foot", "inverse_dynamics_regressor",
    "inverse_dynamics_derivatives", "forward_dynamics_derivatives", "constrained_dynamics", "impact_map",
])]
pub struct Lower12;

#[derive(Biped)]
#[biped(description = "benches/robots/rabbit5", functions = [
    "inverse_dynamics", "mass_matrix", "mass_matrix_upper", "bias", "gravity", "forward_dynamics",
    "center_of_mass_with_jacobian", "center_of_mass_motion", "centroidal_momentum",
    "centroidal_momentum_with_matrix", "inverse_dynamics_regressor", "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives", "constrained_dynamics", "impact_map_of_right_support", "body_jacobian_of_left_tibia",
])]
pub struct Rabbit5;

#[derive(Biped)]
#[biped(description = "benches/robots/biped7", functions = [
    "inverse_dynamics", "mass_matrix", "mass_matrix_upper", "bias", "gravity", "forward_dynamics",
    "center_of_mass_with_jacobian", "center_of_mass_motion", "centroidal_momentum",
    "centroidal_momentum_with_matrix", "inverse_dynamics_regressor", "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives", "constrained_dynamics", "impact_map_of_right_heel", "body_jacobian_of_left_foot",
])]
pub struct Biped7;

/// Somebody else's robot, whose URDF is not part of this repository: `benches/README.md` says how to time it.
#[cfg(talos_reduced)]
#[derive(Biped)]
#[biped(description = "benches/robots/talos_reduced", functions = [
    "inverse_dynamics", "mass_matrix", "mass_matrix_upper", "bias", "gravity", "forward_dynamics",
    "center_of_mass_with_jacobian", "center_of_mass_motion", "centroidal_momentum",
    "centroidal_momentum_with_matrix", "body_jacobian_of_leg_left_6_link", "inverse_dynamics_regressor",
    "inverse_dynamics_derivatives", "forward_dynamics_derivatives", "constrained_dynamics", "impact_map",
])]
pub struct TalosReduced;

/// A type of the function's name, by which `spills.sh` finds the function.
macro_rules! named {
    ($function:ident) => {
        #[allow(non_camel_case_types)]
        struct $function;
    };
}

/// Times `module::function(arguments)` of one state; with `lanes` also of a register full of states.
macro_rules! time {
    ($bench:ident, $states:ident, $peer:literal, $module:ident::$function:ident($($argument:ident),*)) => {{
        let mut out = SMatrix::repeat(0.0);
        let mut one = |k: usize| {
            let s = &$states[k];
            $module::$function($(&s.$argument,)* &mut out);
            used(&mut out);
        };
        named!($function);
        $bench.time($peer, |k| apart::<$function, false>(&mut one, k), LANES, None);
    }};
    ($bench:ident, $states:ident, $wide:ident, $peer:literal, $module:ident::$function:ident($($argument:ident),*)) => {{
        let mut out = SMatrix::repeat(0.0);
        let mut one = |k: usize| {
            let s = &$states[k];
            $module::$function($(&s.$argument,)* &mut out);
            used(&mut out);
        };
        let mut wide_out = SMatrix::repeat($wide[0].q[0]);
        let mut many = |k: usize| {
            let s = &$wide[k];
            $module::$function($(&s.$argument,)* &mut wide_out);
            used(&mut wide_out);
        };
        named!($function);
        let mut many = |k: usize| apart::<$function, true>(&mut many, k);
        $bench.time($peer, |k| apart::<$function, false>(&mut one, k), LANES, Some(&mut many));
    }};
}

/// The functions that every robot has.
macro_rules! common {
    ($bench:ident, $module:ident, $model:expr) => {{
        let states: Vec<State<f64, { $module::NQ }, { $module::NV }>> = $bench.states(&$model);
        let wide: Vec<State<F64Native, { $module::NQ }, { $module::NV }>> =
            lanes::<_, LANES, { $module::NQ }, { $module::NV }>(&states, F64Native::from_array);
        time!($bench, states, wide, "rnea", $module::inverse_dynamics_into(q, v, a));
        time!($bench, states, wide, "crba", $module::mass_matrix_upper_nonzeros_into(q));
        time!($bench, states, "crba_full", $module::mass_matrix_into(q));
        time!($bench, states, wide, "nle", $module::bias_into(q, v));
        time!($bench, states, wide, "gravity", $module::gravity_into(q));
        time!($bench, states, wide, "aba", $module::forward_dynamics_into(q, v, tau));
        time!($bench, states, wide, "com_jac", $module::center_of_mass_with_jacobian_into(q));
        time!($bench, states, wide, "com_pva", $module::center_of_mass_motion_into(q, v, a));
        time!($bench, states, wide, "centroidal", $module::centroidal_momentum_into(q, v));
        time!($bench, states, wide, "ccrba", $module::centroidal_momentum_with_matrix_into(q, v));
        time!($bench, states, wide, "regressor", $module::inverse_dynamics_regressor_nonzeros_into(q, v, a));
        time!($bench, states, "regressor_dense", $module::inverse_dynamics_regressor_into(q, v, a));
        time!($bench, states, wide, "d_rnea", $module::inverse_dynamics_derivatives_into(q, v, a));
        time!($bench, states, wide, "d_aba", $module::forward_dynamics_derivatives_into(q, v, tau));
        (states, wide)
    }};
}

/// One foot on one point; in the plane two of the three rows are there.
macro_rules! on_a_point {
    ($name:literal, $module:ident, $model:expr, $dynamics:ident, $impact:ident, $jacobian:ident) => {
        if let Some(bench) = Bench::new($name) {
            let (states, wide) = common!(bench, $module, $model);
            time!(bench, states, wide, "joint_jac", $module::$jacobian(q));
            time!(bench, states, wide, "contact3_fd", $module::$dynamics(q, v, tau));
            time!(bench, states, wide, "contact3_impulse", $module::$impact(q, v));
        }
    };
}

fn lower12_functions() {
    let Some(bench) = Bench::new("lower12") else { return };
    let (states, wide) = common!(bench, lower12, Lower12);
    time!(bench, states, "zmp", lower12::zero_moment_point_into(q, v, a));
    time!(bench, states, wide, "joint_jac", lower12::body_jacobian_of_left_foot_nonzeros_into(q));
    time!(bench, states, wide, "contact3_fd", lower12::constrained_dynamics_of_right_point_into(q, v, tau));
    time!(bench, states, wide, "contact3_impulse", lower12::impact_map_of_right_point_into(q, v));
    time!(bench, states, wide, "contact6_fd", lower12::constrained_dynamics_of_right_support_into(q, v, tau));
    time!(bench, states, wide, "contact6_impulse", lower12::impact_map_of_right_support_into(q, v));
}

#[cfg(talos_reduced)]
fn talos_reduced_functions() {
    let Some(bench) = Bench::new("talos_reduced") else { return };
    let (states, wide) = common!(bench, talos_reduced, TalosReduced);
    time!(bench, states, wide, "joint_jac", talos_reduced::body_jacobian_of_leg_left_6_link_nonzeros_into(q));
    time!(
        bench,
        states,
        wide,
        "contact3_fd",
        talos_reduced::constrained_dynamics_of_left_point_into(q, v, tau)
    );
    time!(bench, states, wide, "contact3_impulse", talos_reduced::impact_map_of_left_point_into(q, v));
    time!(
        bench,
        states,
        wide,
        "contact6_fd",
        talos_reduced::constrained_dynamics_of_left_support_into(q, v, tau)
    );
    time!(bench, states, wide, "contact6_impulse", talos_reduced::impact_map_of_left_support_into(q, v));
}

fn rabbit5_functions() {
    on_a_point!(
        "rabbit5",
        rabbit5,
        Rabbit5,
        constrained_dynamics_of_right_support_into,
        impact_map_of_right_support_into,
        body_jacobian_of_left_tibia_nonzeros_into
    );
}

fn biped7_functions() {
    on_a_point!(
        "biped7",
        biped7,
        Biped7,
        constrained_dynamics_of_right_heel_into,
        impact_map_of_right_heel_into,
        body_jacobian_of_left_foot_nonzeros_into
    );
}

fn main() {
    lower12_functions();
    #[cfg(talos_reduced)]
    talos_reduced_functions();
    rabbit5_functions();
    biped7_functions();
}
