//! An arm whose wrist couples two joints.
use crate::run::{Failure, Part, Program, failure, robot, text};
use crate::table::{read, write};
use bipedc_analysis::signal::Butterworth;
use std::fmt::Write as _;
use std::path::Path;

/// Rate of the recording, and cut-off of torques and positions, Hz.
const RATE: f64 = 5000.0;
const CUTOFF: f64 = 100.0;
/// Motor turns per turn of each joint, and the turns that joint 5 takes along in motor 6.
const GEARS: [f64; 6] = [32.0, 32.0, 45.0, -48.0, 45.0, 32.0];
const SHARED: f64 = 32.0;

const WORDS: &str = "\
Six-joint arm, 9 s, torques from motor currents (source: thanhndv212/figaroh-plus, Apache-2.0). Its wrist couples joints 5
and 6: `tau5 += Iam6 qdd6 + fvm6 qd6 + fsm6 sgn(qd5 + qd6)`, and the same with 5 and 6 exchanged. The description has
viscous and Coulomb friction, rotor inertia and an offset at every joint, without values (`--refit`), and nothing of the
wrist; the URDF is a frame, so that inertias are free. First half for training, second half judges; torques filtered at
100 Hz like the motion.

Known: 5.74 and 2.08 N m held out at joints 5 and 6 without the wrist's terms, 1.51 and 0.90 with them. Wanted: a coupling
of these joints first, at most 1.55 and 0.95 N m.";

/// Asks what is missing.
///
/// # Errors
/// Files that cannot be read or written; a refusal of the program.
pub fn run(data: &Path, folder: &Path, program: &Program) -> Result<Vec<Part>, Failure> {
    let data = data.join("staubli_tx40");
    let urdf = text(&data.join("tx40_mdh_modified.urdf"))?;
    let arm = robot(folder, &urdf, &description())?;
    let [q, tau] = joint_side(&data)?;
    let half = q[0].len() / 2;
    let time: Vec<f64> = (0..q[0].len()).map(|i| i as f64 / RATE).collect();
    let mut files = Vec::new();
    for (name, range) in [("train.csv", 0..half), ("test.csv", half..q[0].len())] {
        let mut columns = vec![("time".to_owned(), &time[range.clone()])];
        for j in 0..6 {
            columns.push((format!("joint_{}/position", j + 1), &q[j][range.clone()]));
            columns.push((format!("joint_{}/effort", j + 1), &tau[j][range.clone()]));
        }
        let file = folder.join(name);
        write(&file, &columns)?;
        files.push(file);
    }
    let named = [(&*arm, "tx40"), (&*files[0], "train.csv"), (&*files[1], "test.csv")];
    let options = ["--cutoff", "100", "--inertial", "free", "--refit"];
    let (command, answer) = program.diagnose(&named, &options)?;
    let measured = program.measure(&named, &options, &answer)?;
    Ok(vec![Part {
        title: "Staubli TX40: a coupled wrist",
        words: WORDS.to_owned(),
        command,
        answer,
        measured,
    }])
}

/// Fixed base; friction, rotor and offset everywhere, to be estimated.
fn description() -> String {
    let mut text = "[base]\nkind = \"fixed\"\n".to_owned();
    let kinds = [
        ("viscous_friction", "damping"),
        ("coulomb_friction", "torque"),
        ("rotor_inertia", "inertia"),
        ("torque_bias", "bias"),
    ];
    for joint in 1..=6 {
        for (kind, parameter) in kinds {
            // Writing into a string cannot fail.
            let _ =
                write!(text, "[[effect]]\nkind = \"{kind}\"\njoint = \"joint_{joint}\"\n{parameter} = 0.0\n");
        }
    }
    text
}

/// Positions (rad) and filtered torques (N m) at the joints, from those of the motors.
fn joint_side(data: &Path) -> Result<[Vec<Vec<f64>>; 2], Failure> {
    let mut q = read(&data.join("pos_read_data.csv"))?;
    let mut tau = read(&data.join("curr_data.csv"))?;
    if q.len() < 6 || tau.len() < 6 || q[0].len() != tau[0].len() {
        return Err(failure("the arm's positions and torques do not belong together"));
    }
    for j in 0..6 {
        q[j].iter_mut().for_each(|x| *x /= GEARS[j]);
        tau[j].iter_mut().for_each(|x| *x *= GEARS[j]);
    }
    for i in 0..q[0].len() {
        // Motor 6 turns with joint 5 as well, and its torque acts there.
        q[5][i] -= SHARED / GEARS[5] * q[4][i];
        tau[4][i] += SHARED / GEARS[5] * tau[5][i];
        q[1][i] -= std::f64::consts::FRAC_PI_2;
        q[2][i] += std::f64::consts::FRAC_PI_2;
    }
    let filter = Butterworth::new(CUTOFF, RATE).map_err(|e| failure(format!("{e:?}")))?;
    tau.iter_mut().for_each(|torque| *torque = filter.zero_phase(torque));
    Ok([q, tau])
}
