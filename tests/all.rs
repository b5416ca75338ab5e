//! All tests of the whole program but those that count allocations: one binary, so that what they share is compiled once and no
//! processor waits for the last test of each.
#![allow(missing_docs)]

#[path = "../src/commands/amend/parse.rs"]
#[allow(dead_code, unreachable_pub)]
mod amend_parse;
#[path = "support/cli.rs"]
#[allow(dead_code)]
mod cli;
mod support;

mod cli_amend;
mod cli_check;
mod cli_compare;
mod cli_diagnose;
mod cli_evaluate;
mod cli_excite;
mod cli_export;
mod cli_generate;
mod cli_generate_gait;
mod cli_help;
mod cli_inspect;
mod cli_log;
mod cli_separate;
mod cli_simulate;
mod cli_walk;
mod coloured_noise;
#[path = "compiled/main.rs"]
mod compiled;
#[path = "compiler/main.rs"]
mod compiler;
#[path = "corpus/main.rs"]
mod corpus;
mod described_again;
mod drives_of_arms;
#[path = "experiments/main.rs"]
mod experiments;
mod few_joints;
mod floors;
#[path = "free_run/main.rs"]
mod free_run;
#[path = "gait/main.rs"]
mod gait;
#[path = "ground/main.rs"]
mod ground;
mod hidden_effects;
#[path = "identify/main.rs"]
mod identify;
#[path = "identify_elastic/main.rs"]
mod identify_elastic;
mod late_torques;
#[path = "laws/main.rs"]
mod laws;
mod led_pendulum;
mod logs_page;
#[path = "loops/main.rs"]
mod loops;
mod missing_columns;
mod motor_side;
#[path = "../src/terminal/next.rs"]
#[allow(dead_code, unreachable_pub)]
mod next;
mod one_joint;
#[path = "phases/main.rs"]
mod phases;
mod point_feet;
mod point_to_point;
mod readme;
mod real_data;
#[path = "report_page/main.rs"]
mod report_page;
#[path = "reproduced/main.rs"]
mod reproduced;
mod shaken;
#[path = "simulated/main.rs"]
mod simulated;
mod slow_motion;
mod standing_robot;
#[path = "time_stepping/main.rs"]
mod time_stepping;
mod told_apart;
#[path = "walking/main.rs"]
mod walking;

// Where the example's modules look for one another.
use hidden_effects::generator;
use real_data::{run, table};
