//! Names of values in emitted code.
use crate::compile::{CompiledModel, distinct, identifier};
use crate::program::Operand;
use bipedc_runtime::Argument;

/// Names of all elements of all arguments.
#[derive(Debug)]
pub struct Names {
    inputs: [Vec<String>; Argument::COUNT],
}

impl Names {
    /// By joints, base coordinates and contact points: `q_base_x`, `v_left_knee`, `f_left_foot_toe_z`.
    pub fn new(model: &CompiledModel) -> Self {
        Self { inputs: Argument::ALL.map(|argument| inputs(model, argument)) }
    }

    /// An element of an argument.
    pub fn input(&self, argument: Argument, index: u32) -> &str {
        &self.inputs[argument as usize][index as usize]
    }
}

/// What is before the names of an argument's elements. No other value's name has an underscore after these letters.
fn prefix(argument: Argument) -> &'static str {
    match argument {
        Argument::Q => "q",
        Argument::V => "v",
        Argument::A => "a",
        Argument::Tau => "tau",
        Argument::Forces => "f",
        Argument::Parameters => "p",
        Argument::MotorQ => "mq",
        Argument::MotorV => "mv",
        Argument::MotorA => "ma",
    }
}

fn inputs(model: &CompiledModel, argument: Argument) -> Vec<String> {
    let tree = &model.tree;
    let elements: Vec<String> = match argument {
        Argument::Q => tree.coordinate_names(),
        Argument::V | Argument::A | Argument::Tau => tree.row_names(),
        Argument::Forces => {
            let of_point = |name: &String| ["x", "y", "z"].map(|axis| format!("{name}/{axis}"));
            tree.points.iter().flat_map(|point| of_point(&point.name)).collect()
        }
        // Their own names are formulas.
        Argument::Parameters => (0..model.run_time_parameters).map(|k| k.to_string()).collect(),
        Argument::MotorQ | Argument::MotorV | Argument::MotorA => {
            tree.joints.iter().map(|joint| joint.name.clone()).collect()
        }
    };
    let prefix = prefix(argument);
    distinct(elements.iter().map(|name| identifier(&format!("{prefix}_{name}"))))
}

/// Names of the angles of one program, as `sin_` and `cos_` put them behind.
pub fn angles(names: &Names, angles: &[Operand]) -> Vec<String> {
    let name = |(k, angle): (usize, &Operand)| match *angle {
        Operand::Input(argument, index) => names.input(argument, index).to_owned(),
        Operand::Value(value) => format!("t{value}"),
        _ => k.to_string(),
    };
    angles.iter().enumerate().map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Robot;
    use crate::description::SourceFiles;
    use std::collections::BTreeSet;
    use std::path::PathBuf;

    fn chain(joints: &[&str]) -> CompiledModel {
        let inertial = "<inertial><origin xyz=\"0.1 0 0\"/><mass value=\"1\"/>\
                        <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
        let links: String =
            (0..=joints.len()).map(|k| format!("<link name=\"l{k}\">{inertial}</link>")).collect();
        let joint = |(k, name): (usize, &&str)| {
            format!(
                "<joint name=\"{name}\" type=\"continuous\"><parent link=\"l{k}\"/><child link=\"l{}\"/>\
                 <axis xyz=\"0 1 0\"/></joint>",
                k + 1
            )
        };
        let joints: String = joints.iter().enumerate().map(joint).collect();
        let sources = SourceFiles {
            urdf_path: PathBuf::from("urdf"),
            urdf_text: format!("<robot name=\"chain\">{links}{joints}</robot>"),
            toml_path: PathBuf::from("toml"),
            toml_text: "[generate]\nfunctions = [\"inverse_dynamics\"]".to_owned(),
        };
        let (description, warnings) = sources.parse().unwrap();
        Robot { description, warnings, sources }.compile().unwrap()
    }

    #[test]
    fn any_joint_gives_names_of_its_own() {
        let model = chain(&["2dof", "日本", "_", "a b", "a_b", "a-b", "base/x", "fn", "A_B_2"]);
        let names = Names::new(&model);
        let mut seen = BTreeSet::new();
        for argument in [Argument::Q, Argument::V, Argument::A, Argument::Tau] {
            for name in &names.inputs[argument as usize] {
                assert!(syn::parse_str::<syn::Ident>(name).is_ok(), "{name}");
                assert!(seen.insert(name.clone()), "{name} twice");
            }
        }
        assert_eq!(names.input(Argument::Q, 0), "q_base_x");
        assert_eq!(names.input(Argument::V, 5), "v_base_angular_z");
        assert_eq!(names.input(Argument::V, 6), "v_2dof");
        assert_eq!(names.input(Argument::Tau, 10), "tau_a_b_2");
        // No local of another kind has such a name.
        let others = ["q", "v", "a", "tau", "out", "w", "sin", "cos", "motor_q", "motor_v", "motor_a", "t0"];
        assert!(others.iter().all(|other| !seen.contains(*other)));
    }
}
