//! The tables, in Markdown.
use crate::run::{Failure, failure};
use crate::simulation::Drive;
use crate::thesis;
use serde_json::Value;
use std::fmt::Write;

/// True values of drives: joint, parameter, value.
pub struct Truth(Vec<(String, String, f64)>);

impl Truth {
    /// From `truth.json` of an example.
    ///
    /// # Errors
    /// It is not such a file.
    pub fn read(text: &str) -> Result<Self, Failure> {
        let value: Value = serde_json::from_str(text).map_err(|e| failure(format!("truth.json: {e}")))?;
        let mut all = Vec::new();
        for effect in value["effects"].as_array().into_iter().flatten() {
            for (name, value) in effect["parameters"].as_object().into_iter().flatten() {
                let joint = effect["joint"].as_str().unwrap_or_default().to_owned();
                all.push((joint, name.clone(), value.as_f64().unwrap_or(f64::NAN)));
            }
        }
        Ok(Self(all))
    }

    /// Of simulated drives.
    pub fn of(joints: &[&str], drives: &[Drive]) -> Self {
        let of = |(joint, drive): (&&str, &Drive)| {
            let spring = drive.spring.map(|[_, _, stiffness]| ("spring_stiffness", stiffness));
            let friction = [("viscous_friction", drive.viscous), ("coulomb_friction", drive.coulomb)];
            let all = friction.into_iter().chain(spring);
            all.map(|(name, value)| ((*joint).to_owned(), name.to_owned(), value)).collect::<Vec<_>>()
        };
        Self(joints.iter().zip(drives).flat_map(of).collect())
    }

    fn value(&self, joint: &str, name: &str) -> Option<f64> {
        self.0.iter().find(|(j, n, _)| j == joint && n == name).map(|(_, _, value)| *value)
    }
}

/// One leg and what was found of it.
pub struct Case {
    pub name: &'static str,
    pub truth: Truth,
    pub answer: Value,
}

/// The whole page.
///
/// # Errors
/// An answer without a number that belongs into a table.
pub fn page(cases: &[Case], steps: &str) -> Result<String, Failure> {
    let mut out = String::from(HEAD);
    let _ = writeln!(
        out,
        "Both regressions: `--steps {steps}`. Errors are estimate over truth; ± is one standard error.\n"
    );
    let _ = writeln!(
        out,
        "## Table 8.1: friction and springs of the elastic drives (motor shaft; stiffness in the cable)\n"
    );
    drives(&mut out, cases, &thesis::DRIVES)?;
    let _ = writeln!(out, "\n## Table 8.2, last rows: friction of the stiff drives (motor shaft)\n");
    drives(&mut out, cases, &thesis::STIFF)?;
    let _ = writeln!(out, "\n{BODIES}");
    for (combination, value, deviation) in thesis::BODIES {
        let _ = writeln!(
            out,
            "| `{combination}` | {value} | {deviation} | {:.0} % |",
            100.0 * deviation / value.abs()
        );
    }
    for case in cases {
        bodies(&mut out, case)?;
        held_out(&mut out, case)?;
    }
    verdict(&mut out, cases)?;
    Ok(out)
}

const HEAD: &str = "\
# Tables 8.1 and 8.2: the series elastic leg

Output of `cargo build --release && cargo run --release --example elastic_leg`. The thesis estimated the real leg of TUlip version 1, with 2000 samples
that are not public: its numbers stand here for comparison of sizes and of error bars, no simulated leg can have them. Both
simulated legs have the bodies of `robots/tulip_v1_leg`, encoders of 2000 counts per motor turn and 30000 per joint
turn, 500 Hz, currents with 5 mA of noise, stiction, and drives off by factors from 0.8 to 1.25. Cut-off and `--slow` are the
defaults; that of `--slow` was chosen with the first leg's training log at hand, before the second leg existed.

";

const BODIES: &str = "\
## Table 8.2: bodies

The thesis' model of the leg has fewer parameters (its inertias are about one axis each and its hip bodies lie on the axes), so
that its 14 combinations have no one-to-one counterpart among the base parameters of the full URDF below. Printed:

| combination | estimate | std. dev. | relative |
|---|---|---|---|";

fn parameter<'a>(answer: &'a Value, joint: &str, name: &str) -> Result<&'a Value, Failure> {
    let drives = answer["drives"]["joints"].as_array();
    let drive = drives.and_then(|all| all.iter().find(|d| d["joint"] == joint));
    let found = drive.and_then(|d| d["parameters"].as_array()?.iter().find(|p| p["name"] == name));
    found.ok_or_else(|| failure(format!("the answer has no {name} of {joint}")))
}

fn number(value: &Value, key: &str) -> Result<f64, Failure> {
    value[key].as_f64().ok_or_else(|| failure(format!("no number `{key}` in {value}")))
}

fn drives(out: &mut String, cases: &[Case], printed: &[(&str, &str, f64, f64)]) -> Result<(), Failure> {
    let _ = write!(out, "| drive | parameter | unit | thesis ± std. dev. |");
    for case in cases {
        let _ = write!(out, " {}: truth | found ± | error |", case.name);
    }
    let _ = writeln!(out, "\n|---|---|---|---|{}", "---|---|---|".repeat(cases.len()));
    for (joint, name, value, deviation) in printed {
        let unit = parameter(&cases[0].answer, joint, name)?["unit"].as_str().unwrap_or_default().to_owned();
        let _ = write!(out, "| {joint} | {name} | {unit} | {value} ± {deviation} |");
        for case in cases {
            let found = parameter(&case.answer, joint, name)?;
            let (estimate, error) = (number(found, "value")?, number(found, "standard_error")?);
            let truth = case
                .truth
                .value(joint, name)
                .ok_or_else(|| failure(format!("no truth of {joint} {name}")))?;
            let _ = write!(
                out,
                " {} | {} ± {} | {:+.2} % |",
                short(truth),
                short(estimate),
                short_error(error),
                100.0 * (estimate / truth - 1.0)
            );
        }
        let _ = writeln!(out);
    }
    Ok(())
}

fn short(x: f64) -> String {
    if x.abs() >= 1000.0 {
        format!("{x:.0}")
    } else if x.abs() >= 1e-3 {
        format!("{x:.6}")
    } else {
        format!("{x:.3e}")
    }
}

fn short_error(x: f64) -> String {
    if x >= 10.0 { format!("{x:.0}") } else { format!("{x:.1e}") }
}

fn bodies(out: &mut String, case: &Case) -> Result<(), Failure> {
    let _ =
        writeln!(out, "\n### {}: base parameters of the full model (truth: those of the URDF)\n", case.name);
    let _ = writeln!(
        out,
        "| base parameter | unit | truth | found ± | away, std. errors |\n|---|---|---|---|---|"
    );
    let mut within = [0; 3];
    for p in case.answer["parameters"].as_array().into_iter().flatten() {
        let unit = p["unit"].as_str().unwrap_or_default();
        if !unit.starts_with("kg") {
            continue;
        }
        let [value, truth, error] =
            [number(p, "value")?, number(p, "nominal")?, number(p, "standard_error")?];
        let away = (value - truth) / error;
        within[0] += 1;
        within[1] += usize::from(away.abs() < 1.0);
        within[2] += usize::from(away.abs() < 2.0);
        let name = p["name"].as_str().unwrap_or_default();
        let digits = (1.0 - error.log10().floor()).clamp(2.0, 9.0) as usize;
        let _ = writeln!(
            out,
            "| `{name}` | {unit} | {truth:.digits$} | {value:.digits$} ± {error:.digits$} | {away:+.1} |"
        );
    }
    let [all, one, two] = within;
    let _ = writeln!(out, "\n{one} of {all} within one standard error of the truth, {two} within two.");
    Ok(())
}

fn held_out(out: &mut String, case: &Case) -> Result<(), Failure> {
    let _ = writeln!(out, "\n### {}: another motion, predicted (root mean squares, N m)\n", case.name);
    let _ = writeln!(
        out,
        "| torque | measured | missed by the description | missed by the estimate |\n|---|---|---|---|"
    );
    for drive in case.answer["drives"]["joints"].as_array().into_iter().flatten() {
        let errors = &drive["validation"];
        if errors.is_object() {
            let [measured, described, estimated] =
                [number(errors, "measured")?, number(errors, "described")?, number(errors, "estimated")?];
            let joint = drive["joint"].as_str().unwrap_or_default();
            let _ = writeln!(
                out,
                "| motor of {joint} | {measured:.5} | {described:.5} | {estimated:.6} ({:.2} %) |",
                100.0 * estimated / measured
            );
        }
    }
    for channel in case.answer["validation"]["channels"].as_array().into_iter().flatten() {
        let measured = number(channel, "measured")?;
        let [described, fitted] =
            [number(&channel["rms"], "description")?, number(&channel["rms"], "least_squares")?];
        let joint = channel["name"].as_str().unwrap_or_default();
        let _ = writeln!(
            out,
            "| joint {joint} | {measured:.4} | {described:.4} | {fitted:.4} ({:.2} %) |",
            100.0 * fitted / measured
        );
    }
    let total = &case.answer["validation"]["total"];
    let _ = writeln!(
        out,
        "\nAll joints together: {:.2} % missed by the description (true bodies, described friction), {:.2} % by the estimate.",
        100.0 * number(total, "description")?,
        100.0 * number(total, "least_squares")?
    );
    Ok(())
}

/// Whether stiffness came out within 1 % and friction within 5 %.
fn verdict(out: &mut String, cases: &[Case]) -> Result<(), Failure> {
    let _ = writeln!(
        out,
        "\n## Wanted and reached\n\n| leg | springs within 1 % | friction within 5 % | worst spring | worst friction |\n|---|---|---|---|---|"
    );
    for case in cases {
        let mut away = [Vec::new(), Vec::new()];
        for (joint, name, truth) in &case.truth.0 {
            let value = number(parameter(&case.answer, joint, name)?, "value")?;
            away[usize::from(name != "spring_stiffness")].push((value / truth - 1.0).abs());
        }
        let [springs, friction] = away.each_ref().map(|list| list.iter().copied().fold(0.0, f64::max));
        let count = |list: &[f64], bound: f64| {
            format!("{} of {}", list.iter().filter(|x| **x < bound).count(), list.len())
        };
        let _ = writeln!(
            out,
            "| {} | {} | {} | {:.2} % | {:.2} % |",
            case.name,
            count(&away[0], 0.01),
            count(&away[1], 0.05),
            100.0 * springs,
            100.0 * friction
        );
    }
    Ok(())
}
