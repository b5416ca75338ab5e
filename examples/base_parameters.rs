//! Base parameters of TUlip's centre of mass and zero moment point (thesis 5.4), in exact arithmetic.
//!
//! `cargo run --release --example base_parameters` prints a Markdown page: counts beside the thesis', and every sum.
#[path = "reproduction/mod.rs"]
mod reproduction;

use bipedc_compiler::exact::{BaseParameters, Model, ParameterList, Question};
use reproduction::{Failure, one, tulip};

/// A question, what is asked in words, and the thesis' number.
struct Case {
    words: &'static str,
    of: Model,
    rows: &'static [&'static str],
    flat: bool,
    thesis: &'static str,
}

const CASES: [Case; 8] = [
    Case {
        words: "centre of mass x, y, z; any posture",
        of: Model::CenterOfMass,
        rows: &["x", "y", "z"],
        flat: false,
        thesis: "27",
    },
    Case {
        words: "centre of mass x, y; any posture",
        of: Model::CenterOfMass,
        rows: &["x", "y"],
        flat: false,
        thesis: "",
    },
    Case {
        words: "centre of mass x, y; feet flat",
        of: Model::CenterOfMass,
        rows: &["x", "y"],
        flat: true,
        thesis: "25",
    },
    Case {
        words: "centre of mass x, y, z; feet flat",
        of: Model::CenterOfMass,
        rows: &["x", "y", "z"],
        flat: true,
        thesis: "",
    },
    Case {
        words: "moments Mx, My (centre of pressure times vertical force); any motion",
        of: Model::ZeroMomentPoint,
        rows: &["Mx", "My"],
        flat: false,
        thesis: "",
    },
    Case {
        words: "Mx, My and vertical force Fz; any motion",
        of: Model::ZeroMomentPoint,
        rows: &["Mx", "My", "Fz"],
        flat: false,
        thesis: "85",
    },
    Case {
        words: "whole wrench; any motion",
        of: Model::ZeroMomentPoint,
        rows: &["Fx", "Fy", "Fz", "Mx", "My", "Mz"],
        flat: false,
        thesis: "",
    },
    Case {
        words: "Mx, My, Fz; swing foot flat",
        of: Model::ZeroMomentPoint,
        rows: &["Mx", "My", "Fz"],
        flat: true,
        thesis: "",
    },
];

fn main() -> Result<(), Failure> {
    let robot = tulip()?;
    let ask = |of, rows: &[&str], flat, list| -> Result<BaseParameters, Failure> {
        let rows = rows.iter().map(|row| (*row).to_owned()).collect();
        let question = Question { rows, feet_flat: flat, list, ..Question::new(of) };
        question.answer(&robot.description).map_err(one)
    };
    println!("TUlip stands on its right foot; exact arithmetic, no rank tolerance.\n");
    println!("| model | parameters that appear | base parameters | thesis |\n|---|---|---|---|");
    let mut answers = Vec::new();
    for case in &CASES {
        let answer = ask(case.of, case.rows, case.flat, None)?;
        println!(
            "| {} | {} of {} | **{}** | {} |",
            case.words,
            answer.appearing(),
            answer.columns.len(),
            answer.rank,
            case.thesis
        );
        answers.push(answer);
    }
    // The thesis counts sixteen per link; the stance foot's mass appears with the vertical force only.
    let sixteen = ask(Model::ZeroMomentPoint, &["Mx", "My", "Fz"], false, Some(ParameterList::Thesis16))?;
    println!(
        "| Mx, My, Fz with 16 parameters per link | {} of {} | **{}** | 190 appear, 85 |",
        sixteen.appearing(),
        sixteen.columns.len(),
        sixteen.rank
    );
    println!(
        "\nWith the total mass known, centre of pressure and vertical force tell 84: the 85th is the mass, which Fz tells."
    );
    for (index, title) in [
        (0, "The 27 of the centre of mass"),
        (2, "The 25 with flat feet"),
        (5, "The 85 of the zero moment point"),
    ] {
        println!("\n## {title}\n\n| | value of the URDF | unit | sum |\n|---|---|---|---|");
        for (k, parameter) in answers[index].parameters.iter().enumerate() {
            println!("| {} | {:.6} | {} | `{}` |", k + 1, parameter.value, parameter.unit, parameter.text);
        }
    }
    Ok(())
}
